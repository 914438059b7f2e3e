"""The fibre of a ring, cycle by cycle: who hears which telegram, and whose answers come round.

Source: IEC 61491 by its public facts; manual 456, 5344-5355 (a loop; one station's failure stops it).  The master's
telegrams pass every station in the order of the ring and come back to it.  Where the ring is open, the stations behind
hear nothing (their chips say so), and those before it hear but are not heard.  A station's AT is sent once, in the
cycle after the one in which it was left.  Two stations of one address answer in one slot and destroy each other's AT.
Every kind of ring has this fibre; when its messages arrive is the affair of the kind.
Left out: the delay of the stations, and optical power; a fibre carries or it doesn't.
"""

import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from random import Random
from typing import Any, Final

from fieldrig.faults import Fault, Faults
from fieldrig.wording import closest
from fieldrig_bus.ring.faults import MASTER, Break, Distort, Late, Off, RingFault, fault_of, place_of
from fieldrig_bus.ring.message import Answers, Cycle, Mst
from fieldrig_bus.ring.timing import GAP_NS, answers_ns, telegram_ns

log = logging.getLogger(__name__)

_MST, _MDT, _AT = "mst", "mdt", "at"
_KIND: Final = {_MST: 0, _MDT: 1, _AT: 2}  # in a key of chance

Heard = tuple[Cycle, Sequence[str]]
"""A cycle, and the stations that heard it so."""


class Station:
    __slots__ = ("address", "addresses", "at", "more", "name", "place")

    def __init__(self, name: str) -> None:
        self.name = name
        self.place = 0
        self.addresses: tuple[int, ...] = ()
        self.address = -1
        """The first one; few have more."""
        self.at: bytes | None = None
        """What lies in its buffer."""
        self.more: dict[int, bytes] = {}
        """What lies in those of its other addresses."""

    def lay(self, at: bytes) -> None:
        """An AT into its buffer."""
        if at and at[0] == self.address:
            self.at = at
        elif at and at[0] in self.addresses:
            self.more[at[0]] = at
        else:
            log.debug("%s has no address %s", self.name, at[:1].hex())

    def taken(self) -> list[bytes]:
        """What lies in its buffers, out of them."""
        first, self.at = self.at, None
        ats = [] if first is None else [first]
        if self.more:
            ats += self.more.values()
            self.more.clear()
        return ats


class _Layout:
    """The ring as it stands: found anew when something changes, and in every cycle while there are faults."""

    __slots__ = ("deaf", "doubles", "hearing", "is_closed", "names")

    def __init__(self, hearing: list[Station], deaf: list[Station], is_closed: bool) -> None:
        self.hearing, self.is_closed = hearing, is_closed
        self.names, self.deaf = tuple(one.name for one in hearing), tuple(one.name for one in deaf)
        addresses = [address for one in hearing for address in one.addresses]
        self.doubles = {address for address in addresses if addresses.count(address) > 1}


