"""A FIFO of blocks in the memory, with one writer and one reader (section 11.4).

Neither side needs a lock: the writer alone changes HEAD, as its last step, and the reader alone changes TAIL.
"""

from collections.abc import Sequence

from fieldrig_devices.pam.ports.memory import Memory
from fieldrig_devices.pam.ports.vme.layout import (
    BLOCK_SIZE,
    BLOCK_WORDS,
    BLOCKS,
    BODIES,
    HEAD,
    MAX_BLOCKS,
    OFFSET,
    TAIL,
)


class Fifo:
    """The PAM's side.  It keeps its own index, so it does not depend on what a master writes over it."""

    def __init__(self, memory: Memory, header: int) -> None:
        self._words, self._header, self._body = memory.words, header, BODIES[header]
        self.index = 0
        """Number of the block that is written or read next."""

    def reset(self) -> None:
        """Fill the header in; the FIFO is empty then (manual lines 9415 to 9422)."""
        self.index = 0
        words, header = self._words, self._header
        words[header + OFFSET] = 2 * self._body
        words[header + HEAD] = words[header + TAIL] = 0
        words[header + MAX_BLOCKS] = BLOCKS
        words[header + BLOCK_SIZE] = 2 * BLOCK_WORDS

    def put(self, block: Sequence[int]) -> bool:
        """Write a block.  Return False if there is no room, or if the master's TAIL is no index."""
        following = (self.index + 1) % BLOCKS
        tail = self._words[self._header + TAIL]
        if following == tail or tail >= BLOCKS:
            return False
        first = self._body + self.index * BLOCK_WORDS
        for cell, word in enumerate(block, first):
            self._words[cell] = word
        self._words[self._header + HEAD] = self.index = following
        return True

    def get(self) -> tuple[int, ...] | None:
        """Read a block; None if the FIFO is empty, or if the master's HEAD is no index."""
        head = self._words[self._header + HEAD]
        if head == self.index or head >= BLOCKS:
            return None
        first = self._body + self.index * BLOCK_WORDS
        block = tuple(self._words[cell] for cell in range(first, first + BLOCK_WORDS))
        self._words[self._header + TAIL] = self.index = (self.index + 1) % BLOCKS
        return block

    @property
    def is_empty(self) -> bool:
        head = self._words[self._header + HEAD]
        return head == self.index or head >= BLOCKS
