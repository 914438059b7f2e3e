"""Strategies of hypothesis for the types of the language: all values of Python that a variable can be given.

Small values of times and numbers come as often as large ones, as a machine is made for seconds and not for weeks.
"""

from datetime import date, datetime
from typing import Any, Final

from fieldrig.clock import S
from fieldrig.errors import ArgumentError
from fieldrig.properties import hypothesis
from fieldrig_devices.iec.elementary import UNITS_NS, Elementary, Family
from fieldrig_devices.iec.types import ArrayType, EnumType, Field, StringType, StructType, SubrangeType, Type

_USUAL_NS: Final = 10 * S
"""The longest of the usual times."""
_FIRST: Final = date(1970, 1, 1)
_LAST: Final = date(2106, 2, 6)
"""The last whole day that a DATE and a DT of 32 bits of seconds can have."""


def values_of(kind: Type, path: str) -> Any:
    """Return the strategy of a type.  ArgumentError for one whose values are places of the program, as of a pointer."""
    of = hypothesis().strategies
    match kind:
        case Elementary():
            return _elementary(of, kind)
        case StringType(length, is_wide):
            characters = of.characters(
                min_codepoint=1, max_codepoint=0xFFFF if is_wide else 0xFF, exclude_categories=["Cs"]
            )
            return of.text(characters, max_size=length)
        case EnumType():
            return of.sampled_from(list(kind.values))
        case SubrangeType(_, low, high):
            return of.integers(low, high)
        case ArrayType():
            return of.lists(values_of(kind.element, path), min_size=kind.count, max_size=kind.count)
        case StructType():
            return _structure(of, kind, path)
    raise ArgumentError(f"{path} is a {kind}, whose values are places of the program", "give a strategy for it")


def _elementary(of: Any, kind: Elementary) -> Any:
    if kind is Elementary.BOOL:
        return of.booleans()
    if kind.is_real:
        return of.floats(width=8 * kind.size, allow_nan=False, allow_infinity=False)
    if kind.family is Family.TIME:
        return _times(of, kind)
    if kind.family is Family.CHARACTER:
        return of.integers(0, int(kind.high)).map(chr)
    if kind is Elementary.TOD:
        return of.times().map(lambda one: one.replace(microsecond=one.microsecond // 1000 * 1000))
    if kind in (Elementary.DATE, Elementary.LDATE, Elementary.UNSIGNED_LDATE):
        return of.dates(_FIRST, _LAST)
    if kind is Elementary.DT:
        return of.datetimes(datetime(1970, 1, 1), datetime(2106, 2, 6)).map(lambda one: one.replace(microsecond=0))  # noqa: DTZ001
    return of.integers(int(kind.low), int(kind.high))


def _times(of: Any, kind: Elementary) -> Any:
    unit_ns = UNITS_NS[kind]
    usual = of.integers(0, _USUAL_NS // unit_ns)
    return (usual | of.integers(int(kind.low), int(kind.high))).map(lambda count: count * unit_ns)


def _structure(of: Any, kind: StructType, path: str) -> Any:
    """Return dicts; of a union, which has one value at a time, with one component."""
    parts = {one.name: _part(of, one, f"{path}.{one.name}") for one in kind.fields.values()}
    if not kind.is_union:
        return of.fixed_dictionaries(parts)
    return of.one_of([of.fixed_dictionaries({name: one}) for name, one in parts.items()])


def _part(of: Any, field: Field, path: str) -> Any:
    return of.booleans() if field.bit >= 0 else values_of(field.type, path)
