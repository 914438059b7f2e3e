"""Reads a connection in small portions, and waits while there is a reason to.

An event loop otherwise reads megabytes at once from a client that floods, and everything else in the process waits for
seconds.  With a `Pace` the size of a portion follows from the time that the last one took.
"""

import asyncio
import time
from abc import abstractmethod
from enum import IntFlag
from typing import Final

from fieldrig.pace import Pace

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
        self._unseen = b""
        """The bytes that were read while the process had something else to do; at most a portion."""
        self.pace: Pace | None = None
        """How this process shares its time; None where it has nothing else to do."""

    def data_received(self, data: bytes) -> None:
        raise NotImplementedError

    def take(self, data: bytes) -> None:
        """Handle bytes; a subclass may look at them first."""
        self.data_received(data)

    @abstractmethod
    def read_from_now(self, is_wanted: bool) -> None:
        """Resume or pause the transport, if there is one that is open."""

    def hold(self, reason: Hold, is_held: bool) -> None:
        """Read nothing for this reason, or no longer because of it."""
        before = self._holds
        self._holds = before | reason if is_held else before & ~reason
        if not self._holds and self._unseen and self.pace is not None:
            self._handle_unseen(reason, self.pace)
        if bool(before) != bool(self._holds):
            self.read_from_now(not self._holds)

    def take_turn(self) -> None:
        """Handle what was read before the process had time for it."""
        self.hold(Hold.PACE, False)

    def get_buffer(self, sizehint: int) -> memoryview:
        return self._buffer[: self._size]

    def buffer_updated(self, nbytes: int) -> None:
        asked, pace, data = self._size, self.pace, self._buffer[:nbytes].tobytes()
        if pace is None:
            self.take(data)
        elif self._holds & Hold.PACE or not pace.is_free(self):
            self._unseen += data
            self.hold(Hold.PACE, True)
        else:
            self._handle(data, pace)
        if nbytes == asked:
            self.hold(Hold.TURN, True)
            asyncio.get_running_loop().call_soon(self.hold, Hold.TURN, False)

    def _handle_unseen(self, reason: Hold, pace: Pace) -> None:
        """Handle what was read already, now or when it is our turn."""
        if reason is not Hold.PACE and not pace.is_free(self):
            self._holds = Hold.PACE
            return
        data, self._unseen = self._unseen, b""
        self._handle(data, pace)

    def _handle(self, data: bytes, pace: Pace) -> None:
        began_ns = time.monotonic_ns()
        self.take(data)
        self._fit(len(data), pace.spent(began_ns), pace.portion_ns)

    def _fit(self, nbytes: int, took_ns: int, portion_ns: int) -> None:
        """Choose the size of the next portion."""
        if took_ns > portion_ns:
            self._size = max(LEAST_AT_ONCE, min(self._size, nbytes) // 2)
        elif nbytes == self._size < self._most and 4 * took_ns < portion_ns:
            self._size = min(self._most, 2 * self._size)
