"""The one reader of JSON that comes from outside: from sockets, attach ports, control messages and stores.

It reads what RFC 8259 and RFC 7493 (I-JSON) call good, within limits of size, depth and type, and refuses everything
else with a `MalformedError` and nothing but that: no bytes make it raise anything else, or take much memory.  Refused
beyond the grammar: an object that has a key twice, NaN and Infinity, a number that a float or 64 bits cannot hold, half
of a surrogate pair, and text that isn't UTF-8.  Messages within a rig have NaN and Infinity all the same, because the
values of devices do: a Modbus master may write them into a register.

    hello = read_json(body, longest=4096)
    member = field(hello, "member", str)

Left out on purpose: what a value means (a member's name, an interest) is checked where it is used, with ValueError.
"""

import json
import re
from collections.abc import Iterator
from math import isinf
from typing import Any, Final, TypeVar

LONGEST: Final = 1 << 20
"""Longest text in bytes, unless the caller sets a limit."""
DEEPEST: Final = 32
"""Deepest nesting of arrays and objects."""
WIDEST: Final = (-(1 << 63), (1 << 64) - 1)
"""Range of integers: everything that 64 bits hold, signed or not."""

_DIGITS: Final = 20  # of 2**64 - 1, and of -(2**63) with its sign
_BRACKETS: Final = re.compile(r'"[^"\\]*(?:\\.[^"\\]*)*"?|[\[\]{}]', re.DOTALL)
_HALF_PAIR: Final = re.compile(r"\\u[dD][89a-fA-F]")
_SHOWN: Final = 60  # characters of what was refused, in a message

T = TypeVar("T")

_NAMES: Final[dict[type, str]] = {
    bool: "true or false",
    int: "an integer",
    float: "a number",
    str: "a text",
    list: "an array",
    dict: "an object",
    type(None): "null",
}


class MalformedError(ValueError):
    """Bytes from outside that are not as expected."""


def read_json(
    data: bytes | bytearray | memoryview | str,
    longest: int = LONGEST,
    deepest: int = DEEPEST,
    *,
    takes_nan: bool = False,
) -> Any:
    """Return the value that `data` holds.  MalformedError for anything but one JSON text within the limits.

    `takes_nan` lets it have NaN, Infinity and -Infinity.
    """
    if len(data) > longest:
        raise MalformedError(f"{len(data)} bytes, expected at most {longest}")
    try:
        text = data if isinstance(data, str) else str(data, "utf-8")
    except UnicodeDecodeError as cause:
        raise MalformedError(f"not UTF-8: {cause.reason} at byte {cause.start}") from cause
    # Brackets that are not there cannot be deep: what is short and flat, as nearly all is, costs two counts.
    if text.count("[") + text.count("{") > deepest and _depth(text) > deepest:
        raise MalformedError(f"arrays or objects deeper than {deepest}")
    try:
        value = (_DECODER_WITH_NAN if takes_nan else _DECODER).decode(text)
    except json.JSONDecodeError as cause:
        raise MalformedError(f"not JSON: {cause}") from cause
    if _HALF_PAIR.search(text) is not None or (isinstance(data, str) and not text.isascii()):
        _check_texts(value)
    return value


def field(data: Any, key: str, expected: type[T]) -> T:
    """Return the value of `key`.

    MalformedError if `data` is not an object, lacks the key, or has another type there.
    """
    if not isinstance(data, dict):
        raise MalformedError(f"expected an object, found {shown(data)}")
    if key not in data:
        raise MalformedError(f"expected the key {key!r} in {shown(data)}")
    return typed(data[key], expected, key)


def typed(value: Any, expected: type[T], name: str = "the value") -> T:
    """Return the value if it has the type.  An integer is also a number; true and false are not integers."""
    converted: Any = float(value) if expected is float and type(value) is int else value
    if type(converted) is expected:
        return converted
    raise MalformedError(f"{name}: expected {_NAMES.get(expected, expected.__name__)}, found {shown(value)}")


def items(value: Any, expected: type[T], most: int, name: str = "the value") -> list[T]:
    """Return an array of at most `most` values of one type."""
    values = typed(value, list, name)
    if len(values) > most:
        raise MalformedError(f"{name}: {len(values)} values, expected at most {most}")
    return [typed(item, expected, name) for item in values]


def shown(value: Any) -> str:
    """Return something from outside in a form for messages: short, and on one line."""
    text = ascii(value)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def _depth(text: str) -> int:
    """Return the nesting depth of arrays and objects, closed or not; brackets in texts don't count."""
    depth = deepest = 0
    for bracket in _BRACKETS.finditer(text):
        first = bracket.group()[0]
        if first in "[{":
            depth += 1
            deepest = max(deepest, depth)
        elif first != '"':
            depth -= 1
    return deepest


def _integer(digits: str) -> int:
    number = int(digits) if len(digits) <= _DIGITS else None
    if number is None or not WIDEST[0] <= number <= WIDEST[1]:
        raise MalformedError(f"an integer of {len(digits)} digits, expected at most 64 bits")
    return number


def _number(digits: str) -> float:
    number = float(digits)
    if isinf(number):
        raise MalformedError(f"the number {shown(digits)} is beyond all that a float can hold")
    return number


def _constant(name: str) -> Any:
    raise MalformedError(f"{name} is not a number of JSON")


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    fields = dict(pairs)
    if len(fields) != len(pairs):
        raise MalformedError("an object has a key twice")
    return fields


def _check_texts(value: Any) -> None:
    for text in _texts(value):
        try:
            text.encode()
        except UnicodeEncodeError as cause:
            raise MalformedError("a text has half of a surrogate pair") from cause


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, list):
        for item in value:
            yield from _texts(item)
    elif isinstance(value, dict):
        for key, item in value.items():
            yield key
            yield from _texts(item)


_DECODER: Final = json.JSONDecoder(
    parse_int=_integer, parse_float=_number, parse_constant=_constant, object_pairs_hook=_object
)
_DECODER_WITH_NAN: Final = json.JSONDecoder(
    parse_int=_integer, parse_float=_number, parse_constant=float, object_pairs_hook=_object
)
