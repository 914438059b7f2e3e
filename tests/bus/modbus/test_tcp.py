"""`modbus.tcp`: Modbus messaging on TCP/IP implementation guide V1.0b."""

import asyncio
import os
import socket

import pytest
from modbus_bench import Master, RealBench, Wire, mbap, real_bench, tcp_bus
from pydantic import ValidationError

from fieldrig.errors import BusError
from fieldrig_bus.modbus.tcp import ModbusTcp, ModbusTcpSettings

pytestmark = pytest.mark.system

READ = bytes.fromhex("03 006B 0003")
ANSWER = bytes.fromhex("03 06 022B 0000 0064")


def ask(bench: RealBench, unit: int, answer: bytes) -> None:
    wire = bench.connect()
    wire.write(mbap(7, unit, READ))
    assert wire.read(7 + len(answer)) == mbap(7, unit, answer)


def test_transactions_are_answered_by_their_numbers_and_may_be_pipelined() -> None:
    with real_bench(tcp_bus()) as bench:
        wire = bench.connect()
        wire.write(b"".join(mbap(number, 1, READ) for number in range(100)))
        wanted = b"".join(mbap(number, 1, ANSWER) for number in range(100))
        assert wire.read(len(wanted)) == wanted


def test_two_masters_may_use_the_same_transaction() -> None:
    with real_bench(tcp_bus(), turnaround_ms=1.0) as bench:
        first, second = bench.connect(), bench.connect()
        first.write(mbap(7, 1, READ))
        second.write(mbap(7, 1, bytes.fromhex("03 0001 0001")))
        assert first.read(15) == mbap(7, 1, ANSWER)
        assert second.read(11) == mbap(7, 1, bytes.fromhex("03 02 0000"))


@pytest.mark.parametrize("unit", [0, 1, 255])
def test_the_only_unit_answers_as_0_and_255_too(unit: int) -> None:
    with real_bench(tcp_bus()) as bench:
        ask(bench, unit, ANSWER)


def test_a_unit_that_is_not_there_is_a_gateway_target_that_fails() -> None:
    with real_bench(tcp_bus()) as bench:
        ask(bench, 2, bytes.fromhex("83 0B"))


def test_a_unit_that_is_not_there_may_be_silence() -> None:
    with real_bench(tcp_bus(unknown_unit="silence")) as bench:
        wire = bench.connect()
        wire.write(mbap(7, 2, READ))
        wire.write(mbap(8, 1, READ))
        assert wire.read(15) == mbap(8, 1, ANSWER)


def test_another_protocol_is_dropped_and_a_stream_out_of_step_closed() -> None:
    with real_bench(tcp_bus()) as bench:
        wire = bench.connect()
        wire.write(bytes.fromhex("0001 0001 0006 01 0300000001") + mbap(8, 1, READ))
        assert wire.read(15) == mbap(8, 1, ANSWER)
        wire.write(bytes.fromhex("0001 0000 FFFF 01"))
        assert wire.read_end() == b""


def test_one_master_too_many_closes_the_one_that_was_silent_longest() -> None:
    with real_bench(tcp_bus(max_connections=2)) as bench:
        first, second = bench.connect(), bench.connect()
        for wire in (first, second, first):
            Master(wire, lambda unit, pdu: mbap(1, unit, pdu)).exchange("03 006B 0003", ANSWER.hex())
        ask(bench, 1, ANSWER)
        assert second.read_end() == b""
        Master(first, lambda unit, pdu: mbap(1, unit, pdu)).exchange("03 006B 0003", ANSWER.hex())


def test_a_master_that_asks_no_more_gets_its_answers_and_then_the_end() -> None:
    with real_bench(tcp_bus(), turnaround_ms=5.0) as bench:
        wire = bench.connect()
        wire.write(mbap(7, 1, READ))
        with socket.socket(fileno=os.dup(wire.fd)) as half:
            half.shutdown(socket.SHUT_WR)
        assert wire.read_end() == mbap(7, 1, ANSWER)


def test_a_silent_connection_is_closed_when_so_set() -> None:
    with real_bench(tcp_bus(idle_timeout_s=0.05)) as bench:
        assert bench.connect().read_end() == b""


def test_a_master_that_does_not_read_is_not_read_either() -> None:
    with real_bench(tcp_bus()) as bench:
        wire = bench.connect()
        bench.loop.remove_reader(wire.fd)
        with pytest.raises(BlockingIOError):
            flood(bench, wire, 100_000_000)
        ask(bench, 1, ANSWER)


def flood(bench: RealBench, wire: Wire, most: int) -> None:
    """Send up to `most` bytes of requests without reading any answer."""
    questions, sent = mbap(1, 1, bytes.fromhex("03 03E8 007D")) * 500, 0
    while sent < most:
        sent += os.write(wire.fd, questions)
        bench.loop.run_until_complete(asyncio.sleep(0))


def test_a_port_that_is_taken_is_refused_with_a_remedy() -> None:
    with (
        real_bench(tcp_bus()) as bench,
        pytest.raises(BusError, match="another program"),
        real_bench(ModbusTcp("mb", ModbusTcpSettings(listen=f"127.0.0.1:{bench.port}"))),
    ):
        pass


@pytest.mark.parametrize("wrong", [{"listen": "5020"}, {"max_connections": 0}, {"unknown_unit": "answer"}])
def test_wrong_settings_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        ModbusTcpSettings.model_validate(wrong)
