"""String functions as Python of their own, where that is faster than a call of the library's.

The longest possible result is known, so it is cut only where it can be too long.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.library.strings import LONGEST
from fieldrig_devices.iec.lower.emitter import Emitter
from fieldrig_devices.iec.lower.values import Value
from fieldrig_devices.iec.types import StringType

FASTER: Final = {"LENGTH": len, "FIND_IN": str.find}
"""Functions of Python that stand for the library's."""

MOST_JOINED: Final = 32
"""Strings that one Python expression joins; Python's compiler cannot nest any number of operators."""


def longest(value: Value) -> int:
    assert isinstance(value.type, StringType)
    return value.type.length


def _of_length(value: Value, length: int) -> StringType:
    """Return the type of the text with another length."""
    assert isinstance(value.type, StringType)
    return replace(value.type, length=length)


def shortened(value: Value, length: int, emitter: Emitter) -> Value:
    """Return a string of at most `length` characters."""
    if longest(value) <= length:
        return value
    name = emitter.new(value.text)
    emitter.add(f"if LENGTH({name}) > {length}:")
    emitter.add(f"    {name} = {name}[:{length}]")
    return Value(name, _of_length(value, length))


def _length(arguments: Sequence[Value], emitter: Emitter) -> Value | None:
    (text,) = arguments
    return Value(f"LENGTH({text.text})", Elementary.INT, 0, min(longest(text), LONGEST))


def _joined(arguments: Sequence[Value], emitter: Emitter) -> Value | None:
    while len(arguments) > MOST_JOINED:
        head = _joined(arguments[:MOST_JOINED], emitter)
        assert head is not None
        arguments = (Value(emitter.new(head.text), head.type), *arguments[MOST_JOINED:])
    text = " + ".join(argument.text for argument in arguments)
    joined = Value(f"({text})", _of_length(arguments[0], sum(map(longest, arguments))))
    return shortened(joined, LONGEST, emitter)


def _left(arguments: Sequence[Value], emitter: Emitter) -> Value | None:
    text, size = arguments
    return _part(text, 0, size.low, emitter) if _is_constant(size) else None


def _middle(arguments: Sequence[Value], emitter: Emitter) -> Value | None:
    text, size, position = arguments
    is_known = _is_constant(size) and _is_constant(position) and position.low > 0
    return _part(text, position.low - 1, size.low, emitter) if is_known else None


def _part(text: Value, start: int, size: int, emitter: Emitter) -> Value | None:
    if size < 0:
        return None
    name = emitter.new(text.text) if not text.text.isidentifier() else text.text
    return Value(f"{name}[{start or ''}:{start + size}]", _of_length(text, max(min(size, longest(text)), 1)))


def _find(arguments: Sequence[Value], emitter: Emitter) -> Value | None:
    text, part = arguments
    if part.text in ("''", '""') or part.text[0] not in "'\"":
        return None
    return Value(f"(FIND_IN({text.text}, {part.text}) + 1)", Elementary.INT, 0, LONGEST)


def _is_constant(value: Value) -> bool:
    return value.low == value.high


OWN: Final[Mapping[str, Callable[[Sequence[Value], Emitter], Value | None]]] = {
    "LEN": _length,
    "CONCAT": _joined,
    "LEFT": _left,
    "MID": _middle,
    "FIND": _find,
}
"""The Python by the name of the function; None where the arguments do not allow it."""
