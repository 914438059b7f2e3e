"""The standard functions with fixed types: strings, dates and times, bits, and the clock.

Source: CoDeSys V2.3's Standard.lib (strings) and util.lib (bits), IEC 61131-3 edition 3 (CONCAT_DATE_TOD).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.library import strings
from fieldrig_devices.iec.library.overload import REAL_NS, SIMPLE_NS, TEXT_NS, Implementation
from fieldrig_devices.iec.types import StringType, Type

_E = Elementary
_TEXT: Final = StringType(strings.LONGEST)
_MASK: Final = 2**32 - 1


@dataclass(frozen=True, slots=True)
class Fixed:
    parameters: tuple[Type, ...]
    result: Type
    implementation: Implementation
    names: tuple[str, ...] = ()
    """The names of the parameters."""
    is_open: bool = False
    """True if the last parameter may be given more than once."""


def put_bit(value: int, number: int, is_set: bool) -> int:
    """PUTBIT: the value with bit `number` as given; unchanged for a bit that a DWORD does not have."""
    if number > 31:
        return value
    return value | 1 << number if is_set else value & ~(1 << number)


def packed(*bits: bool) -> int:
    """PACK: the first bit is the lowest."""
    return sum(1 << number for number, bit in enumerate(bits) if bit)


FUNCTIONS: Final[Mapping[str, Callable[..., object]]] = {
    "LENGTH": len,
    "LEFT_OF": strings.left,
    "RIGHT_OF": strings.right,
    "MIDDLE_OF": strings.middle,
    "CONCATENATED": strings.concatenated,
    "INSERTED": strings.inserted,
    "DELETED": strings.deleted,
    "REPLACED": strings.replaced,
    "FOUND": strings.found,
    "PUT_BIT": put_bit,
    "PACKED": packed,
}


def _text(python: str, parameters: tuple[Type, ...], names: tuple[str, ...], result: Type = _TEXT) -> Fixed:
    is_open = python == "CONCATENATED({*})"
    return Fixed(parameters, result, Implementation(python, TEXT_NS), () if is_open else names, is_open)


def _time(python: str, *kinds: Type) -> Fixed:
    """The parameters, then the result."""
    return Fixed(kinds[:-1], kinds[-1], Implementation(python))


ON_TEXTS: Final = frozenset({"LEN", "LEFT", "RIGHT", "MID", "INSERT", "DELETE", "REPLACE", "FIND"})
"""The functions with lengths of strings and positions in them."""

FIXED: Final[Mapping[str, Fixed]] = {
    "LEN": _text("LENGTH({0})", (_TEXT,), ("STR",), _E.INT),
    "LEFT": _text("LEFT_OF({0}, {1})", (_TEXT, _E.INT), ("STR", "SIZE")),
    "RIGHT": _text("RIGHT_OF({0}, {1})", (_TEXT, _E.INT), ("STR", "SIZE")),
    "MID": _text("MIDDLE_OF({0}, {1}, {2})", (_TEXT, _E.INT, _E.INT), ("STR", "LEN", "POS")),
    "CONCAT": _text("CONCATENATED({*})", (_TEXT, _TEXT), ()),
    "INSERT": _text("INSERTED({0}, {1}, {2})", (_TEXT, _TEXT, _E.INT), ("STR1", "STR2", "POS")),
    "DELETE": _text("DELETED({0}, {1}, {2})", (_TEXT, _E.INT, _E.INT), ("STR", "LEN", "POS")),
    "REPLACE": _text("REPLACED({0}, {1}, {2}, {3})", (_TEXT, _TEXT, _E.INT, _E.INT), ("STR1", "STR2", "L", "P")),
    "FIND": _text("FOUND({0}, {1})", (_TEXT, _TEXT), ("STR1", "STR2"), _E.INT),
    # Time since the start of the controller in ms; the run time gives `now_ms`.
    "TIME": Fixed((), _E.TIME, Implementation(f"(now_ms() & {_MASK})", REAL_NS)),
    "LTIME": Fixed((), _E.LTIME, Implementation("(now_ms() * 1000000)", REAL_NS)),
    # Bits of util.lib.
    "EXTRACT": Fixed((_E.DWORD, _E.BYTE), _E.BOOL, Implementation("({0} // TWO[MIN({1}, 32)] & 1 == 1)"), ("X", "N")),
    "PUTBIT": Fixed(
        (_E.DWORD, _E.BYTE, _E.BOOL), _E.DWORD, Implementation("PUT_BIT({0}, {1}, {2})", SIMPLE_NS), ("X", "N", "B")
    ),
    "PACK": Fixed(
        (_E.BOOL,) * 8, _E.BYTE, Implementation("PACKED({*})", REAL_NS), tuple(f"B{number}" for number in range(8))
    ),
    # Edition 3; the arithmetic of durations and dates is in `timed.py`.
    "CONCAT_DATE_TOD": _time(f"({{0}} + {{1}} // 1000 & {_MASK})", _E.DATE, _E.TOD, _E.DT),
    "CONCAT_DATE_LTOD": _time("({0} * 1000000000 + {1})", _E.DATE, _E.LTOD, _E.LDT),
}
