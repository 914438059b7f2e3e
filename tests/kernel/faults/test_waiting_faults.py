"""Faults of a process in real time that wait for points of its devices, on a clock that the test moves."""

from typing import Any, ClassVar, Literal

import pytest

from fieldrig.clock import MS, Clock, VirtualClock
from fieldrig.device import Device, Point
from fieldrig.errors import ControlError, RigError
from fieldrig.faults.faults import Fault, Faults, Timed
from fieldrig.faults.injected import InjectedFaults
from fieldrig.faults.waiting import WaitingFaults
from fieldrig.loop.real_clock import DeviceClock
from fieldrig.real.process_points import ProcessPoints
from fieldrig.real.switched import Switched


class Mute(Timed):
    """It says nothing."""

    what: Literal["mute"]


class Counter(Device):
    """Counts to ten at once, every 10 ms."""

    fault_models: ClassVar[Any] = {"mute": Mute}

    def __init__(self, clock: Clock, *given: Mute) -> None:
        self._clock, self.count = clock, 0
        self.injected = InjectedFaults[Fault[Mute]](clock, self.fault_models, Faults(Fault))
        for fault in given:
            self.injected.add(fault)

    def start(self) -> None:
        self._clock.call_at(self._clock.now_ns() + 10 * MS, self.step)

    def step(self) -> None:
        for _ in range(10):
            self.count += 1
            if self.look is not None:
                self.look()
        self.start()

    def points(self) -> dict[str, Point]:
        return {"count": Point(lambda: self.count), "ms": Point(lambda: self._clock.now_ns() / MS)}


class Bench:
    def __init__(self, *given: Mute) -> None:
        self.clock, self._given = VirtualClock(), given
        devices: dict[str, Switched] = {}
        points = ProcessPoints("home", devices, {}, lambda _: ())
        self.waiting = WaitingFaults(self.clock, points, points.tell)
        self.device = devices["io"] = Switched("io", self.clock, self._built, (), self._cancel, self.waiting)
        self.device.start()

    def _built(self) -> Counter:
        clock: Any = DeviceClock(self.clock, "io")  # type: ignore[arg-type]
        return Counter(clock, *self._given)

    def _cancel(self) -> None:
        for _, _, timer in self.clock._timers.heap:
            if timer.owner == "io":
                timer.cancel()

    def state(self, number: int = 1) -> str:
        return str(self.device.faults()[number]["state"])

    def run_until(self, ms: int) -> None:
        self.clock.advance_to(ms * MS)


@pytest.mark.parametrize(
    ("when", "ms"),
    [
        ("io/count > 15", 20),
        ("io/count == 17", 20),  # between two values that a timer would see
        ("io/ms >= 7.5", 8),  # changes without an event
        ("io/count < 5", 0),
    ],
)
def test_a_fault_begins_within_a_millisecond_of_its_condition(when: str, ms: int) -> None:
    bench = Bench()
    bench.device.add_fault({"what": "mute", "when": when, "duration_ms": 5})
    bench.run_until(max(ms - 1, 0))
    assert bench.state() == ("waiting" if ms else "on")
    bench.run_until(ms + 1)
    assert bench.state() == "on"
    bench.run_until(ms + 6)
    assert bench.state() == "over"


def test_power_is_lost_at_a_condition_and_a_fault_waits_through_it() -> None:
    bench = Bench()
    bench.device.add_fault({"what": "power_off", "when": "io/count >= 10", "duration_ms": 30})
    bench.device.add_fault({"what": "mute", "when": "io/count == 13"})
    bench.run_until(12)
    assert (bench.state(1), bench.state(2)) == ("on", "waiting")
    bench.run_until(45)
    assert (bench.state(1), bench.state(2)) == ("over", "waiting")
    bench.run_until(70)  # it counts from 0 again, 20 ms after its power is back
    assert bench.state(2) == "on"


def test_a_fault_that_was_cleared_begins_no_more() -> None:
    bench = Bench()
    number = bench.device.add_fault({"what": "mute", "when": "io/count > 15"})
    bench.device.clear_fault(number)
    bench.run_until(30)
    assert bench.device.faults() == {}


def test_faults_from_the_start_wait_too() -> None:
    bench = Bench(Mute(what="mute", when="io/count > 15"))
    bench.waiting.arm_all()
    assert bench.state() == "waiting"
    bench.run_until(22)
    assert bench.state() == "on"


@pytest.mark.parametrize(
    ("when", "what"), [("of/count > 1", "of is no device of the process home"), ("io/cuont > 1", "io has no")]
)
def test_what_the_process_cannot_know_is_refused(when: str, what: str) -> None:
    bench = Bench()
    with pytest.raises(ControlError, match=what):
        bench.device.add_fault({"what": "mute", "when": when})
    assert bench.device.faults() == {}
    with pytest.raises(RigError, match=f"io: fault 1: {what}"):
        Bench(Mute(what="mute", when=when)).waiting.arm_all()
