"""The centre of a ring in real time: it is in the master's process and hosts the medium.

Each cycle goes to each process of stations as one message, and one with the telegrams that its stations leave comes
back, which has time until the next cycle begins.  A process that is not done by then is late: the telegrams of its
stations are missing, which is counted for each of them.  Stations join when their process announces them, and leave
when it is gone.  A subclass for each kind of ring defines what a cycle contains.
"""

import asyncio
import logging
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any, Final, Protocol

from fieldrig.bus import Attachment
from fieldrig.errors import refusals
from fieldrig.faults.note import FaultNote
from fieldrig_bus.ring.model import RING
from fieldrig_bus.ring.transport.wire import SEQUENCES, Stations, decode_back

log = logging.getLogger(__name__)

MOST_BEHIND: Final = 16
"""Cycles that wait for a process that stands still, where nothing is lost by it: later cycles say the same."""
TRIPS: Final = 700
"""Round trips that the statistics cover."""


class Buffer(Protocol):
    """One station, with a buffer for its telegram of the next cycle."""

    def lay(self, telegram: bytes) -> None:
        """Put a telegram into the buffer of the station."""


class Ring(Protocol):
    """The medium that a centre hosts."""

    @property
    def stations(self) -> Mapping[str, Buffer]:
        """Everything that has joined, by name."""

    @property
    def observers(self) -> Collection[str]:
        """Members that hear everything without being a station."""

    def join(self, name: str) -> None:
        """Add a member."""

    def leave(self, name: str) -> None:
        """Remove a member."""

    def answer_at(self, name: str, addresses: Sequence[int] | None) -> None:
        """Make the member a station with these addresses from now on, or an observer for None."""

    def statistics(self, now_ns: int) -> dict[str, float]:
        """Counters by name with unit."""

    def conditions(self, now_ns: int) -> Mapping[str, str]:
        """The states that are reported to a person, by a name of their own."""

    def add_fault(self, now_ns: int, fault: Mapping[str, Any]) -> int:
        """Inject a fault, and return its number."""

    def begin_fault(self, now_ns: int, number: int) -> None:
        """Begin a fault that waits for its condition."""

    def clear_fault(self, number: int) -> None:
        """Clear a fault.  ValueError if there is none with this number."""

    def all_faults(self, now_ns: int) -> Mapping[int, Mapping[str, Any]]:
        """Injected faults by number."""

    def take_notes(self, now_ns: int) -> Iterable[FaultNote]:
        """Return what faults have done since the last call."""


class Spokes(Protocol):
    """The centre's side of the transport to other processes."""

    def spread(self, message: bytes, hung: Collection[str]) -> None:
        """Send to all processes but those that stand still.  It never blocks."""

    def gather(self) -> Iterable[tuple[str, bytes]]:
        """Take the messages that have come back since the last call, each with its process."""

    def close(self) -> None:
        """Disconnect from all processes."""


class _Process:
    """One process of stations, as the centre sees it."""

    def __init__(self, sequence: int) -> None:
        self.names: list[str] = []
        self.stations: list[Buffer | None] = []
        """Stations by position in `names`; None if another process has taken the station over."""
        self.telegrams: dict[Buffer, bytes] = {}
        """The last telegrams of its stations, while late answers are tolerated."""
        self.done = sequence
        self.late_ns: int | None = None
        """The instant since which it has been late."""


