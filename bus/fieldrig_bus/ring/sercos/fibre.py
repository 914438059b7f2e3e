"""The SERCOS fibre, cycle by cycle: which stations hear which telegram, and whose answers come round.

Source: IEC 61491 by its public facts; manual 456, 5344-5355 (a loop; one station's failure stops it).  `topology` has
the ring; the chip of a station that hears nothing says so.  A station's AT is sent once, in the cycle after the one in
which it was left.  Two stations with the same address answer in one slot and destroy each other's AT.  Every kind of
SERCOS ring has this fibre; the kind decides when its messages arrive.
Left out: the delay of the stations, and optical power; a fibre carries or it doesn't.
"""

import logging
from collections.abc import Iterable, Sequence
from typing import Final

from fieldrig_bus.ring.faults import MASTER
from fieldrig_bus.ring.medium import Medium
from fieldrig_bus.ring.sercos.faults import MODELS, Distort, Late, RingFault
from fieldrig_bus.ring.sercos.message import Answers, Cycle, Mst
from fieldrig_bus.ring.sercos.timing import GAP_NS, answers_ns, telegram_ns
from fieldrig_bus.ring.topology import Layout, Node

log = logging.getLogger(__name__)

_MST, _MDT, _AT = "mst", "mdt", "at"
_KIND: Final = {_MST: 0, _MDT: 1, _AT: 2}  # in a key of chance

Heard = tuple[Cycle, Sequence[str]]
"""A cycle, and the stations that heard it so."""


class Station(Node):
    """One station of the ring, with the AT buffers of its interface chip."""

    __slots__ = ("at", "more")

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.at: bytes | None = None
        """The AT in its buffer."""
        self.more: dict[int, bytes] = {}
        """The ATs in the buffers of its other addresses."""

    def lay(self, telegram: bytes) -> None:
        """Put an AT into the buffer of its address."""
        if telegram and telegram[0] == self.address:
            self.at = telegram
        elif telegram and telegram[0] in self.addresses:
            self.more[telegram[0]] = telegram
        else:
            log.debug("%s has no address %s", self.name, telegram[:1].hex())

    def taken(self) -> list[bytes]:
        """Return the ATs in the buffers, and empty the buffers."""
        first, self.at = self.at, None
        ats = [] if first is None else [first]
        if self.more:
            ats += self.more.values()
            self.more.clear()
        return ats


