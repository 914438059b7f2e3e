"""The centre of a ring in real time: it stands in the master's process and hosts the fibre.

When the master sends its MST, it hears at once of the ATs that lie in the buffers; when it sends its MDT, one message
with the whole cycle goes to each process of drives, and one with its ATs comes back, which has time until the next
MST.  A process that is not done by then is late: its stations' ATs are missing, which is counted for each of them.
Stations join when their process says so, and are gone the instant it is.
Left out: the time that telegrams take on the fibre; it is less than the machine's own.
"""

import asyncio
import logging
import time
from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from random import Random
from typing import TYPE_CHECKING, Any, Final, Protocol

from fieldrig.bus import Attachment
from fieldrig.clock import MS
from fieldrig.errors import refusals
from fieldrig_bus.ring.fibre import Fibre, Station
from fieldrig_bus.ring.message import Answers, Mdt, Mst, RingMessage, encode
from fieldrig_bus.ring.model import RING
from fieldrig_bus.ring.star_wire import decode_back, encode_spread

if TYPE_CHECKING:
    from fieldrig_bus.ring.star_bus import RingStarSettings

log = logging.getLogger(__name__)

MOST_BEHIND: Final = 16
"""Cycles that wait for a process that stands still; it hears no more until it has done them."""

OPERATION: Final = 3
"""The phase from which every station answers in every cycle."""

TRIPS: Final = 700
"""Round trips that statistics look back on."""
_32: Final = 0xFFFF_FFFF

Stations = Sequence[tuple[str, Sequence[int] | None]]
"""Names and addresses, in the order in which a process counts its stations; None: it observes."""


class Spokes(Protocol):
    """What carries the messages between the centre and other processes."""

    def spread(self, message: bytes, hung: Collection[str]) -> None:
        """To all processes but those that stand still.  It never blocks."""

    def gather(self) -> Iterable[tuple[str, bytes]]:
        """What has come back since the last call: from whom, and what."""

    def close(self) -> None: ...


class _Spoke:
    """One process, as the centre has it."""

    def __init__(self, sequence: int) -> None:
        self.names: list[str] = []
        self.stations: list[Station | None] = []
        """Of these names; None: another process has it now."""
        self.ats: dict[Station, bytes] = {}
        """What they left last, while the ring is patient."""
        self.done = sequence
        self.late_ns: int | None = None
        """Since when it is late."""


