"""The faults of a Modbus device itself, by the example of the application protocol V1.1b3, 6.3."""

from pathlib import Path
from typing import Any

import pytest
from modbus_bench import VirtualMaster

from fieldrig.clock import MS
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_bus.modbus.virtual import ModbusVirtualSettings

READ, ANSWER = "03 006B 0003", "03 06 022B 0000 0064"
WRITE, READ_BACK = "06 0001 0003", "03 0001 0001"


@pytest.fixture
def master(tmp_path: Path) -> VirtualMaster:
    return VirtualMaster(tmp_path, ModbusVirtualSettings())


@pytest.mark.parametrize(
    ("fault", "answers"),
    [
        ({"what": "silent"}, ["", ""]),
        ({"what": "silent", "function": 6}, [ANSWER, ""]),
        ({"what": "silent", "address": 0x6D}, ["", WRITE]),
        ({"what": "silent", "nth": 2}, [ANSWER, ""]),
        ({"what": "exception", "code": 6, "count": 1}, ["83 06", WRITE]),
        ({"what": "exception", "unit": 2}, [ANSWER, WRITE]),
    ],
    ids=str,
)
def test_what_it_answers(master: VirtualMaster, fault: dict[str, Any], answers: list[str]) -> None:
    master.device.add_fault(fault)
    for request, answer in zip((READ, WRITE), answers, strict=True):
        master.exchange(request, answer)


def test_what_is_refused_is_not_done_and_a_cleared_fault_is_gone(master: VirtualMaster) -> None:
    number = master.device.add_fault({"what": "exception"})
    master.exchange(WRITE, "86 04")
    assert master.device.faults()[number]["applied"] == 1
    master.device.clear_fault(number)
    master.exchange(READ_BACK, "03 02 0000")


def test_a_slow_device_answers_later(master: VirtualMaster) -> None:
    master.device.add_fault({"what": "slow", "delay_ms": 250})
    master.link.send(ModbusRequest(1, bytes.fromhex(READ), 7))
    master.run()
    ((heard_ns, answer),) = master.heard
    assert (heard_ns // MS, answer) == (250, ModbusResponse(1, bytes.fromhex(ANSWER), 7))
