"""Words of a DualPort memory by name, for tools: what a map of the memory has to know."""

from collections.abc import Sequence
from typing import Final, NamedTuple, Protocol

from fieldrig.points.values import show_number
from fieldrig.traces.names import listed

PANEL: Final = ("origin", "number", "date", "time", "tag", "info", "reserved")
"""The cells of the fatal error panel (PAMS-056)."""


class Piece(NamedTuple):
    """Some words that belong together."""

    kind: str
    """The part of the memory, such as `variable` or `input block`."""
    name: str
    value: str


class WordMap(Protocol):
    """The map of one DualPort."""

    def label(self, word: int) -> str:
        """Return the name of a word; its number if there is nothing at it."""

    def piece(self, word: int, values: Sequence[int]) -> tuple[int, Piece]:
        """Take the words that `values` begins with; return their number, at least 1, and what they are."""


def pieces(words: WordMap, first: int, values: Sequence[int]) -> list[Piece]:
    """Return what words from number `first` on are."""
    found, at = [], 0
    while at < len(values):
        count, piece = words.piece(first + at, values[at:])
        found.append(piece)
        at += count
    return found


def in_text(found: Sequence[Piece]) -> str:
    return listed(f"{piece.name} = {piece.value}" for piece in found)


def shown(value: float | bool) -> str:
    """Return the value of a variable as a person reads it."""
    return ("on" if value else "off") if isinstance(value, bool) else show_number(value)


class PlainWords:
    """The map of a memory of which no application says what is in it.  Implements `WordMap`."""

    def label(self, word: int) -> str:
        return str(word)

    def piece(self, word: int, values: Sequence[int]) -> tuple[int, Piece]:
        return 1, Piece("words", f"word {word}", f"{values[0]:04X}h")


class MapRegisters:
    """The words as registers of a Modbus unit: register n is word n.  Implements `RegisterNames`."""

    def __init__(self, words: WordMap) -> None:
        self._words = words

    def names(self, space: str, address: int, count: int) -> str:
        labels = dict.fromkeys(self._words.label(word) for word in range(address, address + min(count, 125)))
        return listed(labels)

    def registers(self, space: str, address: int, data: bytes) -> str:
        values = [int.from_bytes(data[at : at + 2], "big") for at in range(0, len(data) - 1, 2)]
        return in_text(pieces(self._words, address, values))

    def bits(self, space: str, address: int, count: int, data: bytes) -> str:
        return data.hex(" ").upper()
