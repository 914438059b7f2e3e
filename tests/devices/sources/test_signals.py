"""`plant.signals`: wires that live by themselves."""

from random import Random

from fieldrig import MS, S
from fieldrig.clock import VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.wires import Signal
from fieldrig_devices.sources.signals import Signals, SignalsSettings

SETTINGS = {
    "signals": {
        "door": {"source": {"kind": "square", "period_ms": 10.0, "high_percent": 20.0}, "digital": True},
        "level": {
            "source": {"kind": "ramp", "first": 0.0, "last": 1.0, "period_ms": 4.0, "every_ms": 2.0},
            "unit": "m",
        },
        "rain": {"source": {"kind": "constant", "value": 3.0}, "unit": "mm"},
    }
}


def bench() -> tuple[VirtualClock, RecordedLink[Signal], Signals]:
    clock, wires = VirtualClock(), RecordedLink[Signal]()
    device = Signals(clock, SignalsSettings.model_validate(SETTINGS), wires, Random(1))
    device.start()
    return clock, wires, device


def test_each_change_is_sent_at_its_instant_and_nothing_else() -> None:
    clock, wires, device = bench()
    assert wires.take() == [Signal("door", True), Signal("level", 0.0, "m"), Signal("rain", 3.0, "mm")]
    sent = []
    for now_ms in range(1, 11):
        clock.advance_to(now_ms * MS)
        sent += [(now_ms, signal.name, signal.value) for signal in wires.take() if signal.name == "door"]
    assert sent == [(2, "door", False), (10, "door", True)]
    assert device.points()["level"].read() == 0.5


def test_points_show_the_present_value_and_cannot_be_written() -> None:
    clock, _, device = bench()
    clock.advance_to(1 * S + 2 * MS)
    points = device.points()
    assert {name: point.read() for name, point in points.items()} == {"door": False, "level": 0.5, "rain": 3}
    assert all(point.write is None for point in points.values())
    assert points["level"].unit == "m"


def test_power_on_begins_again() -> None:
    clock, wires, device = bench()
    clock.advance_to(3 * MS)
    wires.take()
    device.start()
    assert Signal("door", True) in wires.take()
