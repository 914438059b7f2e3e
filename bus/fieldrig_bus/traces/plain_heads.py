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


class HeadsOfTexts(dict[str, tuple[bytes, ...]]):
    """The heads of plain data frames of 0 to 8 bytes, by the hexadecimal text of their identifier.

    Empty for a text that is no identifier.
    """

    def __init__(self, is_extended: Callable[[str], bool]) -> None:
        self._is_extended = is_extended

    def __missing__(self, text: str) -> tuple[bytes, ...]:
        heads: tuple[bytes, ...] = ()
        try:
            word, is_extended = int(text, 16), self._is_extended(text)
        except ValueError:
            word, is_extended = -1, False
        if 0 <= word <= (EXTENDED_MASK if is_extended else STANDARD_MASK):
            flagged = word | EXTENDED if is_extended else word
            heads = tuple(plain_message(flagged, bytes(size))[:HEAD_BYTES] for size in range(9))
        if len(self) < MOST:
            self[text] = heads
        return heads
