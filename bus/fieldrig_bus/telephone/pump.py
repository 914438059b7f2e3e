"""The data that a modem has to send: they go to the network some milliseconds ahead of the rate of the carrier."""

from collections.abc import Callable

from fieldrig.clock import Clock, S
from fieldrig.link import Link
from fieldrig_bus.sending_ahead import SendingAhead
from fieldrig_bus.telephone.message import Carrier, TelephoneMessage
from fieldrig_bus.telephone.transmitter import bits_per_character

MOST_WAITING, FEW_WAITING = 1024, 256
"""Waiting characters from which on the source should stop, and down to which it should not go on."""


class Pump(SendingAhead):
    """`on_room(False)` is called when the source should stop, `on_room(True)` when it may go on."""

    def __init__(self, link: Link[TelephoneMessage], clock: Clock) -> None:
        super().__init__(clock, link.send, MOST_WAITING, FEW_WAITING)
        self.on_empty: Callable[[], None] = lambda: None
        """Called when everything has left the line."""
        self._carrier = Carrier(0)

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

    @property
    def _is_paced(self) -> bool:
        return self._carrier.is_paced

    @property
    def _is_open(self) -> bool:
        return self.is_running

    def _characters_in(self, duration_ns: int) -> int:
        return duration_ns * self._carrier.bps // (bits_per_character(self._carrier) * S)

    def _duration_ns(self, characters: int) -> int:
        return characters * bits_per_character(self._carrier) * S // self._carrier.bps

    def _has_emptied(self) -> None:
        if not self.is_running:
            return
        if self._free_ns <= self._clock.now_ns():
            self.on_empty()
        else:
            self._timer.at(self._free_ns, self._feed)
