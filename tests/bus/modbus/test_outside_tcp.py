"""Outside servers that devices on `modbus.tcp` use: Modbus messaging on TCP/IP guide V1.0b, 4.2 and 4.4."""

import logging
import socket
from typing import Any

import pytest
from modbus_bench import mbap
from modbus_outside import Listener, OutsideBench, listener, outside_bench
from pydantic import ValidationError

from fieldrig_bus.modbus import dialler, outside
from fieldrig_bus.modbus.dialler import pause_s
from fieldrig_bus.modbus.message import ClientConnected, ModbusMessage, ModbusRequest
from fieldrig_bus.modbus.tcp import ModbusTcp, ModbusTcpSettings

pytestmark = pytest.mark.system

READ = "03 006B 0003"
ANSWER = "03 06 02 2b 00 00 00 64"


def bus(servers: dict[int, Any], **settings: Any) -> ModbusTcp:
    return ModbusTcp("mb", ModbusTcpSettings(listen="127.0.0.1:0", servers=servers, **settings))


def asked(bench: OutsideBench, at: Listener, number: int = 1) -> Any:
    """A connection that has brought the request for unit 7, with this transaction number."""
    end = at.accept(bench)
    assert end.read(12) == mbap(number, 7, bytes.fromhex(READ))
    return end


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dialler, "FIRST_PAUSE_S", 0.01)


def test_a_device_asks_a_server_outside() -> None:
    with listener() as at, outside_bench(bus({7: at.address})) as bench:
        exchange = bench.ask(7, READ)
        asked(bench, at).write(mbap(1, 7, bytes.fromhex(ANSWER)))
        assert bench.expect() == [(7, exchange, ANSWER)]


def test_nothing_is_sent_before_the_first_request() -> None:
    with listener() as at, outside_bench(bus({7: at.address})) as bench:
        bench.ask(8, READ)
        assert bench.expect() == [(8, 1, "83 0b")]  # a unit that no server has
        bench.wait_ms(30)
        assert not at.is_asked()


def test_units_of_one_address_share_its_connection_and_may_have_other_ids_there() -> None:
    with listener() as at:
        servers = {
            7: at.address,
            8: {"address": at.address, "unit": 1},
            9: {"address": f"tcp://{at.address}", "unit": 255},
        }
        with outside_bench(bus(servers)) as bench:
            for unit in servers:
                bench.ask(unit, READ)
            end = at.accept(bench)
            pdu = bytes.fromhex(READ)
            assert end.read(36) == mbap(1, 7, pdu) + mbap(2, 1, pdu) + mbap(3, 255, pdu)
            for number, unit in ((3, 255), (2, 1), (1, 7)):
                end.write(mbap(number, unit, bytes.fromhex(ANSWER)))
            assert bench.expect(3) == [(9, 3, ANSWER), (8, 2, ANSWER), (7, 1, ANSWER)]
            assert not at.is_asked()


def test_late_wrong_and_foreign_responses_are_ignored() -> None:
    with listener() as at, outside_bench(bus({7: at.address}, response_timeout_ms=60)) as bench:
        bench.ask(7, READ)
        end = asked(bench, at)
        answer = bytes.fromhex(ANSWER)
        for number, unit in ((2, 7), (1, 8), (0x101, 7)):
            end.write(mbap(number, unit, answer))
        end.write(bytes.fromhex("0001 0007 0003 07 83 02"))  # another protocol
        bench.wait_ms(80)  # beyond the response timeout
        end.write(mbap(1, 7, answer))
        second = bench.ask(7, READ)
        assert end.read(12) == mbap(2, 7, bytes.fromhex(READ))
        end.write(mbap(2, 7, answer))
        assert bench.expect() == [(7, second, ANSWER)]


