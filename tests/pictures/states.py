"""State machines: named boxes on a grid, and an arrow for each pair of states that a table of transitions joins."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from fieldrig.svg import Drawing

COLUMN: Final = 230
ROW: Final = 96
WIDTH: Final = 150
HEIGHT: Final = 40
MARGIN: Final = 30
CHARACTER: Final = 9.4
"""Width of a character of a state's name, at most."""
LINE: Final = 13
BESIDE: Final = 10
"""Distance of an arrow from the middle line of its boxes, if the opposite arrow exists."""
Point = tuple[float, float]


def states(
    places: Mapping[str, Point],
    transitions: Iterable[tuple[str, str, str]],
    title: str,
    about: str,
) -> str:
    """The picture of a state machine.

    `places` gives each state its column and row, from 0; `transitions` are (from, to, label).  Several labels between
    the same two states share one arrow, one below the other.
    """
    box = max(WIDTH, CHARACTER * max(map(len, places)))
    middles = {
        name: (MARGIN + box / 2 + COLUMN * column, MARGIN + HEIGHT / 2 + ROW * row)
        for name, (column, row) in places.items()
    }
    drawing = Drawing(int(max(x for x, _ in middles.values()) + box / 2 + MARGIN), title, about)
    labels: dict[tuple[str, str], list[str]] = {}
    for source, target, label in transitions:
        if source != target and label not in labels.setdefault((source, target), []):
            labels[source, target].append(label)
    arrows = []
    for (source, target), texts in labels.items():
        shift = BESIDE if (target, source) in labels else 0
        arrows.append((_arrow(middles[source], middles[target], shift, box), texts, shift))
    for arrow, _, _ in arrows:
        drawing.line("line", arrow, arrow=True)
    for arrow, texts, shift in arrows:
        _draw_labels(drawing, arrow, texts, bool(shift))
    for name, (x, y) in middles.items():
        drawing.rect("device", x - box / 2, y - HEIGHT / 2, box, HEIGHT, radius=8)
        drawing.text(x, y + 5, name, "name", "middle")
    return drawing.render(max(y for _, y in middles.values()) + HEIGHT / 2 + MARGIN)


def _arrow(source: Point, target: Point, shift: float, box: float) -> tuple[Point, Point]:
    """An arrow between the edges of two boxes, `shift` to its left so that its opposite has room."""
    across, down = target[0] - source[0], target[1] - source[1]
    length = (across**2 + down**2) ** 0.5
    offset = down / length * shift, -across / length * shift
    return _edge(source, (across, down), offset, box), _edge(target, (-across, -down), offset, box)


def _draw_labels(drawing: Drawing, arrow: tuple[Point, Point], labels: Sequence[str], has_opposite: bool) -> None:
    """A steep arrow has its labels beside it, any other above it; opposite arrows have theirs on both sides."""
    start, end = arrow
    across, down = end[0] - start[0], end[1] - start[1]
    part = 0.42 if has_opposite else 0.5
    x, y = start[0] + across * part, start[1] + down * part
    anchor, height = "middle", LINE * len(labels)
    if abs(down) > abs(across) / 2:
        is_right = down > 0 if has_opposite else across * down >= 0
        anchor = "start" if is_right else "end"
        x, y = x + (6 if is_right else -6), y + 4 - height / 2 + LINE / 2
    else:
        y += LINE if has_opposite and across < 0 else LINE - height - 5
    for number, label in enumerate(labels):
        drawing.text(x, y + LINE * number, label, "tiny halo", anchor)


def _edge(middle: Point, direction: Point, offset: Point, box: float) -> Point:
    """The point at which a ray from beside the middle of a box, `offset` away from it, leaves the box."""
    reach = min(
        (half - sign(way) * aside) / abs(way)
        for half, way, aside in zip((box / 2, HEIGHT / 2), direction, offset, strict=True)
        if way
    )
    return middle[0] + offset[0] + direction[0] * reach, middle[1] + offset[1] + direction[1] * reach


def sign(value: float) -> int:
    return 1 if value > 0 else -1
