"""Every Modbus link keeps the same promises: the answers of the application protocol, regardless of its kind.

Another link needs a backend: a context manager that yields an object with `exchange(request, response)`.
"""

import tempfile
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Protocol

import pytest
from modbus_bench import (
    Master,
    RealBench,
    VirtualMaster,
    Wire,
    ascii_,
    ascii_bus,
    mbap,
    real_bench,
    rtu,
    rtu_bus,
    tcp_bus,
)
from modbus_cases import CASES, Case

from fieldrig_bus.modbus.kind import ModbusBus
from fieldrig_bus.modbus.virtual import ModbusVirtualSettings


class Asks(Protocol):
    def exchange(self, request: str, response: str, unit: int = 1) -> None: ...


def virtual(settings: ModbusVirtualSettings) -> Callable[[], AbstractContextManager[Asks]]:
    @contextmanager
    def backend() -> Iterator[Asks]:
        with tempfile.TemporaryDirectory(prefix="fieldrig-") as folder:
            yield VirtualMaster(Path(folder), settings)

    return backend


def real(
    make_bus: Callable[[], ModbusBus],
    connect: Callable[[RealBench], Wire],
    frame: Callable[[int, bytes], bytes],
) -> Callable[[], AbstractContextManager[Asks]]:
    @contextmanager
    def backend() -> Iterator[Asks]:
        with real_bench(make_bus()) as bench:
            yield Master(connect(bench), frame)

    return backend


BACKENDS = {
    "virtual": virtual(ModbusVirtualSettings()),
    "virtual rtu": virtual(ModbusVirtualSettings(baud=19200)),
    "virtual ascii": virtual(ModbusVirtualSettings(baud=19200, mode="ascii")),
    "tcp": real(tcp_bus, RealBench.connect, lambda unit, pdu: mbap(0x1234, unit, pdu)),
    "rtu pty": real(rtu_bus, RealBench.open_pty, rtu),
    "rtu tcp": real(lambda: rtu_bus(pty=None, listen="127.0.0.1:0"), RealBench.connect, rtu),
    "ascii pty": real(ascii_bus, RealBench.open_pty, ascii_),
    "ascii tcp": real(lambda: ascii_bus(pty=None, listen="127.0.0.1:0"), RealBench.connect, ascii_),
}
LINES = [name for name in BACKENDS if name not in ("virtual", "tcp")]


@pytest.mark.system
@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.says)
def test_answers_are_those_of_the_specification(backend: str, case: Case) -> None:
    with BACKENDS[backend]() as link:
        for request, response in case.steps:
            link.exchange(request, response)


@pytest.mark.system
@pytest.mark.parametrize("backend", LINES)
def test_a_broadcast_is_acted_on_and_not_answered(backend: str) -> None:
    with BACKENDS[backend]() as link:
        link.exchange("06 0001 0003", "", unit=0)
        link.exchange("05 00AC FF00", "", unit=0)
        link.exchange("03 0001 0001", "", unit=0)
        link.exchange("03 0001 0001", "03 02 0003")
        link.exchange("01 00AC 0001", "01 01 01")
        link.exchange("08 000F 0000", "08 000F 0003")


@pytest.mark.system
@pytest.mark.parametrize("backend", LINES)
def test_a_request_for_another_unit_is_not_answered(backend: str) -> None:
    with BACKENDS[backend]() as link:
        link.exchange("06 0001 0009", "", unit=2)
        link.exchange("03 0001 0001", "03 02 0000")


@pytest.mark.system
@pytest.mark.parametrize("backend", [name for name in LINES if "virtual" in name])
def test_in_listen_only_mode_nothing_is_done_until_communications_restart(backend: str) -> None:
    with BACKENDS[backend]() as link:
        link.exchange("08 0004 0000", "")
        link.exchange("06 0001 0003", "")
        link.exchange("06 0001 0003", "", unit=0)
        link.exchange("08 000F 0000", "")
        link.exchange("08 0001 0000", "")
        link.exchange("03 0001 0001", "03 02 0000")
        link.exchange("08 000E 0000", "08 000E 0002")


@pytest.mark.system
@pytest.mark.parametrize("backend", ["virtual", "tcp"])
def test_without_a_line_there_is_no_port_to_silence(backend: str) -> None:
    with BACKENDS[backend]() as link:
        link.exchange("08 0004 0000", "88 01")
        link.exchange("08 0003 0D00", "88 01")