def test_a_server_that_dies_is_found_again() -> None:
    with listener() as at, outside_bench(bus({7: at.address})) as bench:
        bench.ask(7, READ)
        end = asked(bench, at)
        end.write(mbap(1, 7, bytes.fromhex(ANSWER)))
        bench.expect()
        at.shut()
        end.close()
        bench.wait_ms(20)
        bench.ask(7, READ)
        bench.wait_ms(50)
        at.again()
        exchange = bench.ask(7, READ)
        again = at.accept(bench)
        again.read(12 * 2)  # the request that waited, and the new one: the numbers begin again
        again.write(mbap(2, 7, bytes.fromhex(ANSWER)))
        assert bench.expect() == [(7, exchange, ANSWER)]


def test_what_was_under_way_when_a_connection_broke_is_not_asked_again() -> None:
    with listener() as at, outside_bench(bus({7: at.address})) as bench:
        bench.ask(7, READ)
        asked(bench, at).close()
        bench.wait_ms(50)
        assert not at.is_asked()
        bench.ask(7, "03 0000 0001")
        assert at.accept(bench).read(12) == mbap(1, 7, bytes.fromhex("03 0000 0001"))


def test_what_waits_for_a_connection_is_given_up_after_the_response_timeout() -> None:
    with listener() as at, outside_bench(bus({7: at.address}, response_timeout_ms=40)) as bench:
        at.shut()
        bench.ask(7, READ)
        bench.wait_ms(60)
        at.again()
        bench.wait_ms(60)
        assert not at.is_asked()


def test_an_absent_server_is_reported_once_and_tried_with_growing_pauses(caplog: pytest.LogCaptureFixture) -> None:
    with listener() as at, outside_bench(bus({7: at.address}, response_timeout_ms=10_000)) as bench:
        at.shut()
        with caplog.at_level(logging.DEBUG, dialler.__name__):
            bench.ask(7, READ)
            bench.pump(lambda: len(caplog.records) >= 4)
            at.again()
            at.accept(bench).read(12)
        assert [record.levelname for record in caplog.records] == ["INFO", "DEBUG", "DEBUG", "DEBUG", "INFO"]
        assert f"mb: {at.address} cannot be reached: " in caplog.messages[0]
        assert caplog.messages[-1] == f"mb: {at.address} is connected"


def test_pauses_grow_up_to_eight_seconds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dialler, "FIRST_PAUSE_S", 0.25)
    assert [pause_s(failures) for failures in range(8)] == [0, 0.25, 0.5, 1, 2, 4, 8, 8]


def test_a_server_that_hangs_up_at_once_is_no_busy_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dialler, "FIRST_PAUSE_S", 0.02)
    with listener() as at, outside_bench(bus({7: at.address})) as bench:
        until_ns, hung_up = bench.clock.now_ns() + 100_000_000, 0

        def is_over() -> bool:
            nonlocal hung_up
            hung_up += at.is_asked()
            bench.ask(7, READ)
            return bench.clock.now_ns() >= until_ns

        bench.pump(is_over)
        assert 1 <= hung_up <= 4  # 0, 20, 60 ms


def test_a_connection_that_answers_no_more_is_closed() -> None:
    with listener() as at, outside_bench(bus({7: at.address}, response_timeout_ms=15)) as bench:
        bench.ask(7, READ)
        end = at.accept(bench)
        for _ in range(outside.MOST_SILENCE - 1):
            bench.wait_ms(20)
            assert end.is_open
            bench.ask(7, READ)
        end.until_closed()
        bench.ask(7, READ)
        assert at.accept(bench).read(12)[7:] == bytes.fromhex(READ)


def test_a_stream_that_is_no_modbus_is_closed() -> None:
    with listener() as at, outside_bench(bus({7: at.address})) as bench:
        bench.ask(7, READ)
        end = asked(bench, at)
        end.write(bytes.fromhex("0001 0000 FFFF 07"))
        end.until_closed()


