"""Arguments without a type of their own: ARRAY[*] and ANY get one from the value that a test gives.

An array begins with the index 0.  A whole number is a DINT, or a larger integer if it has to be.
"""

from datetime import date, datetime, time, timedelta
from typing import Any, Final

from fieldrig.errors import ArgumentError
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.any_types import NAMES
from fieldrig_devices.iec.elementary import Elementary

Shape = tuple[int, ...] | str
"""The lengths of an array by its dimensions, or the name of the type of an ANY."""
_INTEGERS: Final = (Elementary.DINT, Elementary.LINT, Elementary.ULINT)


def is_any(spec: tree.TypeSpec) -> bool:
    return isinstance(spec, tree.NamedType) and spec.name.casefold() in NAMES


def is_open(spec: tree.TypeSpec) -> bool:
    return isinstance(spec, tree.OpenArraySpec) or is_any(spec)


def closed(spec: tree.TypeSpec, shape: Shape | None) -> tree.TypeSpec:
    """Return the type of an argument with a shape; with None, of one that was not given yet."""
    if not isinstance(spec, tree.OpenArraySpec):
        return tree.NamedType(shape if isinstance(shape, str) else Elementary.DINT.name)
    lengths = shape if isinstance(shape, tuple) else (1,) * spec.count
    return tree.ArraySpec(tuple(tree.Range(_number(0), _number(length - 1)) for length in lengths), spec.element)


def shape_of(spec: tree.TypeSpec, value: Any, path: str) -> Shape:
    """Return the shape of a value.  ArgumentError for one that fits no type."""
    if not isinstance(spec, tree.OpenArraySpec):
        return _type_of(value, path)
    lengths = []
    part = value
    for _ in range(spec.count):
        if not isinstance(part, list | tuple) or not part:
            lists = "a list" if spec.count == 1 else f"lists in lists, {spec.count} deep,"
            raise ArgumentError(f"{path} cannot be {value!r}", f"expected {lists} with at least one value")
        lengths.append(len(part))
        part = part[0]
    return tuple(lengths)


def _type_of(value: Any, path: str) -> str:
    match value:
        case bool():
            return "BOOL"
        case int():
            fitting = (kind.name for kind in _INTEGERS if kind.low <= value <= kind.high)
            return next(fitting, Elementary.ULINT.name)
        case float():
            return "LREAL"
        case str():
            return "STRING"
        case datetime():
            return "DT"
        case date():
            return "DATE"
        case time():
            return "TOD"
        case timedelta():
            return "TIME"
    raise ArgumentError(f"{path} cannot be {value!r}", "expected a number, a text, True, False, a date or a timedelta")


def _number(value: int) -> tree.Literal:
    return tree.Literal(tree.LiteralKind.INTEGER, value)
