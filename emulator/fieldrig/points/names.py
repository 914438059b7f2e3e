"""The name of a point, `tank/level`: the same on the command line, in Python, and in messages."""

from typing import Any

from fieldrig.device import Value
from fieldrig.errors import ArgumentError
from fieldrig.outside.untrusted import shown


def split_point(point: Any, key: Any = None) -> tuple[str, str]:
    """Return device and key of a point, given as one text with a slash or as two texts.

    ArgumentError for anything else.
    """
    if key is None and isinstance(point, str):
        device, _, key = point.partition("/")
        if not device or not key:
            raise ArgumentError(f"{point!r} is not a point", f'expected DEVICE/KEY, such as "{device or "tank"}/level"')
        return device, key
    if not isinstance(point, str) or not isinstance(key, str):
        given = shown(point) if key is None else f"{shown(point)}, {shown(key)}"
        raise ArgumentError(f"{given} is not a point", 'expected a text, such as "tank/level", or "tank", "level"')
    return point, key


def written_point(point: Any, *key_and_value: Any) -> tuple[str, str, Value]:
    """Return device, key and value of a point that is written: `"tank/level", 1.25` or `"tank", "level", 1.25`."""
    match key_and_value:
        case (value,):
            return (*split_point(point), value)
        case (key, value):
            return (*split_point(point, "" if key is None else key), value)
    raise ArgumentError(f"{shown(point)} cannot be set to nothing", 'expected a value, such as set("tank/level", 1.25)')
