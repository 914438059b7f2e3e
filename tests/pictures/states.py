"""State machines: named boxes on a grid, and an arrow for each pair of states that a table of transitions joins."""

from collections.abc import Iterable, Mapping
from typing import Final

from tests.pictures.svg import Drawing

COLUMN: Final = 230
ROW: Final = 96
WIDTH: Final = 150
HEIGHT: Final = 40
MARGIN: Final = 30


def states(
    places: Mapping[str, tuple[float, float]],
    transitions: Iterable[tuple[str, str, str]],
    title: str,
    about: str,
) -> str:
    """The picture of a state machine.

    `places` gives each state its column and row, from 0; `transitions` are (from, to, label).  Several labels between
    the same two states share one arrow.
    """
    width = int(2 * MARGIN + COLUMN * max(column for column, _ in places.values()) + WIDTH)
    drawing = Drawing(width, title, about)
    labels: dict[tuple[str, str], list[str]] = {}
    for source, target, label in transitions:
        if source != target and label not in labels.setdefault((source, target), []):
            labels[source, target].append(label)
    for (source, target), texts in labels.items():
        shift = 10 if (target, source) in labels else 0
        _draw_arrow(drawing, _middle(places[source]), _middle(places[target]), ", ".join(texts), shift)
    for name, place in places.items():
        x, y = _middle(place)
        drawing.rect("device", x - WIDTH / 2, y - HEIGHT / 2, WIDTH, HEIGHT, radius=8)
        drawing.text(x, y + 5, name, "name", "middle")
    return drawing.render(2 * MARGIN + ROW * max(row for _, row in places.values()) + HEIGHT)


def _middle(place: tuple[float, float]) -> tuple[float, float]:
    return MARGIN + WIDTH / 2 + COLUMN * place[0], MARGIN + HEIGHT / 2 + ROW * place[1]


def _draw_arrow(
    drawing: Drawing, source: tuple[float, float], target: tuple[float, float], label: str, shift: float
) -> None:
    """An arrow between the edges of two boxes, `shift` to its left so that its opposite has room."""
    across, down = target[0] - source[0], target[1] - source[1]
    length = (across**2 + down**2) ** 0.5
    offset = down / length * shift, -across / length * shift
    start = _edge(source, (across, down))
    end = _edge(target, (-across, -down))
    points = [(x + offset[0], y + offset[1]) for x, y in (start, end)]
    drawing.line("line", points, arrow=True)
    x, y = ((points[0][place] + points[1][place]) / 2 for place in (0, 1))
    if abs(across) < 1:  # a vertical arrow has its label beside it
        drawing.text(
            x + (6 if shift * down >= 0 else -6), y + 4, label, "tiny halo", "start" if shift * down >= 0 else "end"
        )
    else:
        drawing.text(x, y - 5 if offset[1] <= 0 else y + 13, label, "tiny halo", "middle")


def _edge(middle: tuple[float, float], direction: tuple[float, float]) -> tuple[float, float]:
    """The point at which a ray from the middle of a box leaves it."""
    across, down = direction
    reach = min(
        WIDTH / 2 / abs(across) if across else float("inf"),
        HEIGHT / 2 / abs(down) if down else float("inf"),
    )
    return middle[0] + across * reach, middle[1] + down * reach
