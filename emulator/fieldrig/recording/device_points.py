"""The points of a device as a recording reads them: bound once, and again when the device has made others."""

from collections.abc import Callable, Mapping, Sequence
from typing import Final

from fieldrig.device import Device, Point, Value
from fieldrig.errors import ControlError
from fieldrig.recording.signals import NAN, Described
from fieldrig.text.nearest import closest

EVERY: Final = 64
"""Rows after which the points of a device are looked up again, if it makes other ones at each call."""


def describe(name: str, device: Device, keys: Sequence[str]) -> list[Described]:
    """Return what is known of these points.  ControlError, with the nearest key, for one that does not exist."""
    points = device.points()
    described: list[Described] = []
    for key in keys:
        point = _found(device, points, key)
        if point is None:
            raise ControlError(f"{name} has no value {key!r}", closest(key, list(points)))
        described.append(Described(point.read(), point.unit, point.states))
    return described


def _found(device: Device, points: Mapping[str, Point], key: str) -> Point | None:
    return points[key] if key in points else device.further_point(key)


class PointReads:
    """Reads points of one device.  A device that is switched off, and a point that has gone, have no value."""

    def __init__(self, device: Callable[[], Device | None], keys: Sequence[str]) -> None:
        """`device` returns the device as it was built last; None while it has no power."""
        self._device, self._keys = device, tuple(keys)
        self._bound: Device | None = None
        self._points: Mapping[str, Point] = {}
        self._reads: list[Callable[[], Value]] = []
        self._is_steady = False
        self._age = 0

    def __call__(self) -> list[Value]:
        device = self._device()
        if device is None:
            return [NAN] * len(self._keys)
        if device is not self._bound or self._is_stale(device):
            self._bind(device)
        try:
            return [read() for read in self._reads]
        except (LookupError, AttributeError, ValueError):
            if self._is_steady:
                raise
            self._bind(device)  # a point may have gone since they were looked up
            return [read() for read in self._reads]

    def _is_stale(self, device: Device) -> bool:
        if self._is_steady:
            return device.points() is not self._points
        self._age += 1
        return self._age >= EVERY

    def _bind(self, device: Device) -> None:
        points = device.points()
        self._is_steady = points is device.points()
        self._bound, self._points, self._age = device, points, 0
        found = [_found(device, points, key) for key in self._keys]
        self._reads = [_nothing if point is None else point.read for point in found]


def _nothing() -> Value:
    return NAN
