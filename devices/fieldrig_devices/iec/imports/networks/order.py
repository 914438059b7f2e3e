"""Which elements of a graphic body make up a network, and in which order networks and elements are executed.

Networks follow one another as the document says.  A body without such marks is divided into the parts that wires
connect (power rails do not connect), from top to bottom, then from left to right; an order that the author has set
comes first.
"""

from dataclasses import replace
from typing import Final

from fieldrig_devices.iec.imports.networks.graph import Item, Kind, Network, Pin, Wire

RAILS: Final = (Kind.LEFT_RAIL, Kind.RIGHT_RAIL)
MARKS: Final = (Kind.COMMENT, Kind.LABEL, Kind.TITLE)


def join_connectors(items: list[Item]) -> None:
    """Replace each wire from a continuation by the wires into its connector."""
    connectors: dict[str, list[Wire]] = {}
    for item in items:
        if item.kind is Kind.CONNECTOR:
            connectors.setdefault(item.text.casefold(), []).extend(wire for pin in item.inputs for wire in pin.wires)
    continuations = {item.id: item.text.casefold() for item in items if item.kind is Kind.CONTINUATION}
    if not continuations:
        return
    for item in items:
        for pin in _all_pins(item):
            pin.wires = _through(pin.wires, continuations, connectors)


def _all_pins(item: Item) -> list[Pin]:
    condition = item.condition.pin if item.condition else None
    return [*item.pins(), *([condition] if condition else [])]


def _through(
    wires: tuple[Wire, ...], continuations: dict[str, str], connectors: dict[str, list[Wire]]
) -> tuple[Wire, ...]:
    through: dict[Wire, None] = {}
    seen: set[str] = set()
    waiting = list(reversed(wires))
    while waiting:
        wire = waiting.pop()
        name = continuations.get(wire.source)
        if name is None or name not in connectors:
            through[wire] = None
        elif name not in seen:
            seen.add(name)
            waiting.extend(reversed(connectors[name]))
    return tuple(through)


def divide(network: Network) -> list[Network]:
    """Divide a body whose document has no networks of its own."""
    if any(item.kind is Kind.TITLE for item in network.items):
        parts = _by_titles(network.items)
    else:
        parts = _by_wires(network.items)
    return [replace(network, items=part) for part in parts]


def _by_titles(items: list[Item]) -> list[list[Item]]:
    """The V3 form: a comment, a label and a title precede the elements of a network, in the order of the document."""
    parts: list[list[Item]] = [[]]
    rails = [item for item in items if item.kind in RAILS]
    has_elements = False
    for item in items:
        if item.kind in RAILS:
            continue
        if item.kind in MARKS and has_elements:
            parts.append([])
            has_elements = False
        has_elements = has_elements or item.kind not in MARKS
        parts[-1].append(item)
    return [[*rails, *part] for part in parts if part]


def _by_wires(items: list[Item]) -> list[list[Item]]:
    rails = [item for item in items if item.kind in RAILS]
    others = [item for item in items if item.kind not in RAILS]
    group = {item.id: item.id for item in others}

    def root(name: str) -> str:
        while group[name] != name:
            group[name] = group[group[name]]
            name = group[name]
        return name

    for item in others:
        for pin in _all_pins(item):
            for wire in pin.wires:
                if wire.source in group:
                    group[root(wire.source)] = root(item.id)
    parts: dict[str, list[Item]] = {}
    for item in others:
        parts.setdefault(root(item.id), []).append(item)
    index = {id(item): number for number, item in enumerate(items)}
    ordered = sorted(parts.values(), key=lambda part: min(_key(item, index[id(item)]) for item in part))
    return [[*rails, *part] for part in ordered]


def _key(item: Item, index: int) -> tuple[float, float, float, int]:
    return (item.order or float("inf"), item.y, item.x, index)


def in_order(items: list[Item]) -> list[Item]:
    """The elements as they are executed where no wire says otherwise."""
    return [item for _, item in sorted(enumerate(items), key=lambda entry: _key(entry[1], entry[0]))]