class Fibre:
    def __init__(
        self,
        order: Sequence[str],
        mbaud: int,
        bypassed: Iterable[str] = (),
        faults: Iterable[RingFault] = (),
        members: Iterable[str] = (),
    ) -> None:
        """`order` names the stations; then follow `members`, where they are known before they join, and who joins.

        A station of `order` that is not there opens the ring; so does one of `members` that has not joined.
        """
        self._order, self._members, self._mbaud = tuple(order), tuple(members), mbaud
        self._bypassed = frozenset(bypassed)
        self._given = tuple(faults)
        self.stations: dict[str, Station] = {}
        self.master: str | None = None
        self.observers: list[str] = []
        """Who hears everything, without being a station."""
        self.until_ns = 0
        """When the telegrams of the cycle that was begun, as far as they are known, are over."""
        self._layout: _Layout | None = None
        self._open: Mst | None = None
        """The cycle that has begun and not ended."""
        self.station_count = 0
        """With or without power; of those that are there."""
        self._spoilt_mst: list[Distort] = []
        self._was_calm = True
        self._lengths: list[int] = []
        self._slots_ns = answers_ns((), mbaud)
        """How long MST and ATs of these lengths take."""
        self.faults: Faults[Fault[Any]] = Faults(Fault)
        self.cycles = self.errors = self.overruns = self.late = 0

    def begin(self, now_ns: int, random: Random) -> None:
        self.faults = Faults(Fault, random)
        for fault in self._given:
            self.faults.add(now_ns, fault)

    # ---- stations

    def join(self, name: str) -> None:
        self.stations[name] = Station(name)
        self._layout = None

    def leave(self, name: str) -> None:
        del self.stations[name]
        if name == self.master:
            self.master = None
        if name in self.observers:
            self.observers.remove(name)
        self._layout = None

    def listen(self, name: str, interest: Sequence[Any] | None) -> None:
        """`["master"]`; `[["drive", ADDRESS], ...]`; None: hear everything, without being a station."""
        words = [] if interest is None else list(interest)
        station = self.stations[name]
        station.addresses = tuple(word[1] for word in words if word != MASTER)
        station.address = station.addresses[0] if station.addresses else -1
        if MASTER in words:
            self.master = name
        if interest is None and name not in self.observers:
            self.observers.append(name)
        self._layout = None

    # ---- cycles

    def begin_cycle(self, now_ns: int, mst: Mst, late: int = 0) -> Answers:
        """What the master hears; `late` is how many stations are known not to have been ready."""
        self.cycles += 1
        self.overruns += now_ns < self.until_ns
        is_calm = not self.faults.is_any_left(now_ns)
        layout = self._layout
        if layout is None or not (is_calm and self._was_calm):
            layout = self._layout = self._laid_out(now_ns)
        self._was_calm = is_calm
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
        """Who hears what of the cycle that was begun; nothing if none was."""
        mst, layout = self._open, self._layout
        if mst is None:
            return []
        self._open = None
        if layout is None:  # it has changed since
            layout = self._layout = self._laid_out(now_ns)
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
    def _taken(layout: _Layout) -> list[bytes]:
        """The ATs that are sent after this MST, out of the buffers."""
        ats: list[bytes] = []
        for one in layout.hearing:
            at = one.at
            if at is not None:
                ats.append(at)
                one.at = None
            if one.more:
                ats += one.taken()
        return ats

    def _taken_with_care(self, now_ns: int, number: int, layout: _Layout) -> tuple[list[bytes], int, int]:
        """And how many of them came with a wrong FCS, and how many were held back."""
        taken, errors, held = [], 0, 0
        for one in layout.hearing:
            left = one.taken()
            if any(self._lies_at(place, one, _MST) for place in self._spoilt_mst):
                continue
            for at in left:
                if self._is_late(now_ns, number, one):
                    held += 1
                    continue
                if at[0] in layout.doubles or self._is_at_distorted(now_ns, number, one):
                    errors += 1
                else:
                    taken.append(at)
        return taken, errors, held

    # ---- what is broken

    def _laid_out(self, now_ns: int) -> _Layout:
        ring = self._ring()
        for place, one in enumerate(ring):
            one.place = place
        self.station_count = sum(bool(one.addresses) for one in ring)
        broken = {fault.settings.after for fault in self._on(now_ns, Break)}
        dead = {fault.settings.station for fault in self._on(now_ns, Off)}
        hearing: list[Station] = []
        deaf: list[Station] = []
        is_open = bool(broken & {MASTER, self.master})
        for one in ring:
            if one.name in dead or not one.addresses:
                is_open |= one.name not in self._bypassed
            else:
                (deaf if is_open else hearing).append(one)
            is_open |= one.name in broken
        return _Layout(hearing, deaf, not is_open)

    def _ring(self) -> list[Station]:
        """The stations in their order; one that should be there and has not joined has no address."""
        stations = self.stations
        named = [stations.get(name) or Station(name) for name in self._order if name != self.master]
        others = [
            stations.get(name) or Station(name)
            for name in dict.fromkeys((*self._members, *stations))
            if name not in self._order and name != self.master
        ]
        return [*named, *(one for one in others if one.addresses or one.name not in stations)]

    def _on(self, now_ns: int, *kinds: type[Any]) -> Iterator[Fault[Any]]:
        return (fault for fault in self.faults.of(*kinds) if fault.is_on(now_ns))

    def _groups(self, cycle: Cycle, layout: _Layout, spoilt_mdt: Sequence[Distort]) -> list[Heard]:
        """Who hears what: stations with the same telegrams of the cycle together."""
        groups: dict[tuple[bool, bool], list[str]] = {}
        for one in layout.hearing:
            lost = (
                any(self._lies_at(place, one, _MST) for place in self._spoilt_mst),
                any(self._lies_at(place, one, _MDT) for place in spoilt_mdt),
            )
            groups.setdefault(lost, []).append(one.name)
        return [
            (Cycle(cycle.number, b"" if lost[0] else cycle.mst, b"" if lost[1] else cycle.mdt), names)
            for lost, names in groups.items()
        ]

    def _spoilt(self, now_ns: int, number: int, telegram: str) -> list[Distort]:
        """Where this telegram of the master is distorted."""
        places = []
        for fault in self._on(now_ns, Distort):
            if fault.settings.telegram in (None, telegram) and fault.happens(number << 16 ^ _KIND[telegram]):
                fault.applied += 1
                places.append(fault.settings)
        return places

    def _is_at_distorted(self, now_ns: int, number: int, one: Station) -> bool:
        is_struck = False
        for fault in self._on(now_ns, Distort):
            if fault.settings.telegram not in (None, _AT) or not self._lies_at(fault.settings, one, _AT):
                continue
            if fault.happens(number << 16 ^ one.place << 2 ^ _KIND[_AT]):
                fault.applied += 1
                is_struck = True
        return is_struck

    def _lies_at(self, settings: Distort, one: Station, telegram: str) -> bool:
        if settings.station is not None:
            return settings.station == one.name
        if settings.after in (MASTER, self.master):
            return telegram != _AT
        segment = self.stations.get(settings.after or "")
        if segment is None:
            return False
        return one.place <= segment.place if telegram == _AT else one.place > segment.place

    def _is_late(self, now_ns: int, number: int, one: Station) -> bool:
        for fault in self._on(now_ns, Late):
            if fault.settings.station == one.name and fault.happens(number << 16 ^ one.place):
                fault.applied += 1
                return True
        return False

    # ---- for people

    def add_fault(self, now_ns: int, fault: Mapping[str, Any]) -> int:
        settings = fault_of(fault)
        key, place = place_of(settings)
        known = [one.name for one in self._ring()]
        if key == "after":
            known.insert(0, MASTER)
        if place not in known and (key, place) != ("after", self.master):
            raise ValueError(f"the ring has no station {place!r}\n{closest(place, known)}")
        self._layout = None
        return self.faults.add(now_ns, settings).number

    def clear_fault(self, number: int) -> None:
        self.faults.clear(number)
        self._layout = None

    def statistics(self, now_ns: int) -> dict[str, float]:
        layout = self._layout or self._laid_out(now_ns)
        return {
            "cycles": float(self.cycles),
            "stations": float(len(layout.hearing) + len(layout.deaf)),
            "ring_closed": float(layout.is_closed),
            "wrong_fcs": float(self.errors),
            "late": float(self.late),
            "overruns": float(self.overruns),
        }
