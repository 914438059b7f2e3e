"""Data that wait for a slow line: they are passed to it some milliseconds ahead, as the FIFO of a UART would be.

Their source may send far faster than the line transmits.  When many data are waiting, it is asked to stop.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable

from fieldrig.clock import MS, Alarm, Clock

AHEAD_NS = 20 * MS
"""Time by which data are passed to the line ahead.  After the other end has asked to wait, this much is still sent."""


class SendingAhead(ABC):
    """`on_room(False)` is called when the source should stop, `on_room(True)` when it may go on."""

    def __init__(self, clock: Clock, send: Callable[[bytes], None], most: int, few: int) -> None:
        """The source should stop from `most` waiting characters on, and go on when fewer than `few` wait."""
        self._clock, self._pass_on = clock, send
        self._most, self._few = most, few
        self.on_room: Callable[[bool], None] = lambda _has_room: None
        self._waiting = bytearray()
        self._free_ns = 0
        """The instant at which the line has transmitted everything that it got."""
        self._timer = Alarm(self._clock)
        self._is_held = False
        self.has_room = True

    @property
    def waiting(self) -> int:
        """The number of bytes that the line does not have yet."""
        return len(self._waiting)

    @property
    def is_sending(self) -> bool:
        """True until the line has transmitted everything, which takes longer than expected if the host is late."""
        return bool(self._waiting) or self._free_ns > self._clock.now_ns()

    @property
    def sent_ns(self) -> int:
        """The instant at which the line has transmitted everything, provided that the other end does not hold it."""
        waiting_ns = self._duration_ns(len(self._waiting)) if self._is_paced else 0
        return max(self._free_ns, self._clock.now_ns()) + waiting_ns

    @property
    @abstractmethod
    def _is_paced(self) -> bool:
        """True if data take their time; otherwise all that waits is passed on at once."""

    @property
    def _is_open(self) -> bool:
        """True if the line takes data."""
        return True

    @abstractmethod
    def _characters_in(self, duration_ns: int) -> int:
        """Return the number of characters that the line transmits in this time, in nanoseconds."""

    @abstractmethod
    def _duration_ns(self, characters: int) -> int:
        """Return the time in nanoseconds that the line takes for this number of characters."""

    @abstractmethod
    def _has_emptied(self) -> None:
        """Nothing waits any more, but the line may still transmit what it got."""

    def send(self, data: bytes) -> None:
        self._waiting += data
        self._feed()

    def hold(self, is_held: bool) -> None:
        """Hold the data while the other end is not ready, or send them again."""
        self._is_held = is_held
        self._feed()

    def _feed(self) -> None:
        """Pass on as much as the line transmits in the next `AHEAD_NS`, and the rest later."""
        self._timer.stop()
        waiting = self._waiting
        if waiting and self._is_open and not self._is_held:
            if self._is_paced:
                self._feed_paced(waiting)
            else:
                self._pass_on(bytes(waiting))
                waiting.clear()
        self._tell_room(len(waiting))
        if not waiting:
            self._has_emptied()

    def _feed_paced(self, waiting: bytearray) -> None:
        now_ns = self._clock.now_ns()
        begin_ns = max(self._free_ns, now_ns)
        ahead_ns = now_ns + AHEAD_NS - begin_ns
        if ahead_ns > 0:
            portion = bytes(waiting[: max(1, self._characters_in(ahead_ns))])
            del waiting[: len(portion)]
            begin_ns = self._free_ns = begin_ns + self._duration_ns(len(portion))
            self._pass_on(portion)
        if waiting:
            # Half of the time ahead is left then, so that a host that is late by less does not let the line run dry.
            self._timer.at(begin_ns - AHEAD_NS // 2, self._feed)

    def _tell_room(self, waiting: int) -> None:
        has_room = waiting < (self._most if self.has_room else self._few)
        if has_room != self.has_room:
            self.has_room = has_room
            self.on_room(has_room)
