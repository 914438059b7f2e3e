"""State machines: named boxes on a grid, and an arrow for each pair of states that a table of transitions joins."""

from collections.abc import Iterable, Mapping, Sequence
from textwrap import wrap
from typing import Final

from fieldrig.text.svg import Drawing

COLUMN: Final = 222
ROW: Final = 118
WIDTH: Final = 150
HEIGHT: Final = 40
MARGIN: Final = 30
CHARACTER: Final = 9.4
"""Width of a character of a state's name, at most."""
LINE: Final = 16
LONGEST_LINE: Final = 18
"""Characters in a line of a label."""
BESIDE: Final = 10
"""Distance of an arrow from the middle line of its boxes, if the opposite arrow exists."""
SMALL_CHARACTER: Final = 7.4
"""Width of a character of a label, at most."""
ASCENT: Final = 12
"""Distance of the base line from the top of a line of a label."""
CLEARANCE: Final = 4
PARTS_OF_ARROW: Final = (0.5, 0.45, 0.55, 0.4, 0.6, 0.35, 0.65, 0.3, 0.7, 0.25, 0.75, 0.2, 0.8)
"""Parts of an arrow beside which a label can be, in the order in which they are tried."""
Point = tuple[float, float]
Box = tuple[Point, Point]
"""The middle of a rectangle, and half of its width and height."""


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
        lines = [line for text in texts for line in wrap(text, LONGEST_LINE)]
        arrows.append((_arrow(middles[source], middles[target], shift, box), lines, shift))
    for arrow, _, _ in arrows:
        drawing.line("line", arrow, arrow=True)
    places_of_labels = _Labels(
        [arrow for arrow, _, _ in arrows], [(middle, (box / 2, HEIGHT / 2)) for middle in middles.values()]
    )
    for arrow, texts, shift in arrows:
        x, y = places_of_labels.place(arrow, texts, bool(shift))
        for number, text in enumerate(texts):
            drawing.text(x, y + LINE * (number - len(texts) / 2) + ASCENT, text, "halo", "middle")
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


class _Labels:
    """Places for labels at which they cover no arrow, no state and no other label."""

    def __init__(self, arrows: Iterable[tuple[Point, Point]], boxes: Iterable[Box]) -> None:
        self._arrows, self._taken = list(arrows), list(boxes)

    def place(self, arrow: tuple[Point, Point], labels: Sequence[str], has_opposite: bool) -> Point:
        """Return the middle of the first free place beside the arrow; its opposite keeps the other side free."""
        half = max(map(len, labels)) * SMALL_CHARACTER / 2, LINE * len(labels) / 2
        places = [
            _beside(arrow, part, side, half) for side in ((1,) if has_opposite else (1, -1)) for part in PARTS_OF_ARROW
        ]
        best = min(places, key=lambda middle: self._covered((middle, half)))  # the first of equals
        self._taken.append((best, half))
        return best

    def _covered(self, box: Box) -> int:
        crossed = sum(_crosses(arrow, box) for arrow in self._arrows)
        return crossed + sum(_overlap(box, other) for other in self._taken)


def _beside(arrow: tuple[Point, Point], part: float, side: int, half: Point) -> Point:
    """The middle of a box of these half sizes that is as near to a part of the arrow as it may be."""
    (x, y), end = arrow
    across, down = end[0] - x, end[1] - y
    length = (across**2 + down**2) ** 0.5
    away = down / length * side, -across / length * side
    reach = abs(away[0]) * half[0] + abs(away[1]) * half[1] + CLEARANCE
    return x + across * part + away[0] * reach, y + down * part + away[1] * reach


def _crosses(arrow: tuple[Point, Point], box: Box) -> bool:
    """True if the line has points inside the box (clipping by Liang and Barsky)."""
    first, last = 0.0, 1.0
    for start, end, middle, half in zip(*arrow, *box, strict=True):
        way = end - start
        low, high = middle - half - 1 - start, middle + half + 1 - start
        if way == 0:
            if low > 0 or high < 0:
                return False
            continue
        near, far = sorted((low / way, high / way))
        first, last = max(first, near), min(last, far)
    return first < last


def _overlap(one: Box, other: Box) -> bool:
    (middle, half), (another, size) = one, other
    return all(abs(middle[axis] - another[axis]) < half[axis] + size[axis] for axis in (0, 1))


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
