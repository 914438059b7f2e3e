"""V1 to V1000, which are permanent: a list for speed, backed by battery-powered RAM (manual 4.3).

Programs, regulators and the ports write to the list.  `keep` copies changes to the RAM: at the end of each control
loop, and before anything about a variable leaves the card.  It compares the list with the values of the last call,
which costs CPython next to nothing while the numbers are the same objects, so a writer does not have to report its
changes.  A variable that has changed once will change again, so these are checked first.

The RAM is 1001 words of 32 bits: a mark, then the variables.  Any 32 bits are a valid variable, so a damaged RAM may
contain wrong values, but none that the card cannot process.
"""

from array import array
from contextlib import suppress
from enum import Enum, auto
from typing import Final

from fieldrig.storage.store import Store, StoreError

COUNT: Final = 1_000
MARK: Final = 0x41525056  # ARPV: this RAM contains variables
_CHUNK: Final = 125
_MOST_BUSY: Final = 48
"""Maximum number of variables that are checked one by one; beyond it, comparing everything is faster."""


class Ram(Enum):
    """Content of the RAM at power-on."""

    BLANK = auto()
    GOOD = auto()
    DAMAGED = auto()


class Permanent:
    def __init__(self, store: Store) -> None:
        self.V = [0] * (COUNT + 1)  # element 0 is not used
        self._kept = list(self.V)
        self._busy: list[int] = []
        self._spans = [slice(first, first + _CHUNK) for first in range(0, COUNT + 1, _CHUNK)]
        self._store = store
        self._ram = memoryview(bytearray(4 * (COUNT + 1))).cast("i")
        self._is_lasting = False

    def load(self) -> Ram:
        """Load the variables at power-on.

        Raises StoreError if there is no RAM; variables then last until power-off, or until `find_ram` succeeds.
        """
        self._is_lasting = False
        self._ram = self._buffered()
        mark = self._ram[0]
        state = {0: Ram.BLANK, MARK: Ram.GOOD}.get(mark, Ram.DAMAGED)
        if state is not Ram.GOOD:
            self._ram[:] = memoryview(bytearray(4 * (COUNT + 1))).cast("i")
        self._ram[0] = MARK
        self.V[1:] = self._ram[1:].tolist()
        self._kept[:] = self.V
        return state

    def find_ram(self) -> None:
        """Request the RAM that was missing at power-on, and save the present variables there."""
        if not self._is_lasting:
            with suppress(StoreError):
                self._ram = self._buffered()
                self._ram[:] = array("i", (MARK, *self._kept[1:]))

    def _buffered(self) -> memoryview:
        ram = self._store.buffered_ram(4 * (COUNT + 1)).cast("i")
        self._is_lasting = True
        return ram

    def keep(self) -> None:
        """Save all changes since the last call, so that they survive power-off."""
        variables, kept = self.V, self._kept
        if variables == kept:
            return
        ram = self._ram
        for number in self._busy:
            value = variables[number]
            if value is not kept[number]:
                kept[number] = ram[number] = value
        if variables != kept:
            self._search()

    def _search(self) -> None:
        variables, kept, ram, busy = self.V, self._kept, self._ram, self._busy
        for span in self._spans:
            if variables[span] != kept[span]:
                for number in range(span.start, min(span.stop, COUNT + 1)):
                    if variables[number] != kept[number]:
                        kept[number] = ram[number] = variables[number]
                        busy.append(number)
        if len(busy) > _MOST_BUSY:
            busy.clear()
