"""Bits and FIFOs in the cells of a Simatic DualPort (sections 12.1 and 12.2).

Addresses count bytes.  The even byte of a cell has bits 0 to 7 and the odd byte bits 8 to 15 (manual lines 10818 to
10820).  WATCH_DOG uses the even byte, and HEAD and TAIL the one that the settings choose.
"""

from typing import Final, NamedTuple

from fieldrig.link import SharedWords
from fieldrig_devices.pam.language.ports import PortPlan, PortVariable
from fieldrig_devices.pam.ports.memory import Memory

EVEN_BYTE: Final = 0xFF
INDEX_SHIFTS: Final = {"even": 0, "odd": 8}
"""The first bit of HEAD and TAIL in their cells."""


class Place(NamedTuple):
    """A flag or a word of the memory; `mask` has a single bit for a flag, and all 16 for a word."""

    cell: int
    """Number of the word in the memory."""
    mask: int

    @property
    def address(self) -> int:
        """Byte address of the cell, which the FIFOs carry."""
        return 2 * self.cell


def bit_place(address: int, bit: int) -> Place:
    return Place(address // 2, 1 << 8 * (address % 2) + bit)


def item_place(variable: PortVariable, index: int) -> Place:
    """Return where an item is: flags are packed from the first bit on, words follow each other (PAMS-095)."""
    if variable.kind == "WORD_VAR":
        return Place(variable.address // 2 + index, 0xFFFF)
    bit = variable.bit + index
    return bit_place(variable.address + bit // 8, bit % 8)


def flag_of(words: SharedWords, place: Place) -> bool:
    return bool(words[place.cell] & place.mask)


def set_flag(words: SharedWords, place: Place, value: bool) -> None:
    word = words[place.cell]
    words[place.cell] = word | place.mask if value else word & ~place.mask


class AddressFifo:
    """One side of a FIFO: the writer owns HEAD, the reader TAIL, and each keeps its own index (PAMS-089)."""

    def __init__(self, memory: Memory, plan: PortPlan, name: str, shift: int = 0) -> None:
        """`name` is FIFO_IN or FIFO_OUT, and `shift` the first bit of HEAD and TAIL."""
        start, self._head, self._tail = (plan.numbers(f"{name}_{part}")[0] // 2 for part in ("START", "HEAD", "TAIL"))
        self._words, self._start, self._size = memory.words, start, 2 * (self._head - start)
        self._shift = shift
        self.index = 0
        """Byte index of the entry that is written or read next."""

    def reset(self) -> None:
        self.index = 0
        self._words[self._head] = self._words[self._tail] = 0

    def put(self, address: int) -> bool:
        """Write an address.  Return False if there is no room, or if the other side's TAIL is no index."""
        following = self._next()
        tail = self._words[self._tail] >> self._shift & EVEN_BYTE
        if following == tail or not self._is_index(tail):
            return False
        self._words[self._start + self.index // 2] = address
        self.index = following
        self._words[self._head] = following << self._shift
        return True

    def get(self) -> int | None:
        """Read an address; None if the FIFO is empty, or if the other side's HEAD is no index."""
        head = self._words[self._head] >> self._shift & EVEN_BYTE
        if head == self.index or not self._is_index(head):
            return None
        address = self._words[self._start + self.index // 2]
        self.index = self._next()
        self._words[self._tail] = self.index << self._shift
        return address

    def _next(self) -> int:
        return self.index + 2 if self.index + 2 < self._size else 0

    def _is_index(self, value: int) -> bool:
        return value % 2 == 0 and value < self._size
