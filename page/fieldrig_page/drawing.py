"""The picture of a rig as SVG, for documents: the cards, bars and rings of `layout.py`, as the page shows them."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

from fieldrig.points.values import counted
from fieldrig.text.svg import Drawing
from fieldrig_page.graph import DevicePart, Graph, Shape
from fieldrig_page.layout import Cell, Layout, Strip, layout

COLUMNS: Final = 8
CARD: Final = (142, 62)
GAP: Final = 14
STRIP: Final = 22
MARGIN: Final = 20
CHARACTER: Final = 9.6
"""Width of a character of a card's name, at most."""
LABEL_CHARACTER: Final = 6.6
"""Width of a character of a label."""
SMALL_CHARACTER: Final = 8.0
"""Width of a character of a strip's name."""
FAMILIES: Final = ("can", "modbus", "serial", "ring", "pamring")
"""Families of buses that have a colour of their own, as on the page."""
COLOURS: Final = {
    "can": ("#0b6e8f", "#4cc3e6"),
    "modbus": ("#7a4fb5", "#b795f0"),
    "serial": ("#8a5a00", "#e0b04a"),
    "ring": ("#b3266b", "#f07ab0"),
    "pamring": ("#b3266b", "#f07ab0"),
    "other": ("#2d7d46", "#6fcf8d"),
}
"""The colours of families on light and on dark ground."""


def _style() -> str:
    light = "".join(f".f-{name} {{ stroke: {colour}; }} " for name, (colour, _) in COLOURS.items())
    dark = "".join(f".f-{name} {{ stroke: {colour}; }} " for name, (_, colour) in COLOURS.items())
    return (
        "    .card { fill: #ffffff; stroke: #c6ccd4; } .link { fill: none; stroke-width: 2.5; }\n"
        f"    {light}\n"
        f"    @media (prefers-color-scheme: dark) {{ .card {{ fill: #1b2129; stroke: #39424e; }} {dark}}}\n"
    )


def draw_rig(graph: Graph, columns: int = COLUMNS) -> str:
    """Return the SVG file of a rig in at most this number of columns."""
    columns = max(1, min(columns, len(graph.devices)))
    placed = layout(graph, columns)
    about = f"{counted(len(graph.devices), 'device')}: {', '.join(graph.devices)}. Buses: {', '.join(graph.buses)}."
    drawing = Drawing(round(2 * MARGIN + columns * (CARD[0] + GAP) - GAP), f"The rig {graph.rig}", about, _style())
    places = _Places(placed)
    for bus in graph.buses.values():
        if bus.shape is Shape.RING:
            for path in _ring_paths(places, bus.members):
                drawing.line(f"link {_family(bus.family)}", path)
    for strip in placed.strips:
        _draw_strip(drawing, graph, places, strip)
    for name, device in graph.devices.items():
        over = {strip.bus for strip in placed.strips if _is_over(strip, placed.cards[name])}
        _draw_card(drawing, graph, device, places.corner(placed.cards[name]), over)
    return drawing.render(places.bottom)


class _Places:
    """The pixels of the cells of a layout."""

    def __init__(self, placed: Layout) -> None:
        self.placed = placed
        self._tops: list[int] = []
        top = MARGIN
        for levels in placed.levels:
            top += STRIP * levels
            self._tops.append(top)
            top += CARD[1] + GAP
        self.bottom = top - GAP + MARGIN

    def corner(self, cell: Cell) -> tuple[int, int]:
        return MARGIN + cell.column * (CARD[0] + GAP), self._tops[cell.row]

    def card(self, name: str) -> tuple[int, int]:
        return self.corner(self.placed.cards[name])

    def floor(self, row: int) -> int:
        """The middle of the gap below a row of cards."""
        return self._tops[row] + CARD[1] + GAP // 2


def _ring_paths(places: _Places, stations: tuple[str, ...]) -> Iterator[list[tuple[float, float]]]:
    """Yield the line from each station to the next; between two rows it runs in the gap below the first of them."""
    middle = CARD[1] / 2
    for one, other in pairwise(stations):
        (x, y), (to_x, to_y) = places.card(one), places.card(other)
        x += CARD[0]
        if y == to_y and x + GAP == to_x:
            yield [(x, y + middle), (to_x, to_y + middle)]
            continue
        out, back, floor = x + GAP / 2, to_x - GAP / 2, places.floor(places.placed.cards[one].row)
        yield [
            (x, y + middle),
            (out, y + middle),
            (out, floor),
            (back, floor),
            (back, to_y + middle),
            (to_x, to_y + middle),
        ]


def _draw_strip(drawing: Drawing, graph: Graph, places: _Places, strip: Strip) -> None:
    bus = graph.buses[strip.bus]
    left, top = places.corner(Cell(strip.row, strip.first))
    right = places.corner(Cell(strip.row, strip.last))[0] + CARD[0]
    y = top - STRIP * strip.level - STRIP / 2
    text = bus.name if strip.is_again else f"{bus.name}  {bus.kind}"
    drawing.text(left, y + 4, text, "small name")
    begin = left + len(text) * SMALL_CHARACTER + 6
    if begin < right:
        drawing.line(f"link {_family(bus.family)}", [(begin, y), (right, y)])


def _draw_card(drawing: Drawing, graph: Graph, device: DevicePart, corner: tuple[int, int], over: set[str]) -> None:
    x, y = corner
    drawing.rect("card", x, y, *CARD, radius=8)
    drawing.text(x + 10, y + 19, _short(device.name, CARD[0] - 20, CHARACTER), "name")
    drawing.text(x + 10, y + 34, _short(device.kind.rpartition(":")[2], CARD[0] - 20, LABEL_CHARACTER), "tiny")
    at: float = x + 10
    for bus in (graph.buses[name] for name in device.buses if name not in over):
        width = len(bus.name) * LABEL_CHARACTER + 6
        if bus.shape in (Shape.WIRES, Shape.RING) or at + width > x + CARD[0]:
            continue
        drawing.text(at + 3, y + 51, bus.name, "tiny")
        drawing.line(f"link {_family(bus.family)}", [(at, y + 56), (at + width, y + 56)])
        at += width + 4


def _is_over(strip: Strip, cell: Cell) -> bool:
    return strip.row == cell.row and strip.first <= cell.column <= strip.last


def _family(family: str) -> str:
    return f"f-{family if family in FAMILIES else 'other'}"


def _short(text: str, width: float, character: float) -> str:
    most = int(width // character)
    return text if len(text) <= most else f"{text[: most - 1]}…"
