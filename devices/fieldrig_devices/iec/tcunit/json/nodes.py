"""JSON documents as Tc3_JsonXml keeps them: values with a handle, parsed from text and written as text.

Numbers are written as RapidJSON does it, on which the library stands: with the digits of Grisu2, `1.0` for a whole
LREAL, and an exponent from 1e21 on and below 1e-6.

Source: RFC 8259; the public description of Tc3_JsonXml.
"""

import json
from dataclasses import dataclass, field
from enum import IntEnum
from math import inf, isfinite
from typing import Final

from fieldrig_devices.iec import characters
from fieldrig_devices.iec.tcunit.json.grisu import digits_of

SCALAR = bool | int | float | str | None
INT64: Final = range(-(1 << 63), 1 << 63)
UINT64: Final = range(1 << 64)
INT32: Final = range(-(1 << 31), 1 << 31)
UINT32: Final = range(1 << 32)
PLACES: Final = 324
"""The most decimal places that a number has, which is the limit unless a program sets one."""
_WHOLE: Final = 21
"""Digits in front of the point from which on there is an exponent."""
_SMALL: Final = -6
"""The place of the point in front of the digits at which there is one."""
_ESCAPES: Final = {'"': '\\"', "\\": "\\\\", "\b": "\\b", "\f": "\\f", "\n": "\\n", "\r": "\\r", "\t": "\\t"}


class Kind(IntEnum):
    """The values of EJsonType, which are those of RapidJSON."""

    NULL = 0
    FALSE = 1
    TRUE = 2
    OBJECT = 3
    ARRAY = 4
    STRING = 5
    NUMBER = 6


@dataclass(slots=True, eq=False)
class Node:
    """One value of a document.  It is an object or an array if it has one of the lists, and a scalar otherwise."""

    scalar: SCALAR = None
    members: list[tuple[str, "Node"]] | None = None
    elements: list["Node"] | None = None
    handle: int = field(default=0, repr=False)

    @property
    def kind(self) -> Kind:
        if self.members is not None:
            return Kind.OBJECT
        if self.elements is not None:
            return Kind.ARRAY
        if self.scalar is None:
            return Kind.NULL
        if isinstance(self.scalar, bool):
            return Kind.TRUE if self.scalar else Kind.FALSE
        return Kind.STRING if isinstance(self.scalar, str) else Kind.NUMBER

    @property
    def whole(self) -> int | None:
        """The number, if it is written without a point or an exponent."""
        is_whole = isinstance(self.scalar, int) and not isinstance(self.scalar, bool)
        return int(self.scalar or 0) if is_whole else None

    def become(self, other: "Node") -> None:
        """Take the value of another one, and keep the handle."""
        self.scalar, self.members, self.elements = other.scalar, other.members, other.elements

    def member(self, name: str) -> "Node | None":
        """Return the first member of an object with this name."""
        return next((value for known, value in self.members or () if known == name), None)

    def children(self) -> list["Node"]:
        return [value for _, value in self.members or ()] + list(self.elements or ())


def parsed(text: str) -> Node | None:
    """Return the document of a text; None if it is not valid JSON."""
    # Texts are UTF-8 in a STRING.  What is not UTF-8 keeps its bytes.
    given = characters.encoded(text, is_wide=False).decode("utf-8", "surrogateescape")
    try:
        return _node(json.loads(given, object_pairs_hook=_Pairs, parse_float=_real, parse_constant=_refused))
    except (ValueError, RecursionError):  # half of a pair of UTF-16 has no UTF-8, and is a ValueError too
        return None


class _Pairs(list[tuple[str, object]]):
    """The members of an object, with those that have the same name."""


def _node(value: object) -> Node:
    if isinstance(value, _Pairs):
        return Node(members=[(_narrow(name), _node(one)) for name, one in value])
    if isinstance(value, list):
        return Node(elements=[_node(one) for one in value])
    if isinstance(value, str):
        return Node(_narrow(value))
    if isinstance(value, int) and not isinstance(value, bool) and value not in INT64 and value not in UINT64:
        return Node(float(value))
    assert value is None or isinstance(value, bool | int | float)
    return Node(value)


def _narrow(text: str) -> str:
    return characters.decoded(text.encode("utf-8", "surrogateescape"), is_wide=False)


def _real(text: str) -> float:
    number = float(text)
    if abs(number) == inf:
        raise ValueError("a number that no LREAL can have")
    return number


def _refused(text: str) -> None:
    raise ValueError(text)


def written(node: Node, places: int = PLACES) -> str:
    """Return the text of a value without blanks, with at most `places` decimal places."""
    if node.members is not None:
        return "{" + ",".join(f"{quoted(name)}:{written(one, places)}" for name, one in node.members) + "}"
    if node.elements is not None:
        return "[" + ",".join(written(one, places) for one in node.elements) + "]"
    return scalar_text(node.scalar, places)


def scalar_text(value: SCALAR, places: int = PLACES) -> str:
    """Return the text of a scalar; an empty one for what JSON cannot say, such as infinity."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return quoted(value)
    return str(value) if isinstance(value, int) else _real_text(value, places)


def quoted(text: str) -> str:
    made = (_ESCAPES.get(one) or (f"\\u{ord(one):04X}" if one < " " else one) for one in text)
    return f'"{"".join(made)}"'


def _real_text(value: float, places: int) -> str:
    if not isfinite(value):
        return ""
    sign = "-" if str(value).startswith("-") else ""
    if value == 0:
        return f"{sign}0.0"
    digits, place = digits_of(abs(value))
    point = len(digits) + place  # counted from the first digit
    if 0 < point <= _WHOLE:
        digits = digits.ljust(point, "0")
        return f"{sign}{digits[:point]}.{_cut(digits[point:], places)}"
    if _SMALL < point <= 0:
        return f"{sign}0.{_cut('0' * -point + digits, places)}"
    if point < -places:
        return f"{sign}0.0"
    mantissa = digits[0] + (f".{digits[1:]}" if len(digits) > 1 else "")
    return f"{sign}{mantissa}e{point - 1}"


def _cut(decimals: str, places: int) -> str:
    """Return decimals that are cut, not rounded, without zeros behind; one digit is always left."""
    return decimals[: max(1, places)].rstrip("0") or "0"
