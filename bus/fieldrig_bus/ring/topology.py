"""The topology of a ring: its stations in order, and which of them the master's telegrams reach.

The master's telegrams pass every station in the order of the ring and come back to it.  Where the ring is open, the
stations behind hear nothing, and those before it hear but are not heard.
The contents of the telegrams depend on the kind of ring.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Generic, TypeVar

from fieldrig_bus.ring.faults import MASTER


class Node:
    """A station at its place in the ring."""

    __slots__ = ("address", "addresses", "name", "place")

    def __init__(self, name: str) -> None:
        self.name = name
        self.place = 0
        self.address = -1
        """The first of its addresses; few stations have more."""
        self.addresses: tuple[int, ...] = ()
        """The addresses at which it answers; none if it is not a station, or is not there."""


N = TypeVar("N", bound=Node)


class Layout(Generic[N]):
    """The ring as it is at one instant."""

    __slots__ = ("addresses", "dark", "deaf", "doubles", "hearing", "is_closed", "is_dark", "names")

    def __init__(self, hearing: list[N], deaf: list[N], dark: list[N], is_closed: bool, is_dark: bool) -> None:
        self.hearing, self.is_closed = hearing, is_closed
        self.dark, self.is_dark = dark, is_dark
        """Stations directly behind an opening, where no light arrives, and whether the master is at such a place."""
        self.names, self.deaf = tuple(node.name for node in hearing), tuple(node.name for node in deaf)
        self.addresses = addresses = tuple(address for node in hearing for address in node.addresses)
        """The addresses of the stations that hear, in the order of the ring."""
        self.doubles = {address for address in addresses if addresses.count(address) > 1}
        """Addresses that more than one station has."""


class Topology(Generic[N]):
    """The stations that a ring has or is expected to have."""

    def __init__(
        self, make: Callable[[str], N], order: Sequence[str], bypassed: Iterable[str], members: Iterable[str]
    ) -> None:
        """`order` names the stations; then follow `members`, where they are known before they join, and any others.

        A station of `order` that is not there opens the ring; so does one of `members` that has not joined.
        """
        self._make, self._order, self._members = make, tuple(order), tuple(members)
        self._bypassed = frozenset(bypassed)
        self.stations: dict[str, N] = {}
        self.master: str | None = None
        self.station_count = 0
        """The stations that have joined, with or without power."""

    def join(self, name: str) -> None:
        """Add a member.  It becomes a station when it has an address."""
        self.stations[name] = self._make(name)

    def leave(self, name: str) -> None:
        """Remove a member from the ring."""
        del self.stations[name]
        if name == self.master:
            self.master = None

    def ring(self) -> list[N]:
        """The stations in their order.  An expected station that has not joined has no address."""
        stations = self.stations
        named = [self._station(name) for name in self._order if name != self.master]
        others = [
            self._station(name)
            for name in dict.fromkeys((*self._members, *stations))
            if name not in self._order and name != self.master
        ]
        return [*named, *(node for node in others if node.addresses or node.name not in stations)]

    def layout(self, broken: Collection[str], off: Collection[str]) -> Layout[N]:
        """The ring with these segments cut (by the station that each one leaves) and these stations without power."""
        ring = self.ring()
        for position, node in enumerate(ring):
            node.place = position
        self.station_count = sum(bool(node.addresses) for node in ring)
        hearing: list[N] = []
        deaf: list[N] = []
        dark: list[N] = []
        is_open = is_dark = MASTER in broken or self.master in broken
        for node in ring:
            is_cut = node.name in broken
            if node.name in off or not node.addresses:
                is_cut |= node.name not in self._bypassed
            else:
                (deaf if is_open else hearing).append(node)
                if is_dark:
                    dark.append(node)
                is_dark = False
            is_open |= is_cut
            is_dark |= is_cut
        return Layout(hearing, deaf, dark, not is_open, is_dark)

    def _station(self, name: str) -> N:
        return self.stations.get(name) or self._make(name)
