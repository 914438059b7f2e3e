"""The parts that all plain data frames of one identifier have in common, made once.

Nearly all messages of a log are classical data frames of a few identifiers.  Remembering the text of an identifier and
its bytes takes a third from the time of a line.  What is remembered is bounded, as a wrong log may have a million
identifiers.
"""

from collections.abc import Callable
from typing import Final, TypeVar

from fieldrig_bus.can.acceptance import EXTENDED
from fieldrig_bus.can.frame import EXTENDED_MASK, STANDARD_MASK
from fieldrig_bus.traces.can_fields import plain_message

T = TypeVar("T")
MOST: Final = 4_096
"""Identifiers that are remembered."""
HEAD_BYTES: Final = 5
"""Bytes of a message before its data; the last of them is the length."""


class PlainHeads(dict[bytes, T | None]):
    """The part of a writer for the head of a plain data frame; None for the head of any other message."""

    def __init__(self, written: Callable[[int, bool, int], T]) -> None:
        """`written` returns what is written for an identifier, whether it is extended, and a length."""
        self._written = written

    def __missing__(self, head: bytes) -> T | None:
        found = None
        if len(head) == HEAD_BYTES and head[4] <= 8:
            word = int.from_bytes(head[:4], "little")
            identifier = word & ~EXTENDED
            if identifier <= (EXTENDED_MASK if word & EXTENDED else STANDARD_MASK):
                found = self._written(identifier, bool(word & EXTENDED), head[4])
        if len(self) < MOST:
            self[head] = found
        return found


def heads_of(word: int, is_extended: bool) -> tuple[bytes, ...]:
    """Return the heads of plain data frames of 0 to 8 bytes; none for a number that is no identifier."""
    if not 0 <= word <= (EXTENDED_MASK if is_extended else STANDARD_MASK):
        return ()
    flagged = word | EXTENDED if is_extended else word
    return tuple(plain_message(flagged, bytes(size))[:HEAD_BYTES] for size in range(9))


class HeadsOfNumbers(dict[tuple[int, int], tuple[bytes, ...]]):
    """The same heads by the number of an identifier, and 1 for an extended one.  TypeError for what is no number."""

    def __missing__(self, key: tuple[int, int]) -> tuple[bytes, ...]:
        word, is_extended = key
        heads = heads_of(word, bool(is_extended))
        if len(self) < MOST:
            self[key] = heads
        return heads


class HeadsOfTexts(dict[str, tuple[bytes, ...]]):
    """The heads of plain data frames of 0 to 8 bytes, by the hexadecimal text of their identifier.

    Empty for a text that is no identifier.
    """

    def __init__(self, is_extended: Callable[[str], bool]) -> None:
        self._is_extended = is_extended

    def __missing__(self, text: str) -> tuple[bytes, ...]:
        try:
            heads = heads_of(int(text, 16), self._is_extended(text))
        except ValueError:
            heads = ()
        if len(self) < MOST:
            self[text] = heads
        return heads
