"""The picture of a scenario: its signals over time, what was done, and where a property did not hold."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Final

from fieldrig.clock import S
from fieldrig.text.svg import Drawing
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.scenarios.watching import Played, Track

WIDTH: Final = 960
LEFT: Final = 250
RIGHT: Final = WIDTH - 70
ROW: Final = 34
LEVEL: Final = 18
"""The height of a signal in its row."""
TICKS: Final = 5
LONGEST_NAME: Final = 34
STYLE: Final = """
    .mark { stroke: #b02a2a; stroke-width: 1.5; fill: none; }
    .act { stroke: #8a6d1d; stroke-dasharray: 3 3; fill: none; }
"""


def picture(name: str, played: Played, schedule: Sequence[Act]) -> str:
    """Return the picture as SVG."""
    drawing = Drawing(WIDTH, name, f"The signals of the scenario {name} over {played.length_ns / S:g} s.", STYLE)
    end_ns = max(played.length_ns, 1)
    rows = [(place, track) for place, track in played.tracks.items()]
    top = 26 + 16 * len(schedule)
    bottom = top + ROW * len(rows)
    for tick in range(TICKS + 1):
        x = LEFT + (RIGHT - LEFT) * tick / TICKS
        drawing.line("grid", [(x, top), (x, bottom)])
        drawing.text(x, bottom + 18, f"{end_ns / S * tick / TICKS:.3g} s", "tiny", "middle")
    for number, act in enumerate(schedule):
        x, height = _x(act.at_ns, end_ns), 20 + 16 * number
        drawing.line("act", [(x, height + 4), (x, bottom)])
        is_late = x > (LEFT + RIGHT) / 2
        drawing.text(x + (-5 if is_late else 5), height, _short(str(act), 70), "tiny", "end" if is_late else "start")
    for number, (place, track) in enumerate(rows):
        y = top + ROW * number + (ROW - LEVEL) / 2
        drawing.text(LEFT - 12, y + LEVEL - 4, _short(place, LONGEST_NAME), "small", "end")
        _signal(drawing, track, y, end_ns)
    for number, violation in enumerate(played.violations):
        x, y = _x(violation.at_ns, end_ns), bottom + 38 + 16 * number
        drawing.line("mark", [(x, top), (x, bottom)])
        drawing.text(LEFT, y, _short(f"{violation.property}: {violation.what}", 110), "small")
    return drawing.render(bottom + 34 + 16 * len(played.violations))


def _x(at_ns: int, end_ns: int) -> float:
    return LEFT + (RIGHT - LEFT) * min(at_ns, end_ns) / end_ns


def _signal(drawing: Drawing, track: Track, top: float, end_ns: int) -> None:
    """Draw levels and numbers as a stepped line between the least and the greatest value; texts are written."""
    if any(isinstance(value, str) for _, value in track):
        for at_ns, value in track:
            drawing.text(_x(at_ns, end_ns), top + LEVEL - 4, _short(str(value), 24), "tiny")
        return
    numbers = [(at_ns, float(value)) for at_ns, value in track]
    low, high = min(value for _, value in numbers), max(value for _, value in numbers)
    span = high - low
    if not span:
        low, span = (0.0, 1.0) if low in (0.0, 1.0) else (low - 0.5, 1.0)
    points = list(_steps([(_x(at_ns, end_ns), top + LEVEL * (1 - (value - low) / span)) for at_ns, value in numbers]))
    drawing.line("curve", [*points, (RIGHT, points[-1][1])])
    if not any(isinstance(value, bool) for _, value in track):
        drawing.text(RIGHT + 4, points[-1][1] + 4, f"{numbers[-1][1]:.4g}", "tiny")


def _steps(points: Sequence[tuple[float, float]]) -> Iterator[tuple[float, float]]:
    yield points[0]
    for (_, y), (x, new_y) in pairwise(points):
        yield x, y
        yield x, new_y


def _short(text: str, longest: int) -> str:
    return text if len(text) <= longest else f"{text[: longest - 1]}…"