def test_seventeen_requests_at_once_go_sixteen_and_one() -> None:
    with listener() as at, outside_bench(bus({7: at.address})) as bench:
        for _ in range(17):
            bench.ask(7, READ)
        end = at.accept(bench)
        end.read(16 * 12)
        bench.wait_ms(20)
        assert not end.received
        end.write(mbap(3, 7, bytes.fromhex(ANSWER)))
        assert end.read(12) == mbap(17, 7, bytes.fromhex(READ))
        assert bench.expect() == [(7, 3, ANSWER)]


def test_masters_at_the_bus_do_not_get_outside() -> None:
    with listener() as at, outside_bench(bus({7: at.address})) as bench:
        link = bench.hub.join("tcp:1")
        heard: list[ModbusMessage] = []
        link.on_receive(heard.append, ())
        link.send(ModbusRequest(7, bytes.fromhex(READ), 3))
        assert heard[0].pdu == bytes.fromhex("83 0B")
        bench.wait_ms(20)
        assert not at.is_asked()


@pytest.mark.manual("PD-283")
def test_a_device_is_notified_of_connections() -> None:
    with outside_bench(bus({})) as bench:
        notified: list[Any] = []
        bench.hub.join("device").on_receive(notified.append, [1, "connections"])
        port = bench.hub._ports[0].number
        with socket.create_connection(("127.0.0.1", port)):
            bench.pump(lambda: len(notified) == 1)
        with socket.create_connection(("127.0.0.1", port)):
            bench.pump(lambda: len(notified) == 2)
        assert notified == [ClientConnected("127.0.0.1")] * 2
        assert bench.heard == []  # a member that did not ask for connections is not notified


RIGHT = ["192.168.1.5:502", "plc-1.example.com:502", "tcp://PLC_2:1502", "[::1]:502", "localhost:65535"]
WRONG = [
    "192.168.1.5", "192.168.1.5:0", "192.168.1.5:65536", "192.168.1.300:502", "1.2.3:502", "plc 1:502", "-plc:502",
    ":502", "http://plc:502", "plc:502/1", "user@plc:502", "plc:502?x=1", "0.0.0.0:502", "[::]:502", "239.1.2.3:502",
    "255.255.255.255:502", "a" * 64 + ":502", 5020, "", "plc:modbus",
]  # fmt: skip


@pytest.mark.parametrize("address", RIGHT)
def test_addresses_of_servers(address: str) -> None:
    (port,) = outside.ports_of("mb", ModbusTcpSettings(servers={7: address}).servers, 1000)
    assert port._address == address.removeprefix("tcp://").lower()


@pytest.mark.parametrize("address", WRONG)
def test_what_is_no_address_of_a_server_is_refused(address: object) -> None:
    with pytest.raises(ValidationError):
        ModbusTcpSettings.model_validate({"servers": {7: address}})


def test_a_refused_address_says_what_would_be_right() -> None:
    with pytest.raises(ValidationError, match=r"expected HOST:PORT, such as 192\.168\.1\.5:502"):
        ModbusTcpSettings.model_validate({"servers": {7: "plc:0"}})


@pytest.mark.parametrize(
    ("listen", "server"),
    [
        ("127.0.0.1:5020", "127.0.0.1:5020"),
        ("127.0.0.1:5020", "localhost:5020"),
        ("0.0.0.0:5020", "127.0.0.1:5020"),
        ("10.0.0.9:5020", "10.0.0.9:5020"),
    ],
)
def test_a_bus_is_not_its_own_server(listen: str, server: str) -> None:
    with pytest.raises(ValidationError, match="is this bus itself"):
        ModbusTcpSettings(listen=listen, servers={7: server})


def test_another_port_or_host_is_another_server() -> None:
    for server in ("127.0.0.1:5021", "10.0.0.9:5020"):
        assert ModbusTcpSettings(listen="127.0.0.1:5020", servers={7: server}).servers


@pytest.mark.parametrize("unit", [0, 248, -1])
def test_unit_ids_of_servers_are_1_to_247(unit: int) -> None:
    with pytest.raises(ValidationError, match=f"{unit}: expected unit ids from 1 to 247"):
        ModbusTcpSettings.model_validate({"servers": {unit: "plc:502"}})
