"""The process image: bits and words of the terminals, copied when MAST begins and written when it has ended."""

import pytest

from fieldrig.clock import S, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.hmiscu.io import Terminals
from fieldrig_devices.hmiscu.settings import HmiscuSettings

TERMINALS = {
    "DI0": "start",
    "DI13": "door",
    "FI1": "mark",
    "DQ7": "lamp",
    "FQ0": "valve",
}
ANALOG = {
    "AI1": {"wire": "pressure", "unit": "bar", "low": 0.0, "high": 10.0},
    "TI0": {"wire": "heater.temperature", "unit": "degC"},
    "AQ1": {"wire": "pump.speed", "unit": "%", "low": 0.0, "high": 100.0},
}


class Bench:
    def __init__(self, **settings: object) -> None:
        self.clock = VirtualClock()
        self.wires = RecordedLink[Signal]()
        self.io = Terminals(self.clock, HmiscuSettings.model_validate(settings), self.wires)
        self.io.start()

    def driven(self) -> dict[str, object]:
        return {signal.name: signal.value for signal in self.wires.take()}


@pytest.mark.manual("SCU-095")
def test_inputs_are_in_the_image_after_the_copy_only() -> None:
    bench = Bench(terminals=TERMINALS)
    for wire in ("start", "door", "mark"):
        bench.wires.deliver(Signal(wire, True))
    assert bytes(bench.io.inputs[:4]) == bytes.fromhex("00 00 00 00")
    bench.io.take()
    assert bytes(bench.io.inputs[:4]) == bytes.fromhex("01 20 02 00")


@pytest.mark.manual("SCU-095")
def test_outputs_change_when_the_image_is_written() -> None:
    bench = Bench(terminals=TERMINALS)
    assert bench.driven() == {"lamp": False, "valve": False}
    bench.io.outputs[0] = 0x80
    bench.io.outputs[2] = 0x01
    assert bench.driven() == {}
    bench.io.give()
    assert bench.driven() == {"lamp": True, "valve": True}
    bench.io.give()
    assert bench.driven() == {}
    bench.io.fall()
    assert bench.driven() == {"lamp": False, "valve": False}


def test_analog_values_are_words_over_their_range() -> None:
    bench = Bench(model="HMISCU6B5", terminals=ANALOG)
    bench.wires.deliver(Signal("pressure", 5.0, "bar"))
    bench.wires.deliver(Signal("heater.temperature", 212.34, "degC"))
    bench.io.take()
    assert bytes(bench.io.inputs[6:10]) == bytes.fromhex("00 08 4b 08")  # 2048 in %IW3, 2123 in %IW4
    bench.driven()
    bench.io.outputs[6:8] = (4095).to_bytes(2, "little")
    bench.io.give()
    assert bench.driven() == {"pump.speed": 100.0}


@pytest.mark.parametrize(("bar", "raw"), [(-1.0, 0), (11.0, 4095)])
def test_an_analog_input_ends_at_its_range(bar: float, raw: int) -> None:
    bench = Bench(model="HMISCU6B5", terminals=ANALOG)
    bench.wires.deliver(Signal("pressure", bar, "bar"))
    assert bench.io.raw("AI1") == raw


def test_a_moving_signal_is_read_at_the_instant_of_the_copy() -> None:
    bench = Bench(model="HMISCU6B5", terminals=ANALOG)
    bench.wires.deliver(Motion("pressure", 0.0, "bar", 0, 5.0))
    bench.clock.advance_to(S)
    assert bench.io.raw("AI1") == 2048


@pytest.mark.manual("SCU-075")
def test_an_output_of_a_channel_is_not_in_the_image() -> None:
    bench = Bench(channel_0={"mode": "pwm"}, terminals=TERMINALS)
    bench.driven()
    bench.io.outputs[2] = 0x01
    bench.io.give()
    assert bench.driven() == {}
    assert "FQ0" not in dict(bench.io.points())


def test_an_input_without_a_wire_can_be_set() -> None:
    bench = Bench(terminals=TERMINALS)
    points = dict(bench.io.points())
    assert points["DI0"].write is None
    write = points["DI1"].write
    assert write is not None
    write(True)
    assert points["DI1"].read() is True
    with pytest.raises(ValueError, match="expected true or false"):
        write(7)
