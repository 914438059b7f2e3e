"""The fibre ring as a function of time: who hears which telegram of a cycle, and when.

Source: IEC 61491 by its public facts; manual 456, 5344-5355 (a loop; one station's failure stops it).  The master's
telegrams pass every station in the order of the ring and come back to it.  Where the ring is open, the stations behind
hear nothing (their chips say so), and those before it hear but are not heard.  A station's AT is sent once, in the
cycle after the one in which it was left.  Two stations of one address answer in one slot and destroy each other's AT.
Left out: the delay of the stations, and optical power; a fibre carries or it doesn't.
"""

import logging
from bisect import insort
from collections.abc import Iterable, Iterator, Mapping, Sequence
from random import Random
from typing import Any, Final

from fieldrig.bus import BusModel, Delivery
from fieldrig.faults import Fault, Faults
from fieldrig_bus.ring.faults import MASTER, Break, Distort, Late, Off, RingFault, fault_of
from fieldrig_bus.ring.message import Answers, Cycle, Mdt, Mst, RingMessage
from fieldrig_bus.ring.timing import GAP_NS, answers_ns, telegram_ns

log = logging.getLogger(__name__)

_MST, _MDT, _AT = "mst", "mdt", "at"
_KIND: Final = {_MST: 0, _MDT: 1, _AT: 2}  # in a key of chance


class _Station:
    __slots__ = ("addresses", "ats", "name", "place")

    def __init__(self, name: str) -> None:
        self.name = name
        self.place = 0
        self.addresses: tuple[int, ...] = ()
        self.ats: dict[int, bytes] = {}
        """What lies in its buffers, by address."""


class _Layout:
    """The ring as it stands: found anew when something changes, and in every cycle while there are faults."""

    __slots__ = ("deaf", "doubles", "hearing", "is_closed", "names")

    def __init__(self, hearing: list[_Station], deaf: list[_Station], is_closed: bool) -> None:
        self.hearing, self.is_closed = hearing, is_closed
        self.names, self.deaf = tuple(one.name for one in hearing), tuple(one.name for one in deaf)
        addresses = [address for one in hearing for address in one.addresses]
        self.doubles = {address for address in addresses if addresses.count(address) > 1}


