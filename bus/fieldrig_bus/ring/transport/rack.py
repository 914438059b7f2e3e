"""The stations of one process, as the centre of a ring sees them: they share an end of the ring.

A cycle comes as one message; each station reacts, in the order in which they began to listen; then their telegrams go
back in one message.  What a station leaves at other times follows in the next iteration of the event loop.  After some
such messages the next cycle is awaited, because the transport keeps only the last ones until the centre takes them.
"""

import asyncio
import logging
import struct
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, Final, Generic, TypeVar

from fieldrig.bus import Attachment
from fieldrig_bus.ring.transport.centre import MOST_BEHIND
from fieldrig_bus.ring.transport.wire import HEAD, Stations, encode_back

log = logging.getLogger(__name__)

C = TypeVar("C")

MOST_TOGETHER: Final = 32
"""Telegrams in one message."""
MOST_BETWEEN: Final = 4
"""Messages between two cycles."""
MOST_LEFT: Final = 256
"""Telegrams that wait for the next cycle; the oldest one is lost when another comes."""


class RackStation:
    """One station of the process."""

    def __init__(self, at: Attachment, handler: Callable[[Any], None], interest: Sequence[Any] | None) -> None:
        self.at, self.handler = at, handler
        self.addresses = None if interest is None else [int(word[1]) for word in interest]
        """The addresses of the station; None if it only observes."""
        self.place = 0


class Rack(ABC, Generic[C]):
    """All methods are called in the event loop's thread, or in a thread that has taken its turn (`ThreadedLoop`)."""

    def __init__(self, bus: str, loop: asyncio.AbstractEventLoop) -> None:
        self.loop = loop
        self._bus = bus
        self.stations: dict[str, RackStation] = {}
        self.answering: tuple[RackStation, ...] = ()
        """The stations that do not only observe."""
        self._announce: Callable[[Stations], None] | None = None
        self._reply: Callable[[bytes], None] | None = None
        self._sequence = 0
        self._left: list[tuple[int, bytes]] = []
        self._is_coming_back = False
        self._between = 0
        """Messages since the last cycle."""

    @abstractmethod
    def read(self, data: bytes) -> C:
        """The cycle in a message of the centre.  ValueError for any other bytes."""

    @abstractmethod
    def deliver(self, cycle: C, instant_ns: int) -> None:
        """Deliver a cycle to the stations."""

    def __len__(self) -> int:
        return len(self.stations)

    def connect(self, announce: Callable[[Stations], None], reply: Callable[[bytes], None]) -> None:
        """Announce the stations to the centre, now and whenever they change."""
        self._announce, self._reply = announce, reply
        self._sequence = self._between = 0
        self._left.clear()
        self._announce_stations()

    def disconnect(self) -> None:
        """Stop announcing the stations, because the centre is gone."""
        self._announce = self._reply = None

    def listen(self, at: Attachment, handler: Callable[[Any], None], interest: Sequence[Any] | None) -> None:
        """Deliver cycles to a station from now on; without interest it observes everything."""
        self.stations[at.member] = RackStation(at, handler, interest)
        self._announce_stations()

    def forget(self, member: str) -> None:
        """Remove a station that was closed."""
        if self.stations.pop(member, None) is not None:
            self._announce_stations()

    def leave(self, member: str, telegram: bytes) -> None:
        """Keep a telegram of a station for the next cycle."""
        station = self.stations.get(member)
        if station is None:
            log.debug("%s is not listening to %s", member, self._bus)
            return
        if len(self._left) == MOST_LEFT:
            log.debug("%s: the oldest telegram in this process is lost", self._bus)
            del self._left[0]
        self._left.append((station.place, telegram))
        if not self._is_coming_back and self._between < MOST_BETWEEN:
            self._between += 1
            self._is_coming_back = True
            self.loop.call_soon(self._come_back)

    def on_spread(self, data: bytes) -> None:
        """Handle a cycle from the centre."""
        try:
            sequence, instant_ns = HEAD.unpack_from(data)
        except struct.error:
            log.debug("%s: too short for the head of a cycle: %s", self._bus, data.hex())
            return
        if 0 < self._sequence - sequence < MOST_BEHIND:  # further behind: the master has restarted
            log.debug("%s: cycle %d was overtaken on the way", self._bus, sequence)
            return
        try:
            cycle = self.read(data)
        except ValueError as fault:
            log.debug("%s: %s", self._bus, fault)
            return
        self._sequence = sequence
        self._between = 0
        self._is_coming_back = True  # when all stations have reacted, not after each of them
        try:
            self.deliver(cycle, instant_ns)
        finally:
            self._come_back()

    def _come_back(self) -> None:
        self._is_coming_back = False
        left, self._left = self._left, []
        if self._reply is not None:
            for first in range(0, len(left) or 1, MOST_TOGETHER):
                part = left[first : first + MOST_TOGETHER]
                self._reply(encode_back(self._sequence, time.monotonic_ns(), part))

    def _announce_stations(self) -> None:
        self.answering = tuple(station for station in self.stations.values() if station.addresses is not None)
        for number, station in enumerate(self.stations.values()):
            station.place = number
        if self._announce is not None:
            self._announce([(name, station.addresses) for name, station in self.stations.items()])
