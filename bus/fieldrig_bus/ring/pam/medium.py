"""The fibre of a PAM's ring, cycle by cycle: which nodes hear the frames, and whose reports come back.

Source: PAM V2.5, B.2 and B.7.  The first node behind an opening sees no carrier, and the first one behind a place that
damages frames sees a wrong CRC; each tells the PAM its address (D1 of 06..F010 and 06..F00E).  Nodes further behind
hear nothing.  A report is sent once, in the cycle after the one in which it was left.  Two nodes with the same address
are both heard, and the PAM sees that there are too many (06..F006).
Left out: the delay of the stations, and optical power; a fibre carries or it doesn't.
"""

import logging
from collections import deque
from collections.abc import Iterable, Sequence
from typing import Final

from fieldrig_bus.ring.medium import Medium
from fieldrig_bus.ring.pam.faults import MODELS, Distort, Halt, RingFault
from fieldrig_bus.ring.pam.message import LONGEST_BUFFER, Cycle, Frame, Frames, Reception, Reports
from fieldrig_bus.ring.topology import Layout, Node

log = logging.getLogger(__name__)

MOST_WAITING: Final = 64
"""Reports that wait in a node's chip; the oldest one is lost when another comes."""

Heard = tuple[Cycle, Sequence[str]]
"""A cycle, and the nodes that heard it so."""


class Station(Node):
    """One node of the ring, with the buffer of its interface chip."""

    __slots__ = ("buffer", "lost")

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.buffer: deque[bytes] = deque()
        self.lost = 0

    def lay(self, telegram: bytes) -> None:
        """Add reports to the buffer."""
        if not telegram:
            return
        if len(self.buffer) == MOST_WAITING:
            log.debug("%s: the oldest of its reports is lost", self.name)
            self.buffer.popleft()
            self.lost += 1
        self.buffer.append(telegram)

    def taken(self) -> bytes:
        """Return as much of the buffer as one cycle carries, and remove it."""
        buffer = self.buffer
        taken = buffer.popleft()
        while buffer and len(taken) + len(buffer[0]) <= LONGEST_BUFFER:
            taken += buffer.popleft()
        return taken


class PamMedium(Medium[Station]):
    """The ring of one PAM with its nodes."""

    def __init__(
        self,
        order: Sequence[str],
        bypassed: Iterable[str] = (),
        faults: Iterable[RingFault] = (),
        members: Iterable[str] = (),
    ) -> None:
        """`Topology` explains `order` and `members`."""
        super().__init__(Station, MODELS, order, bypassed, faults, members)
        self.late = self.damaged = 0
        self._lost: list[str] = []

    def go_round(self, now_ns: int, frames: Frames, late: int = 0) -> tuple[Reports, list[Heard]]:
        """Let a cycle go round.  Returns what the PAM hears and what each node hears, first those that hear the frames.

        `late` is the number of nodes known not to be ready.
        """
        self.cycles += 1
        self.late += late
        layout, is_calm = self.laid_out(now_ns)
        number, heard = frames.number, list[Heard]()
        if is_calm:
            behind, hearing, place = layout.hearing, layout.names, None
        else:
            behind, hearing, place = self._disturbed(now_ns, number, layout, heard)
        heard.insert(0, (Cycle(number, frames.frames), hearing))
        if layout.dark:
            dark = tuple(station.name for station in layout.dark)
            heard.append((Cycle(number, (), Reception.NO_CARRIER), dark))
        reports = tuple([(station.address, station.taken()) for station in behind if station.buffer])
        return self._reports(number, layout, reports, place, late), heard

    def lose(self, stations: list[str]) -> None:
        """These stations cannot hear what the PAM sends, as if they had no power."""
        if stations != self._lost:
            self._lost, self._layout = stations, None

    @staticmethod
    def _reports(
        number: int, layout: Layout[Station], reports: tuple[Frame, ...], place: int | None, late: int
    ) -> Reports:
        """Return what the PAM hears; `place` is that of a wrong CRC, or None."""
        if not layout.is_closed:
            place = 0 if layout.is_dark else layout.dark[-1].address
            return Reports(number, (), layout.addresses, Reception.NO_CARRIER, place, late)
        if place is not None:
            return Reports(number, reports, layout.addresses, Reception.CRC_ERROR, place, late)
        return Reports(number, reports, layout.addresses, Reception.GOOD, 0, late)

    # ---- faults

    def _present_layout(self, now_ns: int) -> Layout[Station]:
        return self._layout_with(now_ns, self._lost)

    def _disturbed(
        self, now_ns: int, number: int, layout: Layout[Station], heard: list[Heard]
    ) -> tuple[list[Station], tuple[str, ...], int | None]:
        """The nodes whose reports arrive, the names of those that hear the frames, and the place of a wrong CRC.

        The first node behind a place that damages frames is added to `heard`.
        """
        halted = {fault.settings.station for fault in self._on(now_ns, Halt)}
        working = [station for station in layout.hearing if station.name not in halted]
        damage = self._damage(now_ns, number)
        if damage is None:
            return working, tuple(station.name for station in working), None
        self.damaged += 1
        before = [station for station in working if station.place <= damage]
        behind = [station for station in working if station.place > damage]
        for station in before:  # what they add is damaged on its way
            station.buffer.clear()
        first = next((station for station in layout.hearing if station.place > damage), None)
        if first is not None and first.name not in halted:
            heard.append((Cycle(number, (), Reception.CRC_ERROR), (first.name,)))
        return behind, tuple(station.name for station in before), first.address if first is not None else 0

    def _damage(self, now_ns: int, number: int) -> int | None:
        """The place of the first segment that damages this cycle, as that of the station that it leaves."""
        places = []
        for fault in self._on(now_ns, Distort):
            if fault.happens(number):
                fault.applied += 1
                places.append(self._place(fault.settings.after))
        return min(places, default=None)

    def _place(self, after: str) -> int:
        station = self.stations.get(after)
        return -1 if station is None or after == self.master else station.place

    # ---- operation

    def statistics(self, now_ns: int) -> dict[str, float]:
        return {
            **super().statistics(now_ns),
            "damaged": float(self.damaged),
            "late": float(self.late),
            "lost_reports": float(sum(station.lost for station in self.stations.values())),
        }