class Fibre(Medium[Station]):
    """One fibre ring with its stations."""

    def __init__(
        self,
        order: Sequence[str],
        mbaud: int,
        bypassed: Iterable[str] = (),
        faults: Iterable[RingFault] = (),
        members: Iterable[str] = (),
    ) -> None:
        """`Topology` explains `order` and `members`."""
        super().__init__(Station, MODELS, order, bypassed, faults, members)
        self._mbaud = mbaud
        self.until_ns = 0
        """The end of the telegrams of the cycle that was begun, as far as they are known."""
        self._open: Mst | None = None
        """The cycle that has begun and not ended."""
        self._spoilt_mst: list[Distort] = []
        self._lengths: list[int] = []
        self._slots_ns = answers_ns((), mbaud)
        """Duration of MST and ATs of these lengths."""
        self.errors = self.overruns = self.late = 0

    # ---- cycles

    def begin_cycle(self, now_ns: int, mst: Mst, late: int = 0) -> Answers:
        """Begin a cycle, and return what the master hears.  `late` is the number of stations known not to be ready."""
        self.cycles += 1
        self.overruns += now_ns < self.until_ns
        layout, is_calm = self.laid_out(now_ns)
        if is_calm and not layout.doubles:
            self._spoilt_mst = []
            ats, errors = self._taken(layout), 0
        else:
            self._spoilt_mst = self._spoilt(now_ns, mst.number, _MST)
            ats, errors, held = self._taken_with_care(now_ns, mst.number, layout)
            late += held
        self._open = mst
        lengths = list(map(len, ats))
        if lengths != self._lengths:
            self._lengths, self._slots_ns = lengths, answers_ns(lengths, self._mbaud)
        self.until_ns = now_ns + self._slots_ns
        self.errors += errors
        self.late += late
        return Answers(mst.number, tuple(ats) if layout.is_closed else (), layout.is_closed, errors, late)

    def end_cycle(self, now_ns: int, mdt: bytes) -> list[Heard]:
        """End the current cycle, and return what each station hears of it.  Empty if no cycle has begun."""
        mst, layout = self._open, self._layout
        if mst is None:
            return []
        self._open = None
        if layout is None:  # the ring has changed since
            layout = self._layout = self._present_layout(now_ns)
        if mdt:
            self.until_ns = max(now_ns, self.until_ns) + GAP_NS + telegram_ns(len(mdt), self._mbaud)
        spoilt_mdt = self._spoilt(now_ns, mst.number, _MDT) if mdt and self.faults.is_any_left(now_ns) else []
        if not spoilt_mdt and not self._spoilt_mst:
            heard: list[Heard] = [(Cycle(mst.number, mst.data, mdt), layout.names)]
        else:
            heard = self._groups(Cycle(mst.number, mst.data, mdt), layout, spoilt_mdt)
        if layout.deaf:
            heard.append((Cycle(mst.number, b"", b""), layout.deaf))
        return heard

    @staticmethod
    def _taken(layout: Layout[Station]) -> list[bytes]:
        """Take the ATs that are sent after this MST out of the buffers."""
        ats: list[bytes] = []
        for station in layout.hearing:
            at = station.at
            if at is not None:
                ats.append(at)
                station.at = None
            if station.more:
                ats += station.taken()
        return ats

    def _taken_with_care(self, now_ns: int, number: int, layout: Layout[Station]) -> tuple[list[bytes], int, int]:
        """The ATs that arrive, the number of those with a wrong FCS, and the number of those that are late."""
        taken, errors, held = [], 0, 0
        for station in layout.hearing:
            left = station.taken()
            if any(self._lies_at(place, station, _MST) for place in self._spoilt_mst):
                continue
            for at in left:
                if self._is_late(now_ns, number, station):
                    held += 1
                    continue
                if at[0] in layout.doubles or self._is_at_distorted(now_ns, number, station):
                    errors += 1
                else:
                    taken.append(at)
        return taken, errors, held

    # ---- faults

    def _groups(self, cycle: Cycle, layout: Layout[Station], spoilt_mdt: Sequence[Distort]) -> list[Heard]:
        """Group the stations by the telegrams of the cycle that they hear."""
        groups: dict[tuple[bool, bool], list[str]] = {}
        for station in layout.hearing:
            lost = (
                any(self._lies_at(place, station, _MST) for place in self._spoilt_mst),
                any(self._lies_at(place, station, _MDT) for place in spoilt_mdt),
            )
            groups.setdefault(lost, []).append(station.name)
        return [
            (Cycle(cycle.number, b"" if lost[0] else cycle.mst, b"" if lost[1] else cycle.mdt), names)
            for lost, names in groups.items()
        ]

    def _spoilt(self, now_ns: int, number: int, telegram: str) -> list[Distort]:
        """The faults that distort this telegram of the master."""
        places = []
        for fault in self._on(now_ns, Distort):
            if fault.settings.telegram in (None, telegram) and fault.happens(number << 16 ^ _KIND[telegram]):
                fault.applied += 1
                places.append(fault.settings)
        return places

    def _is_at_distorted(self, now_ns: int, number: int, station: Station) -> bool:
        is_distorted = False
        for fault in self._on(now_ns, Distort):
            if fault.settings.telegram not in (None, _AT) or not self._lies_at(fault.settings, station, _AT):
                continue
            if fault.happens(number << 16 ^ station.place << 2 ^ _KIND[_AT]):
                fault.applied += 1
                is_distorted = True
        return is_distorted

    def _lies_at(self, settings: Distort, station: Station, telegram: str) -> bool:
        if settings.station is not None:
            return settings.station == station.name
        if settings.after in (MASTER, self.master):
            return telegram != _AT
        segment = self.stations.get(settings.after or "")
        if segment is None:
            return False
        return station.place <= segment.place if telegram == _AT else station.place > segment.place

    def _is_late(self, now_ns: int, number: int, station: Station) -> bool:
        for fault in self._on(now_ns, Late):
            if fault.settings.station == station.name and fault.happens(number << 16 ^ station.place):
                fault.applied += 1
                return True
        return False

    # ---- operation

    def statistics(self, now_ns: int) -> dict[str, float]:
        return {
            **super().statistics(now_ns),
            "wrong_fcs": float(self.errors),
            "late": float(self.late),
            "overruns": float(self.overruns),
        }