class Star:
    def __init__(
        self,
        bus: str,
        at: Attachment,
        settings: "RingStarSettings",
        handler: Callable[[Any], None],
        loop: asyncio.AbstractEventLoop,
    ) -> None:
        """`at` is the master's."""
        self.handler, self.loop = handler, loop
        self._bus, self._at = bus, at
        self._fibre = Fibre(settings.order, settings.mbaud, settings.bypassed, settings.faults, at.members)
        self._fibre.begin(at.clock.now_ns(), Random(f"{at.seed}/{bus}"))
        self._fibre.join(at.member)
        self._fibre.listen(at.member, ["master"])
        self._patience_ns = settings.patience_ms * MS
        self._spokes: Spokes | None = None
        self._local: tuple[str, Callable[[bytes], None]] | None = None
        self._processes: dict[str, _Spoke] = {}
        self._owners: dict[str, _Spoke] = {}
        self._sequence = 0
        self._answers: Answers | None = None
        self._awaited: dict[str, _Spoke] = {}
        """Those that are not done with this cycle."""
        self._hung: dict[str, int] = {}
        """Those that stand still, and the last cycle that each was sent."""
        self._late: dict[str, int] = {}
        self._most_behind = self._late_cycles = 0
        self._spread_ns = self._done_ns = 0
        self._trips_ns: deque[int] = deque(maxlen=TRIPS)

    def open(self, spokes: Spokes) -> None:
        self._spokes = spokes

    def open_local(self, who: str, on_spread: Callable[[bytes], None]) -> None:
        """For the stations of this process; what comes back is given to `take`."""
        self._local = who, on_spread

    def close(self) -> None:
        if self._spokes is not None:
            self._spokes.close()

    # ---- stations

    def announce(self, who: str, stations: Stations) -> None:
        """All stations that a process has."""
        if not stations:
            self.lose(who)
            return
        process = self._processes.setdefault(who, _Spoke(self._sequence))
        kept = {name for name, _ in stations}
        for name in process.names:
            if name not in kept:
                self._forget(name, process)
        process.names = [name for name, _ in stations]
        for name, addresses in stations:
            if name == self._at.member:
                log.warning("%s: %s is the master of the ring, and no drive of %s", self._bus, name, who)
                continue
            former = self._owners.get(name)
            if former is None:
                self._fibre.join(name)
            elif former is not process:
                former.ats.pop(self._fibre.stations[name], None)
            self._owners[name] = process
            self._fibre.listen(name, None if addresses is None else [["drive", address] for address in addresses])
        for one in self._processes.values():
            one.stations = [self._fibre.stations[name] if self._owners.get(name) is one else None for name in one.names]

    def lose(self, who: str) -> None:
        """A process is gone."""
        process = self._processes.pop(who, None)
        self._hung.pop(who, None)
        self._awaited.pop(who, None)
        if process is not None:
            for name in process.names:
                self._forget(name, process)

    def _forget(self, name: str, process: _Spoke) -> None:
        if self._owners.get(name) is process:  # it may have come back in another one
            del self._owners[name]
            process.ats.pop(self._fibre.stations[name], None)
            self._fibre.leave(name)

    def take(self, who: str, data: bytes) -> None:
        """What came back from a process."""
        process = self._processes.get(who)
        if process is None:
            return
        try:
            process.done, instant_ns, ats = decode_back(data)
        except ValueError as fault:
            log.debug("%s: %s: %s", self._bus, who, fault)
            return
        if instant_ns > self._done_ns:
            self._done_ns = instant_ns
        if process.done == self._sequence:
            self._awaited.pop(who, None)
            process.late_ns = None
        stations = process.stations
        for place, at in ats:
            station = stations[place] if place < len(stations) else None
            if station is not None:
                station.lay(at)
                if self._patience_ns:
                    process.ats[station] = at

    # ---- cycles

    def send(self, message: RingMessage) -> None:
        """From the master, as part of the event that it is handling."""
        if isinstance(message, Mst):
            self._begin_cycle(message)
        elif isinstance(message, Mdt):
            self._end_cycle(message.data)

    def _begin_cycle(self, mst: Mst) -> None:
        self._gather()
        late = self._count_late()
        self._late_cycles += bool(late)
        if self._patience_ns:
            self._forgive(mst)
        if not late and self._spread_ns:
            self._trips_ns.append(max(self._done_ns - self._spread_ns, 0))
        self._end_cycle(b"")
        answers = self._answers = self._fibre.begin_cycle(self._at.clock.now_ns(), mst, late)
        self._at.heard(RING, answers)
        self._at.deliver(self.handler, answers)

    def _end_cycle(self, mdt: bytes) -> None:
        heard = self._fibre.end_cycle(self._at.clock.now_ns(), mdt)
        if not heard:
            return
        self._sequence = self._sequence + 1 & _32
        self._spread_ns, self._done_ns = time.monotonic_ns(), 0
        observed = encode(self._answers) if self._fibre.observers and self._answers is not None else b""
        message = encode_spread(self._sequence, self._at.clock.now_ns(), heard, observed, self._fibre.station_count)
        self._awaited = self._processes.copy()
        if self._spokes is not None:
            self._spokes.spread(message, self._hung)
        if self._local is not None and self._local[0] in self._processes:
            self.loop.call_soon(self._local[1], message)
        for cycle, _ in heard:
            self._at.heard(self._at.member, cycle)

    def _gather(self) -> None:
        if self._spokes is not None:
            for who, data in self._spokes.gather():
                self.take(who, data)

    def _count_late(self) -> int:
        """Stations whose process is not done with the cycle before."""
        if self._hung:
            self._look_after_hung()
        late, sequence = 0, self._sequence
        for who, process in self._awaited.items():
            behind = sequence - process.done & _32
            self._most_behind = max(self._most_behind, behind)
            for name in process.names:
                self._late[name] = self._late.get(name, 0) + 1
            late += len(process.names)
            if who not in self._hung and behind >= MOST_BEHIND:
                log.debug("%s: %s is %d cycles behind; it is left alone", self._bus, who, MOST_BEHIND)
                self._hung[who] = sequence
        return late

    def _forgive(self, mst: Mst) -> None:
        """For an AT that is late the last one stands in: its service channel goes on where it was."""
        if mst.data[1] & 7 < OPERATION:
            for process in self._processes.values():
                process.ats.clear()
        now_ns = self._at.clock.now_ns()
        for process in self._awaited.values():
            if process.late_ns is None:
                process.late_ns = now_ns
            if now_ns - process.late_ns <= self._patience_ns:
                for station, at in process.ats.items():
                    station.lay(at)

    def _look_after_hung(self) -> None:
        """Whether one that stood still has done what it was sent."""
        for who, sent in tuple(self._hung.items()):
            process = self._processes[who]
            if self._is_done(process, sent):
                log.debug("%s: %s is back", self._bus, who)
                del self._hung[who]
                self._awaited.pop(who, None)
                process.done, process.late_ns = self._sequence, None

    @staticmethod
    def _is_done(process: _Spoke, sent: int) -> bool:
        """With all that it was sent; it may even have found what it wasn't woken for."""
        return process.done - sent & _32 < 2**31

    # ---- for people

    def awaited(self) -> list[str]:
        """Processes that are not done with what they were sent."""
        self._gather()
        sequence, hung = self._sequence, self._hung
        return [who for who, one in self._awaited.items() if not self._is_done(one, hung.get(who, sequence))]

    @property
    def is_observed(self) -> bool:
        return bool(self._fibre.observers)

    def statistics(self) -> dict[str, float]:
        """`late.NAME` counts for one station, `late_cycles` those in which any was late; `most_cycles_late` is how far
        any process ever was behind.

        A trip is from the spreading of a cycle until the last process is done with it, by its own clock.
        """
        trips_us = sorted(trip_ns / 1e3 for trip_ns in self._trips_ns) or [0.0]
        trips = {f"trip_p{percent}_us": trips_us[len(trips_us) * percent // 100] for percent in (50, 99)}
        by_station = {f"late.{name}": float(count) for name, count in self._late.items()}
        general = self._fibre.statistics(self._at.clock.now_ns())
        return {
            **general,
            **trips,
            "late_cycles": float(self._late_cycles),
            "most_cycles_late": float(self._most_behind),
            **by_station,
        }

    def add_fault(self, fault: Mapping[str, Any]) -> int:
        with refusals(self._bus):
            return self._fibre.add_fault(self._at.clock.now_ns(), fault)

    def clear_fault(self, number: int) -> None:
        with refusals(self._bus):
            self._fibre.clear_fault(number)

    def faults(self) -> Mapping[int, Mapping[str, Any]]:
        return self._fibre.faults.about(self._at.clock.now_ns())
