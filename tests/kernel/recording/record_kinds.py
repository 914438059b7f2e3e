"""Devices for the tests of recordings; a module of its own so that the processes of a rig can import it."""

from collections.abc import Mapping
from functools import partial

from fieldrig.clock import MS, Clock
from fieldrig.device import Device, Point, Value
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig_bus.wires import Signal


class BeatSettings(Settings):
    cycle_ms: int = 10


class Beat(Device):
    """Counts its cycles.  In each fifth one it has a pulse that is over before the cycle is."""

    has_cycle = True

    def __init__(self, clock: Clock, name: str, settings: BeatSettings, wires: Link[Signal] | None = None) -> None:
        self._clock, self._name, self._cycle_ns, self._wires = clock, name, settings.cycle_ms * MS, wires
        self.count = 0
        self.pulse = False
        self.offset: Value = 0
        self._made = self._make_points()

    def start(self) -> None:
        self._clock.call_at(self._clock.now_ns() // self._cycle_ns * self._cycle_ns + self._cycle_ns, self._on_cycle)

    def points(self) -> Mapping[str, Point]:
        return self._made

    def _make_points(self) -> Mapping[str, Point]:
        return {
            "count": Point(lambda: self.count, unit="1"),
            "pulse": Point(lambda: self.pulse),
            "word": Point(lambda: ("even", "odd")[self.count % 2]),
            "level": Point(lambda: ("low", "high")[self.count % 2], states=("low", "mid", "high")),
            "offset": Point(lambda: self.offset, self._put),
        }

    def _put(self, value: Value) -> None:
        self.offset = value
        if value == "new":
            self._made = {**self._make_points(), "count": Point(lambda: -self.count)}

    def _on_cycle(self) -> None:
        self._clock.call_at(self._clock.now_ns() + self._cycle_ns, self._on_cycle)
        self.count += 1
        if self.count % 5 == 0:
            for self.pulse in (True, False):
                if self.look is not None:
                    self.look()
        if self._wires is not None:
            self._wires.send(Signal(f"{self._name}.count", self.count, "1"))
        if self.end_of_cycle is not None:
            self.end_of_cycle()


class Shifting(Device):
    """Makes its points again at each call, and loses one of them after some cycles."""

    has_cycle = True

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._values = {"left": 1, "right": 2}

    def start(self) -> None:
        self._clock.call_at(self._clock.now_ns() + MS, self._on_cycle)

    def points(self) -> Mapping[str, Point]:
        return {key: Point(partial(self._values.__getitem__, key)) for key in self._values}

    def _on_cycle(self) -> None:
        self._clock.call_at(self._clock.now_ns() + MS, self._on_cycle)
        self._values["right"] += 1
        if self._values["right"] == 6:
            del self._values["left"]
        if self.end_of_cycle is not None:
            self.end_of_cycle()


class Ramp(Device):
    """A value that moves by itself, without an event and without a cycle."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock

    def points(self) -> Mapping[str, Point]:
        return {"millis": Point(lambda: self._clock.now_ns() / MS, unit="ms")}
