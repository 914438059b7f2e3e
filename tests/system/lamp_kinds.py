"""Small devices on wires for the tests of running rigs; the processes of a rig import this module by name."""

import os
from collections.abc import Mapping

from fieldrig.clock import MS, Clock
from fieldrig.device import Device, Point, Value
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig.storage.store import Store
from fieldrig_bus.wires import Signal


class LampSettings(Settings):
    colour: str = "red"


class Lamp(Device):
    """Burns when its wire says so; counts how often it was switched on, over a power cycle too."""

    about = "a lamp for tests"

    def __init__(self, name: str, settings: LampSettings, store: Store, wires: Link[Signal]) -> None:
        self._name, self._store, self._wires = name, store, wires
        self._colour = settings.colour
        self._is_on = False
        self._times = int.from_bytes(store.load() or b"", "little")
        wires.on_receive(self._on_signal, [f"{name}.on"])

    def start(self) -> None:
        self._wires.send(Signal(f"{self._name}.there", True))

    def points(self) -> Mapping[str, Point]:
        return {
            "on": Point(lambda: self._is_on),
            "times": Point(lambda: self._times, unit="1", about="how often it was switched on"),
            "colour": Point(lambda: self._colour, self._paint),
        }

    def _paint(self, value: Value) -> None:
        if value not in ("red", "green"):
            raise ValueError("expected red or green")
        self._colour = str(value)

    def _on_signal(self, signal: Signal) -> None:
        self._is_on = bool(signal.value)
        self._times += self._is_on
        self._store.save(self._times.to_bytes(4, "little"))


class SwitchSettings(Settings):
    lamp: str
    period_ms: int | None = None


class Switch(Device):
    """Drives the wire of a lamp: by hand, or over and over."""

    def __init__(self, clock: Clock, settings: SwitchSettings, wires: Link[Signal]) -> None:
        self._clock, self._settings, self._wires = clock, settings, wires
        self._is_on = False

    def start(self) -> None:
        if self._settings.period_ms is not None:
            self._flip()

    def points(self) -> Mapping[str, Point]:
        return {"on": Point(lambda: self._is_on, self._set)}

    def _flip(self) -> None:
        assert self._settings.period_ms is not None
        self._set(not self._is_on)
        self._clock.call_at(self._clock.now_ns() + self._settings.period_ms * MS, self._flip)

    def _set(self, value: Value) -> None:
        self._is_on = bool(value)
        self._wires.send(Signal(f"{self._settings.lamp}.on", self._is_on))


class Broken(Device):
    """Fails when it is switched on."""

    def start(self) -> None:
        raise RuntimeError("the fuse is blown")


class Fragile(Device):
    """A device with a fault in its code that appears on request."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock

    def points(self) -> Mapping[str, Point]:
        return {"hit": Point(lambda: False, self._set), "pid": Point(os.getpid)}

    def _set(self, _value: Value) -> None:
        self._clock.call_at(self._clock.now_ns(), self._crash)

    def _crash(self) -> None:
        raise RuntimeError("hit too hard")


class Stuck(Device):
    """Never comes to the end of its start."""

    def start(self) -> None:
        while True:
            pass


class Hanging(Device):
    """Starts as it should at first, hangs when it is started again, and then starts as it should again."""

    def __init__(self, store: Store, wires: Link[Signal]) -> None:
        self._starts = int.from_bytes(store.load() or b"", "little") + 1
        store.save(self._starts.to_bytes(4, "little"))

    def start(self) -> None:
        while self._starts == 2:
            pass


class Shy(Device):
    """A device with a fault in its code that appears when a lamp is switched on."""

    def __init__(self, wires: Link[Signal]) -> None:
        wires.on_receive(self._on_signal, ["lamp.on"])

    def _on_signal(self, signal: Signal) -> None:
        if signal.value:
            raise RuntimeError("too bright")


class Clinging(Device):
    """Never comes to the end of its end."""

    def stop(self) -> None:
        while True:
            pass
