"""The place of each card of a rig's picture: the one rule of the page and of `fieldrig draw --rig`.

Devices on the same bar or ring are a group; a device on neither joins the group of its closest partner.  Groups fill
the rows of a grid from the left, so a machine of 38 devices fits on one screen.  A bar is a strip over its group.  A
ring goes through its cards in their order, from the left to the right and then on in the next row.
"""

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

from fieldrig_page.graph import Graph, Shape

CABLE_WEIGHT: Final = 100
"""A cable between two devices counts as much as this number of wires."""
CARD_WIDTHS: Final = ((6, 250), (16, 190), (24, 150))
"""Least width of a card in pixels, by the largest number of devices for which it holds: small rigs have large cards."""
SMALLEST_CARD: Final = 132
FEWEST_COLUMNS: Final = 2
"""Columns on a telephone."""


@dataclass(frozen=True, slots=True)
class Cell:
    """The place of a card, from 0."""

    row: int
    column: int


@dataclass(frozen=True, slots=True)
class Strip:
    """A bar or the name of a ring, over the cards of a row from the column `first` to `last`."""

    bus: str
    row: int
    level: int
    """0 is directly above the cards."""
    first: int
    last: int
    is_again: bool
    """True for a further strip of a bus that has one already."""


@dataclass(frozen=True, slots=True)
class Layout:
    columns: int
    cards: Mapping[str, Cell]
    """The cells of the devices, in the order in which they are read."""
    strips: tuple[Strip, ...]
    levels: tuple[int, ...]
    """The number of levels of strips in each row."""