class Centre(ABC):
    """The centre of one ring."""

    def __init__(
        self,
        bus: str,
        at: Attachment,
        ring: Ring,
        patience_ns: int,
        handler: Callable[[Any], None],
        loop: asyncio.AbstractEventLoop,
        most_behind: int = MOST_BEHIND,
    ) -> None:
        """`at` and `handler` are those of the master; late answers are tolerated for `patience_ns`.

        `most_behind` cycles wait for a process that stands still; it is sent no more until it has done them.
        """
        self.handler, self.loop = handler, loop
        self._bus, self._at, self._ring = bus, at, ring
        self._patience_ns, self._most_sent = patience_ns, most_behind
        self._spokes: Spokes | None = None
        self._local: tuple[str, Callable[[bytes], None]] | None = None
        self._processes: dict[str, _Process] = {}
        self._owners: dict[str, _Process] = {}
        self._sequence = 0
        self._awaited: dict[str, _Process] = {}
        """Processes that are not done with this cycle."""
        self._hung: dict[str, int] = {}
        """Processes that stand still, and the last cycle that each was sent."""
        self._late: dict[str, int] = {}
        self._most_behind = self._late_cycles = 0
        self._spread_ns = self._done_ns = 0
        self._trips_ns: deque[int] = deque(maxlen=TRIPS)

    @abstractmethod
    def send(self, message: Any) -> None:
        """Handle a message of the master, as part of the event that the master is handling."""

    def open(self, spokes: Spokes) -> None:
        """Reach other processes by `spokes`."""
        self._spokes = spokes

    def open_local(self, process: str, on_spread: Callable[[bytes], None]) -> None:
        """Reach the stations of this process by `on_spread`; what comes back is given to `take`."""
        self._local = process, on_spread

    def close(self) -> None:
        """Disconnect from all processes."""
        if self._spokes is not None:
            self._spokes.close()

    # ---- stations

    def announce(self, process_name: str, stations: Stations) -> None:
        """The process `process_name` has these stations, and no others."""
        if not stations:
            self.lose(process_name)
            return
        process = self._processes.setdefault(process_name, _Process(self._sequence))
        kept = {name for name, _ in stations}
        for name in process.names:
            if name not in kept:
                self._forget(name, process)
        process.names = [name for name, _ in stations]
        for name, addresses in stations:
            if name == self._at.member:
                log.warning("%s: %s is the master of the ring, and no station of %s", self._bus, name, process_name)
                continue
            former = self._owners.get(name)
            if former is None:
                self._ring.join(name)
            elif former is not process:
                former.telegrams.pop(self._ring.stations[name], None)
            self._owners[name] = process
            self._ring.answer_at(name, addresses)
        for other in self._processes.values():
            other.stations = [
                self._ring.stations[name] if self._owners.get(name) is other else None for name in other.names
            ]

    def lose(self, process_name: str) -> None:
        """The process `process_name` is gone."""
        process = self._processes.pop(process_name, None)
        self._hung.pop(process_name, None)
        self._awaited.pop(process_name, None)
        if process is not None:
            for name in process.names:
                self._forget(name, process)

    def _forget(self, name: str, process: _Process) -> None:
        if self._owners.get(name) is process:  # it may have come back in another one
            del self._owners[name]
            process.telegrams.pop(self._ring.stations[name], None)
            self._ring.leave(name)

    def take(self, process_name: str, data: bytes) -> None:
        """Handle what came back from the process `process_name`."""
        process = self._processes.get(process_name)
        if process is None:
            return
        try:
            process.done, instant_ns, telegrams = decode_back(data)
        except ValueError as fault:
            log.debug("%s: %s: %s", self._bus, process_name, fault)
            return
        if instant_ns > self._done_ns:
            self._done_ns = instant_ns
        if process.done == self._sequence:
            self._awaited.pop(process_name, None)
            process.late_ns = None
        stations = process.stations
        for number, telegram in telegrams:
            station = stations[number] if number < len(stations) else None
            if station is not None:
                station.lay(telegram)
                if self._patience_ns:
                    process.telegrams[station] = telegram

    # ---- cycles

    def finish(self, *, is_repeating: bool) -> int:
        """Close the previous cycle, and return the number of stations whose process is late with it.

        With `is_repeating` and patience, the last telegram of such a station is repeated.
        """
        self._gather()
        late = self._count_late()
        self._late_cycles += bool(late)
        if self._patience_ns:
            self._repeat_telegrams(is_repeating)
        if not late and self._spread_ns:
            self._trips_ns.append(max(self._done_ns - self._spread_ns, 0))
        return late

    def next_sequence(self) -> int:
        """The sequence number of the cycle that is about to be spread."""
        self._sequence = (self._sequence + 1) % SEQUENCES
        self._spread_ns, self._done_ns = time.monotonic_ns(), 0
        return self._sequence

    def spread(self, message: bytes) -> None:
        """Send a cycle to all processes."""
        self._awaited = self._processes.copy()
        if self._spokes is not None:
            self._spokes.spread(message, self._hung)
        if self._local is not None and self._local[0] in self._processes:
            self.loop.call_soon(self._local[1], message)

    def _gather(self) -> None:
        if self._spokes is not None:
            for process_name, data in self._spokes.gather():
                self.take(process_name, data)

    def _count_late(self) -> int:
        """Stations whose process is not done with the previous cycle."""
        if self._hung:
            self._look_after_hung()
        late, sequence, cycle_ns = 0, self._sequence, time.monotonic_ns() - self._spread_ns
        for process_name, process in self._awaited.items():
            behind = (sequence - process.done) % SEQUENCES
            self._most_behind = max(self._most_behind, behind)
            self._at.note_late(behind * cycle_ns)
            for name in process.names:
                self._late[name] = self._late.get(name, 0) + 1
            late += len(process.names)
            if process_name not in self._hung and behind >= self._most_sent:
                log.debug("%s: %s is %d cycles behind and is sent nothing", self._bus, process_name, behind)
                self._hung[process_name] = sequence
        return late

    def _repeat_telegrams(self, is_repeating: bool) -> None:
        """Repeat the last telegram for each one that is late: its service channel goes on where it was."""
        if not is_repeating:
            for process in self._processes.values():
                process.telegrams.clear()
        now_ns = self._at.clock.now_ns()
        for process in self._awaited.values():
            if process.late_ns is None:
                process.late_ns = now_ns
            if now_ns - process.late_ns <= self._patience_ns:
                for station, telegram in process.telegrams.items():
                    station.lay(telegram)

    def _look_after_hung(self) -> None:
        """Find the processes that stood still and have now done what they were sent."""
        for process_name, sent in tuple(self._hung.items()):
            process = self._processes[process_name]
            if self._is_done(process, sent):
                log.debug("%s: %s is back", self._bus, process_name)
                del self._hung[process_name]
                self._awaited.pop(process_name, None)
                process.done, process.late_ns = self._sequence, None

    @staticmethod
    def _is_done(process: _Process, sent: int) -> bool:
        """True if it is done with everything it was sent; it may even have found what it was not woken for."""
        return (process.done - sent) % SEQUENCES < SEQUENCES // 2

    def note_faults(self) -> None:
        """Add what faults have done in this cycle to the trace."""
        for note in self._ring.take_notes(self._at.clock.now_ns()):
            self._at.heard(RING, note)

    # ---- operation

    def awaited(self) -> list[str]:
        """Processes that are not done with what they were sent."""
        self._gather()
        sequence, hung = self._sequence, self._hung
        return [
            process_name
            for process_name, process in self._awaited.items()
            if not self._is_done(process, hung.get(process_name, sequence))
        ]

    def hung_stations(self) -> list[str]:
        """The stations whose process stands still and is sent nothing."""
        return [name for process_name in self._hung for name in self._processes[process_name].names]

    def statistics(self) -> dict[str, float]:
        """Counters by name with unit.

        `late.NAME` counts for one station and `late_cycles` the cycles in which any station was late;
        `most_cycles_late` is the largest number of cycles that any process has been behind.  A trip lasts from the
        spreading of a cycle until the last process is done with it, by its own clock.
        """
        trips_us = sorted(trip_ns / 1e3 for trip_ns in self._trips_ns) or [0.0]
        trips = {f"trip_p{percent}_us": trips_us[len(trips_us) * percent // 100] for percent in (50, 99)}
        by_station = {f"late.{name}": float(count) for name, count in self._late.items()}
        general = self._ring.statistics(self._at.clock.now_ns())
        return {
            **general,
            **trips,
            "late_cycles": float(self._late_cycles),
            "most_cycles_late": float(self._most_behind),
            **by_station,
        }

    def conditions(self) -> Mapping[str, str]:
        """Return the states that are reported to a person."""
        return self._ring.conditions(self._at.clock.now_ns())

    def add_fault(self, fault: Mapping[str, Any]) -> int:
        """Inject a fault, and return its number."""
        with refusals(self._bus):
            return self._ring.add_fault(self._at.clock.now_ns(), fault)

    def begin_fault(self, number: int) -> None:
        """Begin a fault that waits for its condition, which is met now."""
        self._ring.begin_fault(self._at.clock.now_ns(), number)

    def clear_fault(self, number: int) -> None:
        """Clear an injected fault."""
        with refusals(self._bus):
            self._ring.clear_fault(number)

    def faults(self) -> Mapping[int, Mapping[str, Any]]:
        """Injected faults by number."""
        return self._ring.all_faults(self._at.clock.now_ns())
