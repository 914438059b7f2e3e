"""The data that a modem has to send: they go to the network some milliseconds ahead of the rate of the carrier.

A modem gets data far faster than the line carries them.  They are kept here, and when many are waiting, their source is
asked to stop.
"""

from collections.abc import Callable

from fieldrig.clock import MS, Clock, S, Timer
from fieldrig.link import Link
from fieldrig_bus.telephone.message import Carrier, TelephoneMessage
from fieldrig_bus.telephone.transmitter import bits_per_character

AHEAD_NS = 20 * MS
"""Time by which data are passed to the network ahead."""
MOST_WAITING, FEW_WAITING = 1024, 256
"""Waiting characters from which on the source should stop, and down to which it should not go on."""


class Pump:
    """`on_room(False)` is called when the source should stop, `on_room(True)` when it may go on."""

    def __init__(self, link: Link[TelephoneMessage], clock: Clock) -> None:
        self._link, self._clock = link, clock
        self.on_room: Callable[[bool], None] = lambda _has_room: None
        self.on_empty: Callable[[], None] = lambda: None
        """Called when everything has left the line."""
        self._waiting = bytearray()
        self._carrier = Carrier(0)
        self._free_ns = 0
        self._timer: Timer | None = None
        self._is_held = False
        self.has_room = True

    @property
    def waiting(self) -> int:
        """Number of bytes that the network does not have yet."""
        return len(self._waiting)

    @property
    def is_running(self) -> bool:
        """True between the beginning and the end of a carrier."""
        return self._carrier.bps > 0

    def start(self, carrier: Carrier) -> None:
        """Begin with this carrier of our own; a rate of 0 ends it, and discards what waits."""
        self._carrier, self._is_held, self._free_ns = carrier, False, self._clock.now_ns()
        if not carrier.bps:
            self._waiting.clear()
        self._feed()

    def send(self, data: bytes) -> None:
        self._waiting += data
        self._feed()

    def hold(self, is_held: bool) -> None:
        """Hold the data while the other modem is not ready, or send again."""
        self._is_held = is_held
        self._feed()

    def _feed(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        waiting, carrier = self._waiting, self._carrier
        if waiting and carrier.bps and not self._is_held:
            if carrier.is_paced:
                self._feed_paced(waiting)
            else:
                self._link.send(bytes(waiting))
                waiting.clear()
        self._tell_room(len(waiting))
        if not waiting and carrier.bps:
            self._await_empty()

    def _feed_paced(self, waiting: bytearray) -> None:
        now_ns = self._clock.now_ns()
        begin_ns = max(self._free_ns, now_ns)
        bits = bits_per_character(self._carrier)
        ahead_ns = now_ns + AHEAD_NS - begin_ns
        if ahead_ns > 0:
            portion = bytes(waiting[: max(1, ahead_ns * self._carrier.bps // (bits * S))])
            del waiting[: len(portion)]
            begin_ns = self._free_ns = begin_ns + len(portion) * bits * S // self._carrier.bps
            self._link.send(portion)
        if waiting:
            self._timer = self._clock.call_at(begin_ns - AHEAD_NS // 2, self._feed)

    def _tell_room(self, waiting: int) -> None:
        has_room = waiting < (MOST_WAITING if self.has_room else FEW_WAITING)
        if has_room != self.has_room:
            self.has_room = has_room
            self.on_room(has_room)

    def _await_empty(self) -> None:
        if self._free_ns <= self._clock.now_ns():
            self.on_empty()
        else:
            self._timer = self._clock.call_at(self._free_ns, self._feed)
