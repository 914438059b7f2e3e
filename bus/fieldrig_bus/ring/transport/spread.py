"""One cycle as the processes of stations get it, where a fault makes stations hear different things.

The cycle goes out once.  If not all stations hear it alike, or if a member observes, rows follow that name the stations
and say by a number what each one hears.  The kind of ring defines these numbers, and what is in the cycle.
"""

import asyncio
import struct
from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final, Generic, NamedTuple, TypeVar

from fieldrig.shortcuts import Shortcut
from fieldrig_bus.ring.transport.rack import Rack

ALIKE: Final = Shortcut("ring.alike", "a cycle that all stations hear alike is delivered without a look at each name")
_ROW: Final = struct.Struct("<BB")  # what it hears, length of its name

C = TypeVar("C")


def encode_rows(rows: Iterable[tuple[int, Sequence[str]]]) -> bytes:
    """The stations, as bytes, by the number that says what they hear."""
    encoded = bytearray()
    for hears, names in rows:
        for name in names:
            text = name.encode()
            encoded += _ROW.pack(hears, len(text)) + text
    return bytes(encoded)


def decode_rows(rows: bytes) -> dict[int, list[str]]:
    """The inverse of `encode_rows`.  ValueError or struct.error for anything else."""
    groups: dict[int, list[str]] = {}
    start = 0
    while start < len(rows):
        hears, length = _ROW.unpack_from(rows, start)
        start += _ROW.size + length
        if start > len(rows):
            raise ValueError("the name of a station in a cycle is cut short")
        groups.setdefault(hears, []).append(rows[start - length : start].decode())
    return groups


class Spread(NamedTuple, Generic[C]):
    """One cycle, as every process gets it."""

    sequence: int
    instant_ns: int
    """The instant by the clock of the master's machine."""
    heard: Sequence[tuple[C, Sequence[str]]]
    """Cycles with the stations that hear them; without names, all stations hear the cycle."""
    answers: bytes
    """The message to the master in this cycle, encoded, if any member observes."""


class SpreadRack(Rack["C | tuple[Spread[C], Any]"], Generic[C]):
    """The rack of one process.  A cycle that all stations hear alike, which nearly all are, takes a short way."""

    def __init__(self, bus: str, loop: asyncio.AbstractEventLoop) -> None:
        super().__init__(bus, loop)
        self._looks_at_each = not ALIKE.is_taken

    @abstractmethod
    def read_alike(self, data: bytes) -> C | None:
        """The cycle, if all stations hear it alike and no member observes; otherwise None."""

    @abstractmethod
    def read_spread(self, data: bytes) -> tuple[Spread[C], Any]:
        """Return what each station hears, and what the master hears or None.  ValueError for anything else."""

    def read(self, data: bytes) -> "C | tuple[Spread[C], Any]":
        alike = None if self._looks_at_each else self.read_alike(data)
        return self.read_spread(data) if alike is None else alike

    def deliver(self, cycle: "C | tuple[Spread[C], Any]", instant_ns: int) -> None:
        if not isinstance(cycle, tuple):
            for station in self.answering:
                station.at.deliver(station.handler, cycle, instant_ns)
            return
        spread, answers = cycle
        is_alike = len(spread.heard) == 1 and not spread.heard[0][1]
        if is_alike and self._looks_at_each:
            names = [name for name, station in self.stations.items() if station.addresses is not None]
            self._deliver_to_some(dict.fromkeys(names, spread.heard[0][0]), answers, instant_ns)
        elif is_alike:
            self._deliver_to_all(spread.heard[0][0], answers, instant_ns)
        else:
            heard = {name: cycle for cycle, names in spread.heard for name in names}
            self._deliver_to_some(heard, answers, instant_ns)

    def _deliver_to_all(self, cycle: C, answers: Any, instant_ns: int) -> None:
        for station in tuple(self.stations.values()):
            if station.addresses is not None:
                station.at.deliver(station.handler, cycle, instant_ns)
            elif answers is not None:
                station.at.deliver(station.handler, answers, instant_ns)
                station.at.deliver(station.handler, cycle, instant_ns)

    def _deliver_to_some(self, heard: Mapping[str, C], answers: Any, instant_ns: int) -> None:
        for name, station in tuple(self.stations.items()):
            if name in heard:
                station.at.deliver(station.handler, heard[name], instant_ns)
            elif station.addresses is None and answers is not None:
                for message in (answers, *dict.fromkeys(heard.values())):
                    station.at.deliver(station.handler, message, instant_ns)
