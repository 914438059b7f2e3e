"""The points of a device that are watched, and their changes: all of them, as the device looks between its steps."""

from collections.abc import Callable
from typing import NamedTuple

from fieldrig.device import Device, Value
from fieldrig.points.access import points_for
from fieldrig.points.hooks import Hook
from fieldrig.points.values import is_another


class Change(NamedTuple):
    """A new value of a point."""

    key: str
    value: Value


class WatchedPoints:
    """The watched points of one device.  Looking reads points, so it changes nothing that follows."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self.hook = Hook("look", device)
        """The calls that the device makes between its changes, for this watch and for recordings."""
        self._end: Callable[[], None] | None = None
        self._last: dict[str, Value] = {}
        self._changes: list[Change] = []

    def watch(self, key: str) -> None:
        """Watch a point from now on, beginning with its present value."""
        self._last[key] = points_for(self._device, (key,))[key].read()
        if self._end is None:
            self._end = self.hook.add(self._look)

    def unwatch(self, key: str) -> None:
        self._last.pop(key, None)
        if not self._last and self._end is not None:
            self._end()
            self._end = None

    def move_to(self, device: Device) -> None:
        """Watch the same points of the same device after it was switched on again."""
        self._device = device
        self.hook.move_to(device)

    def take(self) -> list[Change]:
        """Return the changes since the last call."""
        if self._last:
            self._look()
        taken, self._changes = self._changes, []
        return taken

    def _look(self) -> None:
        points = points_for(self._device, self._last)
        for key, last in self._last.items():
            if key in points:  # a point of a program may go with the program
                value = points[key].read()
                if is_another(value, last):
                    self._last[key] = value
                    self._changes.append(Change(key, value))
