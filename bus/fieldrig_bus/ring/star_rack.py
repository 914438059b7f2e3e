"""The drives of one process, as the centre of a star has them: they share an end of the ring.

A cycle comes as one message; each drive reacts, in the order in which they began to listen; then their ATs go back in
one message.  What a drive leaves at other times follows at the end of that turn of the loop.
"""

import asyncio
import logging
import struct
import time
from collections.abc import Callable, Sequence
from typing import Any

from fieldrig.bus import Attachment
from fieldrig_bus.ring.message import Cycle, RingMessage, decode
from fieldrig_bus.ring.star import MOST_BEHIND, Stations
from fieldrig_bus.ring.star_wire import HEAD, decode_spread, encode_back

log = logging.getLogger(__name__)


class _Station:
    def __init__(self, at: Attachment, handler: Callable[[Any], None], interest: Sequence[Any] | None) -> None:
        self.at, self.handler = at, handler
        self.addresses = None if interest is None else [int(word[1]) for word in interest]
        self.place = 0


class Rack:
    """All methods belong to whoever has the loop's turn."""

    def __init__(self, bus: str, loop: asyncio.AbstractEventLoop) -> None:
        self.loop = loop
        self._bus = bus
        self._stations: dict[str, _Station] = {}
        self._drives: tuple[_Station, ...] = ()
        """Those that don't only observe."""
        self._announce: Callable[[Stations], None] | None = None
        self._reply: Callable[[bytes], None] | None = None
        self._sequence = 0
        self._left: list[tuple[int, bytes]] = []
        self._is_coming_back = False

    def __len__(self) -> int:
        return len(self._stations)

    def connect(self, announce: Callable[[Stations], None], reply: Callable[[bytes], None]) -> None:
        """There is a centre: tell it who is here, now and when that changes."""
        self._announce, self._reply = announce, reply
        self._sequence = 0
        self._left.clear()
        self._tell()

    def disconnect(self) -> None:
        self._announce = self._reply = None

    def listen(self, at: Attachment, handler: Callable[[Any], None], interest: Sequence[Any] | None) -> None:
        self._stations[at.member] = _Station(at, handler, interest)
        self._tell()

    def forget(self, member: str) -> None:
        if self._stations.pop(member, None) is not None:
            self._tell()

    def leave(self, member: str, at: bytes) -> None:
        """Leave an AT for the next cycle."""
        station = self._stations.get(member)
        if station is None:
            log.debug("%s is not listening to %s", member, self._bus)
            return
        self._left.append((station.place, at))
        if not self._is_coming_back:
            self._is_coming_back = True
            self.loop.call_soon(self._come_back)

    def on_spread(self, data: bytes) -> None:
        """A cycle."""
        try:
            sequence, instant_ns, number, mst_end, is_more = HEAD.unpack_from(data)
        except struct.error:
            log.debug("%s: not even the head of a cycle: %s", self._bus, data.hex())
            return
        if 0 < self._sequence - sequence < MOST_BEHIND:  # further behind: the master began anew
            log.debug("%s: cycle %d was overtaken on the way", self._bus, sequence)
            return
        spread = answers = None
        if is_more or not HEAD.size <= mst_end <= len(data):
            try:
                spread = decode_spread(data)
                answers = decode(spread.answers) if spread.answers else None
            except ValueError as fault:
                log.debug("%s: %s", self._bus, fault)
                return
        self._sequence = sequence
        self._is_coming_back = True  # when all are done, not after each
        try:
            if spread is None:
                self._tell_drives(instant_ns, number, data, mst_end)
            elif len(spread.heard) == 1 and not spread.heard[0][1]:
                self._tell_all(spread.heard[0][0], answers, instant_ns)
            else:
                self._tell_some({name: cycle for cycle, names in spread.heard for name in names}, answers, instant_ns)
        finally:
            self._come_back()

    def _tell_drives(self, instant_ns: int, number: int, data: bytes, mst_end: int) -> None:
        cycle = Cycle(number, data[HEAD.size : mst_end], data[mst_end:])
        for station in self._drives:
            station.at.deliver(station.handler, cycle, instant_ns)

    def _tell_all(self, cycle: Cycle, answers: RingMessage | None, instant_ns: int) -> None:
        for station in tuple(self._stations.values()):
            if station.addresses is not None:
                station.at.deliver(station.handler, cycle, instant_ns)
            elif answers is not None:
                station.at.deliver(station.handler, answers, instant_ns)
                station.at.deliver(station.handler, cycle, instant_ns)

    def _tell_some(self, heard: dict[str, Cycle], answers: RingMessage | None, instant_ns: int) -> None:
        for name, station in tuple(self._stations.items()):
            if name in heard:
                station.at.deliver(station.handler, heard[name], instant_ns)
            elif station.addresses is None and answers is not None:
                for message in (answers, *dict.fromkeys(heard.values())):
                    station.at.deliver(station.handler, message, instant_ns)

    def _come_back(self) -> None:
        self._is_coming_back = False
        left, self._left = self._left, []
        if self._reply is not None:
            self._reply(encode_back(self._sequence, time.monotonic_ns(), left))

    def _tell(self) -> None:
        self._drives = tuple(station for station in self._stations.values() if station.addresses is not None)
        for place, station in enumerate(self._stations.values()):
            station.place = place
        if self._announce is not None:
            self._announce([(name, station.addresses) for name, station in self._stations.items()])
