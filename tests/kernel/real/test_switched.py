"""A device in real time that is switched off and on: its timers, its end of a bus, its faults."""

from typing import Any, ClassVar, Literal

import pytest

from fieldrig.clock import MS, Clock, VirtualClock
from fieldrig.device import Device
from fieldrig.errors import ControlError
from fieldrig.faults.faults import Fault, Faults, Timed
from fieldrig.faults.injected import InjectedFaults
from fieldrig.link import Link
from fieldrig.loop.real_clock import DeviceClock
from fieldrig.real.switched import Switched
from fieldrig.testing import RecordedLink


class Mute(Timed):
    """It sends nothing."""

    what: Literal["mute"]


class Beacon(Device):
    """Counts, and sends the count every 10 ms."""

    fault_models: ClassVar[Any] = {"mute": Mute}

    def __init__(self, clock: Clock, line: Link[int]) -> None:
        self._clock, self._line, self._count = clock, line, 0
        self.heard: list[int] = []
        self.injected = InjectedFaults[Fault[Mute]](clock, self.fault_models, Faults(Fault))
        self.injected.also(lambda: line.on_receive(self.heard.append))
        line.on_receive(self.heard.append)

    def start(self) -> None:
        self._count += 1
        if self.injected is not None and self.injected.first(Mute) is None:
            self._line.send(self._count)
        self._clock.call_at(self._clock.now_ns() + 10 * MS, self.start)


class PoweredLink(RecordedLink[int]):
    """An end whose hub gets the state of the power."""

    def __init__(self) -> None:
        super().__init__()
        self.told: list[bool] = []

    def switch(self, is_on: bool) -> None:
        self.told.append(is_on)


class Bench:
    """The clock of a process, whose timers have an owner."""

    def __init__(self) -> None:
        self.clock, self.line = VirtualClock(), PoweredLink()
        self.built: list[Beacon] = []
        self.device = Switched("io", self.clock, self._build, (self.line,), self._cancel)
        self.device.start()

    def _build(self) -> Beacon:
        clock: Any = DeviceClock(self.clock, "io")  # type: ignore[arg-type]
        self.built.append(Beacon(clock, self.line))
        return self.built[-1]

    def _cancel(self) -> None:
        for _, _, timer in self.clock._timers.heap:
            if timer.owner == "io":
                timer.cancel()

    def run_until(self, ms: int) -> list[int]:
        """Return what was sent meanwhile."""
        before = len(self.line.sent)
        self.clock.advance_to(ms * MS)
        return self.line.sent[before:]


def test_it_is_silent_and_deaf_while_it_is_off_and_starts_again_from_nothing() -> None:
    bench = Bench()
    assert bench.run_until(15) == [2]
    bench.device.add_fault({"what": "power_off", "duration_ms": "30"})
    bench.line.deliver(7)
    assert bench.run_until(44) == []
    assert bench.run_until(60) == [1, 2]
    bench.line.deliver(8)
    assert [beacon.heard for beacon in bench.built] == [[], [8]]
    assert bench.line.told == [False, True]


def test_its_own_faults_outlive_a_loss_of_power_and_have_numbers_of_one_row() -> None:
    bench = Bench()
    mute = bench.device.add_fault({"what": "mute", "duration_ms": 100})
    power = bench.device.add_fault({"what": "power_off"})
    assert (mute, power) == (1, 2)
    bench.device.clear_fault(power)
    assert {number: fault["what"] for number, fault in bench.device.faults().items()} == {mute: "mute"}
    assert bench.run_until(95) == []
    assert bench.run_until(110) != []
    assert bench.device.add_fault({"what": "mute"}) == 3


def test_a_restart_is_a_power_cycle_at_one_instant_that_leaves_the_faults() -> None:
    bench = Bench()
    assert bench.run_until(15) == [2]
    mute = bench.device.add_fault({"what": "mute", "start_ms": 20})
    bench.device.restart()
    assert bench.line.sent == [1, 2, 1]
    assert bench.run_until(34) == [2]
    assert bench.run_until(60) == []
    assert bench.device.faults()[mute]["state"] == "on"
    assert bench.line.told == [False, True]


def test_a_device_that_a_fault_has_switched_off_is_not_restarted() -> None:
    bench = Bench()
    power = bench.device.add_fault({"what": "power_off"})
    with pytest.raises(ControlError, match="io is switched off\n  clear the fault"):
        bench.device.restart()
    bench.device.clear_fault(power)
    bench.device.restart()
    assert bench.line.told == [False, True, False, True]


def test_a_fault_that_it_gets_while_it_is_off_lets_it_hear_nothing() -> None:
    bench = Bench()
    bench.run_until(15)
    bench.device.add_fault({"what": "power_off", "duration_ms": "30"})
    number = bench.device.add_fault({"what": "mute", "duration_ms": "1000"})
    bench.line.deliver(7)
    bench.device.clear_fault(number)
    bench.line.deliver(8)
    assert bench.run_until(40) == []
    assert bench.built[0].heard == []
    assert bench.run_until(46) == [1]
