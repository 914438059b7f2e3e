"""The medium of a ring of any kind: its stations, its observers, what opens it, and its other faults.

`topology` has the order of the stations.  A kind of ring adds what its telegrams do in a cycle.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from random import Random
from typing import Any, Final, Generic, TypeVar

from fieldrig.faults.faults import Fault, Faults, Timed, fault_of
from fieldrig.faults.note import FaultNote
from fieldrig.text.nearest import closest
from fieldrig_bus.ring.faults import MASTER, Break, Off, place_of
from fieldrig_bus.ring.topology import Layout, Node, Topology

N = TypeVar("N", bound=Node)
_AT_PLACE: Final = {"after": "after", "station": "at"}


class Medium(Generic[N]):
    """One ring with its stations."""

    def __init__(
        self,
        make: Callable[[str], N],
        models: Mapping[str, type[Timed]],
        order: Sequence[str],
        bypassed: Iterable[str] = (),
        faults: Iterable[Timed] = (),
        members: Iterable[str] = (),
    ) -> None:
        """`models` are the faults that it takes; `Topology` explains `order` and `members`."""
        self._topology = Topology(make, order, bypassed, members)
        self.stations: dict[str, N] = self._topology.stations
        self._models = models
        self._given = tuple(faults)
        self._unpowered: set[str] = set()
        """Stations that have joined and have lost their power."""
        self.observers: list[str] = []
        """Members that hear everything without being a station."""
        self._layout: Layout[N] | None = None
        """The present layout; determined again after a change, and in every cycle while there are faults."""
        self._was_calm = True
        self._was_closed = False
        self.faults: Faults[Fault[Any]] = Faults(Fault)
        self._noted: dict[int, int] = {}
        """How often each fault had been applied when that was last asked."""
        self.cycles = 0

    def begin(self, now_ns: int, random: Random) -> None:
        """Start the ring, with the faults that it has from the start."""
        self.faults = Faults(Fault, random)
        for fault in self._given:
            self.faults.add(now_ns, fault)

    def begin_with(self, master: str, now_ns: int, random: Random) -> None:
        """Start the ring with its master as the first member."""
        self.begin(now_ns, random)
        self.join(master)
        self.listen(master, [MASTER])

    # ---- stations

    @property
    def master(self) -> str | None:
        """The member that is the master of the ring."""
        return self._topology.master

    @property
    def station_count(self) -> int:
        """The number of stations that have joined, with or without power."""
        return self._topology.station_count

    def join(self, name: str) -> None:
        """Add a member to the ring, or one whose power is back."""
        self._unpowered.discard(name)
        self._topology.join(name)
        self._layout = None

    def leave(self, name: str) -> None:
        """Remove a member from the ring."""
        self._unpowered.discard(name)
        self._topology.leave(name)
        if name in self.observers:
            self.observers.remove(name)
        self._layout = None

    def power_lost(self, name: str) -> None:
        """Note that a member has lost its power: the ring is open at a station, unless it has an optical bypass."""
        if name == self.master:
            self.leave(name)
        else:
            self._unpowered.add(name)
            self._layout = None

    def listen(self, name: str, interest: Sequence[Any] | None) -> None:
        """An interest is `["master"]`, `[[WORD, ADDRESS], ...]`, or None to observe without being a station."""
        words = [] if interest is None else list(interest)
        if MASTER in words:
            self._topology.master = name
        self.answer_at(name, None if interest is None else [word[1] for word in words if word != MASTER])

    def answer_at(self, name: str, addresses: Sequence[int] | None) -> None:
        """Make the member a station with these addresses from now on, or an observer for None."""
        station = self.stations[name]
        station.addresses = tuple(addresses or ())
        station.address = station.addresses[0] if station.addresses else -1
        if addresses is None and name not in self.observers:
            self.observers.append(name)
        self._layout = None

    # ---- faults

    def laid_out(self, now_ns: int) -> tuple[Layout[N], bool]:
        """The layout for a cycle that begins now, and whether the ring has no fault."""
        is_calm = not self.faults.is_any_left(now_ns)
        layout = self._layout
        if layout is None or not (is_calm and self._was_calm):
            layout = self._layout = self._present_layout(now_ns)
            self._was_closed |= layout.is_closed and bool(layout.hearing)
        self._was_calm = is_calm
        return layout, is_calm

    def _present_layout(self, now_ns: int) -> Layout[N]:
        return self._layout_with(now_ns)

    def _layout_with(self, now_ns: int, lost: Iterable[str] = ()) -> Layout[N]:
        """The layout while the stations `lost` have no power, besides those with a fault."""
        broken = {fault.settings.after for fault in self._on(now_ns, Break)}
        return self._topology.layout(
            broken, {*lost, *self._unpowered, *(fault.settings.station for fault in self._on(now_ns, Off))}
        )

    def _on(self, now_ns: int, *kinds: type[Any]) -> Iterator[Fault[Any]]:
        return (fault for fault in self.faults.of(*kinds) if fault.is_on(now_ns))

    def take_notes(self, now_ns: int) -> list[FaultNote]:
        """Return what faults have done since the last call, for the trace.

        A fault that is a state, such as a cut fibre, counts once, in the first cycle that it meets.
        """
        notes = []
        for fault in self.faults:
            if not fault.applied and not fault.settings.counts_uses and fault.is_on(now_ns):
                fault.applied = 1
            uses = fault.applied - self._noted.get(fault.number, 0)
            if uses:
                self._noted[fault.number] = fault.applied
                key, place = place_of(fault.settings)
                how_many = f", {uses} telegrams" if uses > 1 else ""
                notes.append(FaultNote(fault.number, f"{fault.settings.what} {_AT_PLACE[key]} {place}{how_many}"))
        return notes

    def add_fault(self, now_ns: int, fault: Mapping[str, Any]) -> int:
        """Inject a fault, and return its number.  ValueError for an unknown fault, or an unknown station."""
        settings = fault_of(fault, self._models)
        key, place = place_of(settings)
        known = [station.name for station in self._topology.ring()]
        if key == "after":
            known.insert(0, MASTER)
        if place not in known and (key, place) != ("after", self.master):
            raise ValueError(f"the ring has no station {place!r}\n{closest(place, known)}")
        self._layout = None
        return self.faults.add(now_ns, settings).number

    def all_faults(self, now_ns: int) -> dict[int, dict[str, Any]]:
        """Injected faults by number."""
        return self.faults.about(now_ns)

    def begin_fault(self, now_ns: int, number: int) -> None:
        """Begin a fault that waits for its condition."""
        self.faults.release(now_ns, number)
        self._layout = None

    def clear_fault(self, number: int) -> None:
        """Clear a fault.  ValueError if there is none with this number."""
        self.faults.clear(number)
        self._layout = None

    def conditions(self, now_ns: int) -> dict[str, str]:
        """The ring that has opened, with the stations that the master does not reach.

        A ring whose stations still start has not been closed yet, and is no news.
        """
        layout = self._layout or self._present_layout(now_ns)
        if layout.is_closed or not self._was_closed:
            return {}
        lost = ", ".join(node.name for node in self._topology.ring() if node.name not in layout.names)
        return {"ring": f"the ring is open{f', without {lost}' if lost else ''}"}

    def statistics(self, now_ns: int) -> dict[str, float]:
        """Counters by name."""
        layout = self._layout or self._present_layout(now_ns)
        return {
            "cycles": float(self.cycles),
            "stations": float(len(layout.hearing) + len(layout.deaf)),
            "ring_closed": float(layout.is_closed),
        }