def columns_for(devices: int, width_px: int) -> int:
    """Return the number of columns for a rig with this number of devices, on a page of this width."""
    least = next((least for most, least in CARD_WIDTHS if devices <= most), SMALLEST_CARD)
    return max(FEWEST_COLUMNS, min(width_px // least, max(devices, 1)))


def layout(graph: Graph, columns: int) -> Layout:
    """Return the place of every device in a grid of this number of columns."""
    groups = groups_of(graph)
    cards = _pack(groups, columns)
    strips = tuple(_strips(graph, groups, cards))
    rows = 1 + max((cell.row for cell in cards.values()), default=-1)
    levels = [1 + max((strip.level for strip in strips if strip.row == row), default=-1) for row in range(rows)]
    return Layout(columns, cards, strips, tuple(levels))


def groups_of(graph: Graph) -> list[list[str]]:
    """Return the groups of devices in the order of the rig file, each in the order in which its cards are read."""
    homes = {name: _home(graph, name) for name in graph.devices}
    bonds = _bonds(graph)
    members: dict[str, list[str]] = defaultdict(list)
    for name in graph.devices:
        members[_group_of(name, homes, bonds)].append(name)
    return [_sorted(graph, group, homes, bonds) for group in members.values()]


def partners_of(graph: Graph, name: str) -> list[str]:
    """Return the devices that share a cable or a wire with a device, the closest first."""
    bonds = _bonds(graph)[name]
    return [other for other, _ in sorted(bonds.items(), key=lambda bond: -bond[1])]


def _home(graph: Graph, name: str) -> str | None:
    """Return the ring of a device, or else its bar with the most members; None if it has neither."""
    buses = [graph.buses[bus] for bus in graph.devices[name].buses]
    shared = [bus for bus in buses if bus.shape in (Shape.RING, Shape.BAR)]
    best = max(shared, key=lambda bus: (bus.shape is Shape.RING, len(bus.members)), default=None)
    return None if best is None else best.name


def _bonds(graph: Graph) -> Mapping[str, Counter[str]]:
    """Return how closely each device is bound to others, by cables and wires; others in the order of the file."""
    bonds: dict[str, Counter[str]] = {name: Counter() for name in graph.devices}
    pairs: Counter[tuple[str, str]] = Counter()
    for bus in graph.buses.values():
        if bus.shape is Shape.CABLE:
            pairs.update(dict.fromkeys(combinations(bus.members, 2), CABLE_WEIGHT))
    for wire in graph.wires:
        pairs.update((wire.publisher, reader) for reader in wire.readers)
    for (one, other), weight in pairs.items():
        bonds[one][other] += weight
        bonds[other][one] += weight
    places = {name: place for place, name in enumerate(graph.devices)}
    for name, found in bonds.items():
        if len(found) > 1:
            bonds[name] = Counter({other: found[other] for other in sorted(found, key=places.__getitem__)})
    return bonds


def _group_of(name: str, homes: Mapping[str, str | None], bonds: Mapping[str, Counter[str]]) -> str:
    """Return the bus or the device that the group of a device is named after.

    From partner to closest partner the way ends at a member of a bar or ring, or goes in a circle of loose devices.
    """
    way: list[str] = []
    at = name
    while homes[at] is None and at not in way:
        way.append(at)
        closest = bonds[at].most_common(1)
        if not closest:
            break
        at = closest[0][0]
    home = homes[at]
    return f"bus {home}" if home is not None else f"device {min(way[way.index(at) :])}"


def _sorted(
    graph: Graph, group: Sequence[str], homes: Mapping[str, str | None], bonds: Mapping[str, Counter[str]]
) -> list[str]:
    """Return ring and bars first, then the others so that those with the same cable are neighbours."""
    home = next((homes[name] for name in group if homes[name] is not None), None)
    shared = [name for name in group if homes[name] is not None]
    if home is not None and graph.buses[home].shape is Shape.RING:
        shared = [name for name in graph.buses[home].members if name in shared]
    elif home is not None:
        shared.sort(key=lambda name: [bus for bus in graph.devices[name].buses if graph.buses[bus].shape is Shape.BAR])
    return [*shared, *_chained([name for name in group if homes[name] is None], bonds)]


def _chained(names: list[str], bonds: Mapping[str, Counter[str]]) -> list[str]:
    """Return the names so that each follows one that it has a cable to, if it has one."""
    waiting, chain = list(names), list[str]()
    while waiting:
        last = chain[-1] if chain else None
        near = [name for name in waiting if last is not None and bonds[last][name] >= CABLE_WEIGHT]
        chain.append((near or waiting)[0])
        waiting.remove(chain[-1])
    return chain


def _pack(groups: Iterable[Sequence[str]], columns: int) -> dict[str, Cell]:
    """Place each group into the first row with room for it; one that is longer than a row begins a new one."""
    cards: dict[str, Cell] = {}
    used: list[int] = []  # the columns of each row that are taken, from the left
    for group in groups:
        row = next((row for row, taken in enumerate(used) if taken + len(group) <= columns), len(used))
        for name in group:
            if row == len(used):
                used.append(0)
            cards[name] = Cell(row, used[row])
            used[row] += 1
            row += used[row] == columns
    return dict(sorted(cards.items(), key=lambda card: (card[1].row, card[1].column)))


def _strips(graph: Graph, groups: Sequence[Sequence[str]], cards: Mapping[str, Cell]) -> list[Strip]:
    """Return the strips of each bar and ring over the cards of its group; its members elsewhere have a label.

    A ring has a single one, as its line leads on from there.
    """
    strips: list[Strip] = []
    for bus in graph.buses.values():
        if bus.shape not in (Shape.RING, Shape.BAR):
            continue
        runs = _runs(cards[name] for name in strip_members(graph, groups, bus.name))
        for row, first, last in runs[:1] if bus.shape is Shape.RING else runs:  # its line leads through the other rows
            taken = {
                strip.level for strip in strips if strip.row == row and first <= strip.last and strip.first <= last
            }
            level = next(level for level in range(len(taken) + 1) if level not in taken)
            is_again = any(strip.bus == bus.name for strip in strips)
            strips.append(Strip(bus.name, row, level, first, last, is_again))
    return strips


def strip_members(graph: Graph, groups: Sequence[Sequence[str]], bus: str) -> list[str]:
    """Return the members of a bar or ring that are in the group that has most of them."""
    members = set(graph.buses[bus].members)
    group = max(groups, key=lambda group: len(members & set(group)))
    return [name for name in group if name in members]


def _runs(cells: Iterable[Cell]) -> list[tuple[int, int, int]]:
    """Return the runs of neighbours in a row, as row, first and last column."""
    runs: list[tuple[int, int, int]] = []
    for cell in sorted(cells, key=lambda cell: (cell.row, cell.column)):
        if runs and runs[-1][0] == cell.row and runs[-1][2] == cell.column - 1:
            runs[-1] = (cell.row, runs[-1][1], cell.column)
        else:
            runs.append((cell.row, cell.column, cell.column))
    return runs
