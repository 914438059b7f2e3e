"""All plain values inside a device, by their path, so that two forms of it can be compared as a whole."""

from enum import Enum
from typing import Any

Plain = bool | int | float | str | bytes | Enum | None
OURS = ("fieldrig_devices.", "fieldrig_bus.")


def inner_state(root: object) -> dict[str, Plain]:
    """Return the plain values that are reached from `root` by attributes and containers of our own objects.

    What is reached in two ways has one path.  Clocks, links and functions are left out.
    """
    found: dict[str, Plain] = {}
    seen = set[int]()
    waiting: list[tuple[str, Any]] = [("", root)]
    while waiting:
        path, value = waiting.pop()
        if value is None or isinstance(value, bool | int | float | str | bytes | Enum):
            found[path] = value
        elif id(value) not in seen:
            seen.add(id(value))
            waiting += _parts(path, value)
    return found


def _parts(path: str, value: Any) -> list[tuple[str, Any]]:
    if isinstance(value, dict):
        return [(f"{path}[{key}]", part) for key, part in value.items()]
    if isinstance(value, list | tuple):
        return [(f"{path}[{place}]", part) for place, part in enumerate(value)]
    if isinstance(value, type) or not type(value).__module__.startswith(OURS):
        return []
    names = [name for kind in type(value).__mro__ for name in getattr(kind, "__slots__", ())]
    names += getattr(value, "__dict__", {})
    return [(f"{path}.{name}", getattr(value, name)) for name in names if hasattr(value, name)]