class RingModel(BusModel[RingMessage]):
    def __init__(
        self, order: Sequence[str], mbaud: int, bypassed: Iterable[str] = (), faults: Iterable[RingFault] = ()
    ) -> None:
        """`order` names the stations; those that it doesn't name follow as they join."""
        self._order, self._mbaud = tuple(order), mbaud
        self._bypassed = frozenset(bypassed)
        self._given = tuple(faults)
        self._stations: dict[str, _Station] = {}
        self._master: str | None = None
        self._observers: list[str] = []
        self._layout: _Layout | None = None
        self._due: list[Delivery[RingMessage]] = []
        self._open: Mst | None = None
        """The cycle that has begun and not ended."""
        self._spoilt_mst: list[Distort] = []
        self._was_calm = True
        self._until_ns = 0
        self.faults: Faults[Fault[Any]] = Faults(Fault)
        self.cycles = self.errors = self.overruns = 0

    def begin(self, now_ns: int, random: Random) -> None:
        self.faults = Faults(Fault, random)
        for fault in self._given:
            self.faults.add(now_ns, fault)

    # ---- members

    def join(self, member: str) -> None:
        self._stations[member] = _Station(member)

    def leave(self, member: str) -> None:
        del self._stations[member]
        if member == self._master:
            self._master = None
        if member in self._observers:
            self._observers.remove(member)
        self._layout = None

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        """`["master"]`; `[["drive", ADDRESS], ...]`; None: hear everything, without being a station."""
        words = [] if interest is None else list(interest)
        self._stations[member].addresses = tuple(word[1] for word in words if word != MASTER)
        if MASTER in words:
            self._master = member
        if interest is None and member not in self._observers:
            self._observers.append(member)
        self._layout = None

    # ---- time

    def submit(self, now_ns: int, member: str, message: RingMessage) -> None:
        if isinstance(message, bytes):
            station = self._stations[member]
            if message and message[0] in station.addresses:
                station.ats[message[0]] = message
            else:
                log.debug("%s has no address %s", member, message[:1].hex())
        elif member != self._master:
            log.debug("%s is not the master of the ring", member)
        elif isinstance(message, Mst):
            self._end_cycle(now_ns, b"")
            self._begin_cycle(now_ns, message)
        elif isinstance(message, Mdt):
            self._end_cycle(now_ns, message.data)

    def next_ns(self) -> int | None:
        return self._due[0].time_ns if self._due else None

    def collect(self, now_ns: int) -> list[Delivery[RingMessage]]:
        due = [one for one in self._due if one.time_ns <= now_ns]
        del self._due[: len(due)]
        return due

    def _begin_cycle(self, now_ns: int, mst: Mst) -> None:
        self.cycles += 1
        self.overruns += now_ns < self._until_ns
        is_calm = not self.faults.is_any_left(now_ns)
        if not is_calm or not self._was_calm or self._layout is None:
            self._layout = self._laid_out(now_ns)
        self._was_calm, layout = is_calm, self._layout
        if is_calm and not layout.doubles:
            self._spoilt_mst = []
            ats, errors = self._taken(layout), 0
        else:
            self._spoilt_mst = self._spoilt(now_ns, mst.number, _MST)
            ats, errors = self._taken_with_care(now_ns, mst.number, layout)
        self._open = mst
        self._until_ns = now_ns + answers_ns([len(at) for at in ats], self._mbaud)
        self.errors += errors
        answers = Answers(mst.number, tuple(ats) if layout.is_closed else (), layout.is_closed, errors)
        self._tell(self._until_ns, "ring", answers, (self._master or "",))

    def _end_cycle(self, now_ns: int, mdt: bytes) -> None:
        mst, layout = self._open, self._layout
        if mst is None:
            return
        self._open = None
        if layout is None:  # it has changed since
            layout = self._layout = self._laid_out(now_ns)
        if mdt:
            self._until_ns = max(now_ns, self._until_ns) + GAP_NS + telegram_ns(len(mdt), self._mbaud)
        spoilt_mdt = self._spoilt(now_ns, mst.number, _MDT) if mdt and self.faults.is_any_left(now_ns) else []
        master = self._master or ""
        if not spoilt_mdt and not self._spoilt_mst:
            self._tell(self._until_ns, master, Cycle(mst.number, mst.data, mdt), layout.names)
        else:
            for heard, names in self._groups(Cycle(mst.number, mst.data, mdt), layout, spoilt_mdt):
                self._tell(self._until_ns, master, heard, names)
        if layout.deaf:
            self._tell(self._until_ns, master, Cycle(mst.number, b"", b""), layout.deaf)

    def _tell(self, when_ns: int, sender: str, message: RingMessage, receivers: Sequence[str]) -> None:
        delivery = Delivery(when_ns, sender, message, (*receivers, *self._observers) if self._observers else receivers)
        insort(self._due, delivery, key=lambda one: one.time_ns)

    @staticmethod
    def _taken(layout: _Layout) -> list[bytes]:
        """The ATs that are sent after this MST, out of the buffers."""
        ats = [at for one in layout.hearing for at in one.ats.values()]
        for one in layout.hearing:
            one.ats.clear()
        return ats

    def _taken_with_care(self, now_ns: int, number: int, layout: _Layout) -> tuple[list[bytes], int]:
        """And how many of them came with a wrong FCS."""
        taken, errors = [], 0
        for one in layout.hearing:
            left, one.ats = one.ats, {}
            if any(self._lies_at(place, one, _MST) for place in self._spoilt_mst):
                continue
            for address, at in left.items():
                if self._is_late(now_ns, number, one):
                    continue
                if address in layout.doubles or self._is_at_distorted(now_ns, number, one):
                    errors += 1
                else:
                    taken.append(at)
        return taken, errors

    # ---- what is broken

    def _laid_out(self, now_ns: int) -> _Layout:
        ring = self._ring()
        for place, one in enumerate(ring):
            one.place = place
        broken = {fault.settings.after for fault in self._on(now_ns, Break)}
        dead = {fault.settings.station for fault in self._on(now_ns, Off)}
        hearing: list[_Station] = []
        deaf: list[_Station] = []
        is_open = bool(broken & {MASTER, self._master})
        for one in ring:
            if one.name in dead or not one.addresses:
                is_open |= one.name not in self._bypassed
            else:
                (deaf if is_open else hearing).append(one)
            is_open |= one.name in broken
        return _Layout(hearing, deaf, not is_open)

    def _ring(self) -> list[_Station]:
        """The stations in their order; one that should be there and has not joined has no address."""
        named = [self._stations.get(name) or _Station(name) for name in self._order if name != self._master]
        others = [one for name, one in self._stations.items() if name not in self._order and one.addresses]
        return [*named, *others]

    def _on(self, now_ns: int, *kinds: type[Any]) -> Iterator[Fault[Any]]:
        return (fault for fault in self.faults.of(*kinds) if fault.is_on(now_ns))

    def _groups(
        self, cycle: Cycle, layout: _Layout, spoilt_mdt: Sequence[Distort]
    ) -> list[tuple[Cycle, Sequence[str]]]:
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

    def _is_at_distorted(self, now_ns: int, number: int, one: _Station) -> bool:
        is_struck = False
        for fault in self._on(now_ns, Distort):
            if fault.settings.telegram not in (None, _AT) or not self._lies_at(fault.settings, one, _AT):
                continue
            if fault.happens(number << 16 ^ one.place << 2 ^ _KIND[_AT]):
                fault.applied += 1
                is_struck = True
        return is_struck

    def _lies_at(self, settings: Distort, one: _Station, telegram: str) -> bool:
        if settings.station is not None:
            return settings.station == one.name
        if settings.after in (MASTER, self._master):
            return telegram != _AT
        segment = self._stations.get(settings.after or "")
        if segment is None:
            return False
        return one.place <= segment.place if telegram == _AT else one.place > segment.place

    def _is_late(self, now_ns: int, number: int, one: _Station) -> bool:
        for fault in self._on(now_ns, Late):
            if fault.settings.station == one.name and fault.happens(number << 16 ^ one.place):
                fault.applied += 1
                return True
        return False

    def add_fault(self, now_ns: int, fault: Mapping[str, Any]) -> int:
        settings = fault_of(fault)
        place = getattr(settings, "after", None) or getattr(settings, "station", None)
        if place not in {MASTER, self._master, *self._stations, *self._order}:
            there = ", ".join([MASTER, *(one.name for one in self._ring())])
            raise ValueError(f"the ring has no station {place!r}\nthere are: {there}")
        self._layout = None
        return self.faults.add(now_ns, settings).number

    def clear_fault(self, now_ns: int, number: int) -> None:
        self.faults.clear(number)
        self._layout = None

    def all_faults(self, now_ns: int) -> dict[int, dict[str, Any]]:
        return self.faults.about(now_ns)

    def statistics(self, now_ns: int) -> dict[str, float]:
        layout = self._layout or self._laid_out(now_ns)
        return {
            "cycles": float(self.cycles),
            "stations": float(len(layout.hearing) + len(layout.deaf)),
            "ring_closed": float(layout.is_closed),
            "wrong_fcs": float(self.errors),
            "overruns": float(self.overruns),
        }
