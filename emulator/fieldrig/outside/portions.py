"""Reads a connection in small portions, and waits while there is a reason to.

An event loop otherwise reads megabytes at once from a client that floods, and everything else in the process waits for
seconds.  With a `Pace`, clients take turns, a message each, so one that pipelines does not delay another one by more
than a message.  Where nothing tells the end of a message, a turn is a portion, and its size follows from the time that
the last one took.
"""

import asyncio
import time
from abc import abstractmethod
from enum import IntFlag
from typing import Final

from fieldrig.loop.pace import Pace

MOST_AT_ONCE: Final = 4096
"""Bytes read before the event loop continues with others."""
LEAST_AT_ONCE: Final = 64
"""Size of a portion, in bytes, where even a small one takes long."""


class Hold(IntFlag):
    """Reasons to read nothing."""

    OWN = 1
    """The protocol has enough to do."""
    HUB = 2
    """The devices of the bus have enough to do."""
    PACE = 4
    """The process has something else to do."""
    TURN = 8
    """Others have their turn first."""


class Portions(asyncio.BufferedProtocol):
    """A protocol whose subclass handles bytes in `data_received`."""

    def __init__(self, most: int = MOST_AT_ONCE) -> None:
        self._buffer = memoryview(bytearray(most))
        self._most = self._size = most
        self._holds = 0
        self._is_reading = True
        self._is_handling = False
        self._unseen = b""
        """The bytes that were read and wait for their turn; at most a portion."""
        self.pace: Pace | None = None
        """How this process shares its time; None where it has nothing else to do."""

    @property
    def is_pending(self) -> bool:
        """True while bytes that were read wait for their turn."""
        return bool(self._unseen)

    def data_received(self, data: bytes) -> None:
        raise NotImplementedError

    def end_of_first(self, data: bytes) -> int:
        """Return the length of the first message in `data`, which may be the rest of one; all of it if that is open.

        Where clients have to take turns, a turn is for this many bytes.
        """
        return len(data)

    def take(self, data: bytes) -> None:
        """Handle bytes; a subclass may look at them first."""
        self.data_received(data)

    @abstractmethod
    def read_from_now(self, is_wanted: bool) -> None:
        """Resume or pause the transport, if there is one that is open."""

    def hold(self, reason: Hold, is_held: bool) -> None:
        """Read nothing for this reason, or no longer because of it."""
        self._holds = self._holds | reason if is_held else self._holds & ~reason
        self._handle_what_waits(is_turn=False)

    def take_turn(self) -> None:
        """Handle a message that was read before the process had time for it."""
        self._holds &= ~Hold.PACE
        self._handle_what_waits(is_turn=True)

    def get_buffer(self, sizehint: int) -> memoryview:
        return self._buffer[: self._size]

    def buffer_updated(self, nbytes: int) -> None:
        asked, data = self._size, self._buffer[:nbytes].tobytes()
        if self.pace is None:
            self.take(data)
        else:
            self._unseen += data
            self._handle_what_waits(is_turn=False)
        if nbytes == asked:
            self.hold(Hold.TURN, True)
            asyncio.get_running_loop().call_soon(self.hold, Hold.TURN, False)

    def _handle_what_waits(self, is_turn: bool) -> None:
        """Handle what was read, until there is a reason to wait, and read on when all of it is handled."""
        if self._is_handling:  # a hold begins or ends while a message is handled
            return
        self._is_handling = True
        try:
            while self._unseen and not self._holds and self.pace is not None:
                if is_turn or self.pace.is_free(self):
                    self._handle_first(self.pace)
                else:
                    self._holds |= Hold.PACE
                is_turn = False
        finally:
            self._is_handling = False
        is_wanted = not self._holds and not self._unseen
        if is_wanted != self._is_reading:
            self._is_reading = is_wanted
            self.read_from_now(is_wanted)

    def _handle_first(self, pace: Pace) -> None:
        began_ns, size = time.monotonic_ns(), self.end_of_first(self._unseen)
        data, self._unseen = self._unseen[:size], self._unseen[size:]
        self.take(data)
        self._fit(size, pace.spent(began_ns), pace.portion_ns)

    def _fit(self, nbytes: int, took_ns: int, portion_ns: int) -> None:
        """Choose the size of the next portion."""
        if took_ns > portion_ns:
            self._size = max(LEAST_AT_ONCE, min(self._size, nbytes) // 2)
        elif nbytes == self._size < self._most and 4 * took_ns < portion_ns:
            self._size = min(self._most, 2 * self._size)
