"""The memory of a DualPort: 2048 words of 16 bits, each read and written as a whole (sections 11.2 and 12.1)."""

from array import array
from collections.abc import Sequence
from typing import Final, Literal

from fieldrig.link import SharedWords

WORDS: Final = 2048
BYTES: Final = 2 * WORDS

ByteOrder = Literal["big", "little"]
"""The byte of a word that has the even address: of bits 8 to 15 (big, as on VME), or of bits 0 to 7 (little)."""


class Memory:
    """`words` may be shared with other processes; then the processor makes each access to a word atomic."""

    __slots__ = ("words",)

    def __init__(self, words: SharedWords | None = None) -> None:
        self.words: SharedWords = array("H", bytes(BYTES)) if words is None else words

    def read(self, word: int, count: int) -> list[int]:
        """Return words from number `word` on.  IndexError if one of them does not exist."""
        _check(word, count)
        return [self.words[cell] for cell in range(word, word + count)]

    def write(self, word: int, values: Sequence[int]) -> None:
        """Write words one after another.  IndexError, with nothing written, if one of them does not exist."""
        _check(word, len(values))
        for cell, value in enumerate(values, word):
            self.words[cell] = value

    def read_bytes(self, address: int, count: int, order: ByteOrder) -> bytes:
        """Return bytes from a byte address on.  IndexError if one of them does not exist."""
        first, last = address // 2, (address + count + 1) // 2
        data = b"".join(word.to_bytes(2, order) for word in self.read(first, last - first))
        return data[address % 2 : address % 2 + count]

    def write_bytes(self, address: int, data: bytes, order: ByteOrder) -> None:
        """Write bytes: a word at once wherever both of its bytes are written.  IndexError as in `write`."""
        first, last = address // 2, (address + len(data) + 1) // 2
        changed = bytearray(self.read_bytes(2 * first, 2 * (last - first), order))
        changed[address % 2 : address % 2 + len(data)] = data
        self.write(first, [int.from_bytes(changed[at : at + 2], order) for at in range(0, len(changed), 2)])


def _check(word: int, count: int) -> None:
    if word < 0 or count < 0 or word + count > WORDS:
        raise IndexError(f"words {word} to {word + count - 1}, expected 0 to {WORDS - 1}")
