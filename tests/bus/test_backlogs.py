"""One member cannot make a bus hold an unlimited number of messages."""

import pytest

from fieldrig_bus.modbus.framing import LineTiming
from fieldrig_bus.modbus.line_model import MOST_WANTED, LineModel
from fieldrig_bus.modbus.message import ModbusRequest
from fieldrig_bus.serial.message import Format
from fieldrig_bus.serial.model import LONGEST_BACKLOG_NS, SerialModel
from fieldrig_bus.wires import MOST_OF_A_MEMBER, Signal, WiresModel


@pytest.mark.long
def test_a_serial_line_takes_an_hour_ahead_and_no_more() -> None:
    model = SerialModel(Format(300))
    for member in ("io", "panel"):
        model.join(member)
        model.listen(0, member, None)
    for _ in range(200):  # 33 s each
        model.submit(0, "io", bytes(1000))
    last_ns = max(delivery.time_ns for delivery in model.collect(1 << 60))
    assert LONGEST_BACKLOG_NS < last_ns < LONGEST_BACKLOG_NS + 40_000_000_000
    model.submit(last_ns, "io", b"x")
    assert [delivery.message for delivery in model.collect(1 << 60)] == [b"x"]


def test_a_modbus_line_keeps_so_many_requests_waiting() -> None:
    model = LineModel(LineTiming("rtu", 9600, 11), 1_000_000_000)
    model.join("client")
    for number in range(MOST_WANTED + 50):
        model.submit(0, "client", ModbusRequest(1, b"\x03\x00\x00\x00\x01", number))
    assert len(model._wanted) == MOST_WANTED


def test_wires_of_a_member_are_not_more_than_so_many() -> None:
    model = WiresModel()
    model.join("io")
    for number in range(MOST_OF_A_MEMBER + 5):
        model.submit(0, "io", Signal(f"w{number}", True))
    assert model.statistics(0) == {"wires": float(MOST_OF_A_MEMBER)}
    model.submit(0, "io", Signal("w0", False))
    assert model.collect(0)[-1].message == Signal("w0", False)
