"""Foreign masters at a Modbus bus with faults: pymodbus sees errors and recovers, and pyserial gets the very bytes."""

from collections.abc import Callable
from typing import Any

import pytest
import serial
from modbus_bench import RealBench, real_bench, rtu, rtu_bus, tcp_bus
from pymodbus.client import ModbusTcpClient
from pymodbus.exceptions import ModbusException

pytestmark = [pytest.mark.real, pytest.mark.system]

OPEN: Any = getattr(serial, "Serial")  # noqa: B009  it has no types
READ, ANSWER = bytes.fromhex("03 006B 0003"), bytes.fromhex("03 06 022B 0000 0064")


def at_pymodbus(bench: RealBench, work: Callable[[Any], None]) -> None:
    def run() -> None:
        client: Any = ModbusTcpClient("127.0.0.1", port=bench.port, timeout=0.5, retries=0)
        try:
            assert client.connect()
            work(client)
        finally:
            client.close()

    bench.in_thread(run)


def read(client: Any) -> list[int] | int | str:
    """The registers, or the exception code, or "lost"."""
    try:
        answer = client.read_holding_registers(0x6B, count=3, device_id=1)
    except ModbusException:
        return "lost"
    return answer.exception_code if answer.isError() else list(answer.registers)


@pytest.mark.parametrize(
    ("fault", "sees"),
    [
        ({"what": "drop"}, "lost"),
        ({"what": "drop", "of": "request"}, "lost"),
        ({"what": "delay", "delay_ms": 100}, [0x22B, 0, 100]),
        ({"what": "exception", "code": 6}, 6),
        ({"what": "replace", "data": "06 0001 0002 0003"}, [1, 2, 3]),
        ({"what": "wrong_unit"}, "lost"),
        ({"what": "wrong_transaction"}, "lost"),
        ({"what": "truncate"}, "lost"),
        ({"what": "split", "gap_ms": 30}, [0x22B, 0, 100]),
        ({"what": "cut"}, "lost"),
    ],
    ids=str,
)
def test_pymodbus_sees_the_fault_and_works_again_on_a_new_connection(fault: dict[str, Any], sees: Any) -> None:
    with real_bench(tcp_bus(faults=[{**fault, "count": 1}])) as bench:
        at_pymodbus(bench, lambda client: check(read(client), sees))
        at_pymodbus(bench, lambda client: check(read(client), [0x22B, 0, 100]))
        assert bench.hub.faults()[1]["applied"] == 1


def check(found: Any, wanted: Any) -> None:
    assert found == wanted


def is_reached(bench: RealBench) -> bool:
    try:
        bench.connect()
    except ConnectionRefusedError:
        return False
    return True


def test_a_connection_is_refused_by_the_system_while_the_fault_is_on() -> None:
    with real_bench(tcp_bus()) as bench:
        number = bench.hub.add_fault({"what": "refuse"})
        with pytest.raises(ConnectionRefusedError):
            bench.connect()
        bench.hub.clear_fault(number)
        bench.pump(lambda: is_reached(bench))
        at_pymodbus(bench, lambda client: check(read(client), [0x22B, 0, 100]))


def test_a_refused_connection_is_closed_before_the_first_request() -> None:
    with real_bench(tcp_bus(faults=[{"what": "refuse", "count": 1}])) as bench:
        assert bench.connect().read_end() == b""
        at_pymodbus(bench, lambda client: check(read(client), [0x22B, 0, 100]))


@pytest.mark.parametrize(
    ("fault", "heard"),
    [
        ({"what": "wrong_crc"}, rtu(1, ANSWER)[:-2] + bytes(byte ^ 0xFF for byte in rtu(1, ANSWER)[-2:])),
        ({"what": "garbage", "data": "00 FE"}, b"\x00\xfe" + rtu(1, ANSWER)),
        ({"what": "truncate", "keep": 4}, rtu(1, ANSWER)[:4]),
        ({"what": "duplicate"}, 2 * rtu(1, ANSWER)),
    ],
    ids=str,
)
def test_pyserial_gets_the_bytes_of_the_fault(fault: dict[str, Any], heard: bytes) -> None:
    with real_bench(rtu_bus(faults=[fault])) as bench:

        def ask() -> bytes:
            with OPEN(str(bench.run / "line"), 115200, timeout=10) as port:
                port.write(rtu(1, READ))
                found: bytes = port.read(len(heard))
                return found

        assert bench.in_thread(ask) == heard
