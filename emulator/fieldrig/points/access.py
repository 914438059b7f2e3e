"""Read and write one point of a device, with the nearest name for one that it does not have."""

from collections.abc import Iterable, Mapping
from typing import Final

from fieldrig.device import Device, Point, Value
from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import WIDEST, shown
from fieldrig.text.nearest import closest

VALUES: Final = (bool, int, float, str)
EXPECTED: Final = "expected a number, a text, true or false"
_MISTAKE: Final = "correct the class of the device"


def read_point(device: str, points: Mapping[str, Point], key: str) -> Value:
    """Return the value of a point.

    ControlError, with the nearest key, if the device has no such point.  A point that refuses to be read, or whose
    value no tool can take, is named as well: it is a mistake in the class of a device.
    """
    point = _point(device, points, key)
    try:
        value = point.read()
    except ValueError as cause:
        raise ControlError(f"{device}/{key} cannot be read: {cause}", _MISTAKE) from cause
    if not isinstance(value, VALUES):
        raise ControlError(f"{device}/{key} cannot be read: it is {shown(value)}", f"{_MISTAKE}: {EXPECTED}")
    if isinstance(value, int) and not WIDEST[0] <= value <= WIDEST[1]:
        bits = value.bit_length()
        raise ControlError(f"{device}/{key} cannot be read: it has {bits} bits", f"{_MISTAKE}: expected at most 64")
    return value


def read_points(device: str, points: Mapping[str, Point], keys: Iterable[str] | None = None) -> dict[str, Value]:
    """Return the values of several points by their keys; None stands for all of them.

    A device may make new points whenever it is asked for them, so a question asks for them once.
    """
    wanted = points if keys is None else keys
    return {key: read_point(device, points, key) for key in wanted}


def points_for(device: Device, keys: Iterable[str]) -> Mapping[str, Point]:
    """Return the points of a device, with those of these keys that it has besides, such as variables of a program."""
    points = device.points()
    further = {key: device.further_point(key) for key in keys if key not in points}
    found = {key: point for key, point in further.items() if point is not None}
    return {**points, **found} if found else points


def write_point(device: str, points: Mapping[str, Point], key: str, value: Value) -> None:
    """Write a point.  ControlError for an unknown or read-only key, or a value that is refused."""
    if not isinstance(value, VALUES):
        raise ControlError(f"{key} cannot be {shown(value)}", EXPECTED)
    point = _point(device, points, key)
    if point.write is None:
        raise ControlError(f"{key} can only be read")
    try:
        point.write(value)
    except ValueError as cause:
        raise ControlError(f"{key} cannot be {value!r}: {cause}") from cause


def _point(device: str, points: Mapping[str, Point], key: str) -> Point:
    try:
        return points[key]
    except KeyError:
        raise ControlError(f"{device} has no value {key!r}", closest(key, list(points))) from None
