"""The picture of a scenario: its signals over time, what was done, and where a property did not hold."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Final, NamedTuple

from fieldrig.clock import MS, S
from fieldrig.text.svg import Drawing
from fieldrig.virtual.readings import seconds
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.scenarios.property import Property, Violation
from fieldrig_devices.scenarios.watching import Played, Track

WIDTH: Final = 960
LEFT: Final = 250
RIGHT: Final = WIDTH - 70
ROW: Final = 34
LEVEL: Final = 18
"""The height of a signal in its row."""
TICKS: Final = 5
LONGEST_NAME: Final = 34
CHARACTER: Final = 6.2
"""The width of a small character."""
BEFORE_NS: Final = 100 * MS
"""The shortest time in front of a violation in its picture."""
STYLE: Final = """
    .mark { stroke: #b02a2a; stroke-width: 1.5; fill: none; }
    .act { stroke: #8a6d1d; stroke-dasharray: 3 3; fill: none; }
"""


class Window(NamedTuple):
    """The part of the time that a picture shows, in nanoseconds from the begin of the scenario."""

    begin_ns: int
    end_ns: int

    def x(self, at_ns: int) -> float:
        inside_ns = min(max(at_ns, self.begin_ns), self.end_ns) - self.begin_ns
        return LEFT + (RIGHT - LEFT) * inside_ns / max(self.end_ns - self.begin_ns, 1)


def picture(name: str, played: Played, schedule: Sequence[Act]) -> str:
    """Return the picture of the whole scenario as SVG."""
    return _drawn(name, Window(0, played.length_ns), list(played.tracks.items()), schedule, played.violations)


def picture_of(played: Played, rule: Property, violation: Violation) -> str:
    """Return the picture of what a property read around the instant at which it did not hold."""
    around_ns = max(BEFORE_NS, (rule.within_ns or 0) * 3 // 2)
    window = Window(max(violation.at_ns - around_ns, 0), violation.at_ns + around_ns // 4)
    acts = [act for act in played.done if window.begin_ns <= act.at_ns <= window.end_ns]
    names = dict.fromkeys([*rule.places, *(act.where for act in acts if act.where in played.tracks)])
    tracks = [(name, _inside(played.tracks[name], window)) for name in names if name in played.tracks]
    return _drawn(rule.name, window, tracks, acts, [violation])


def _drawn(
    name: str,
    window: Window,
    rows: Sequence[tuple[str, Track]],
    acts: Sequence[Act],
    violations: Sequence[Violation],
) -> str:
    length_s = (window.end_ns - window.begin_ns) / S
    drawing = Drawing(WIDTH, name, f"The signals of the scenario {name} over {length_s:g} s.", STYLE)
    top = 26 + 16 * len(acts)
    bottom = top + ROW * len(rows)
    for tick in range(TICKS + 1):
        at_ns = window.begin_ns + (window.end_ns - window.begin_ns) * tick // TICKS
        drawing.line("grid", [(window.x(at_ns), top), (window.x(at_ns), bottom)])
        drawing.text(window.x(at_ns), bottom + 18, _instant(at_ns, length_s), "tiny", "middle")
    for number, act in enumerate(acts):
        x, height = window.x(act.at_ns), 20 + 16 * number
        drawing.line("act", [(x, height + 4), (x, bottom)])
        is_late = x > (LEFT + RIGHT) / 2
        drawing.text(x + (-5 if is_late else 5), height, _short(str(act), 70), "tiny", "end" if is_late else "start")
    for number, (place, track) in enumerate(rows):
        y = top + ROW * number + (ROW - LEVEL) / 2
        drawing.text(LEFT - 12, y + LEVEL - 4, _short(place, LONGEST_NAME), "small", "end")
        _signal(drawing, track, y, window)
    for number, violation in enumerate(violations):
        x, y = window.x(violation.at_ns), bottom + 38 + 16 * number
        drawing.line("mark", [(x, top), (x, bottom)])
        drawing.text(
            LEFT, y, _short(f"{seconds(violation.at_ns)}: {violation.property}: {violation.what}", 110), "small"
        )
    return drawing.render(bottom + 34 + 16 * len(violations))


def _inside(track: Track, window: Window) -> Track:
    """Return the changes inside of a window, and the last one before it."""
    before = [one for one in track if one[0] < window.begin_ns][-1:]
    inside = [one for one in track if window.begin_ns <= one[0] <= window.end_ns]
    return [(window.begin_ns, value) for _, value in before] + inside or [(window.begin_ns, track[0][1])]


def _instant(at_ns: int, length_s: float) -> str:
    """Return an instant with as many digits as tell two ticks apart."""
    digits = 3 if length_s < TICKS / 10 else 2 if length_s < TICKS else 1
    return f"{at_ns / S:.{digits}f} s"


def _signal(drawing: Drawing, track: Track, top: float, window: Window) -> None:
    """Draw levels and numbers as a stepped line between the least and the greatest value; texts are written."""
    if any(isinstance(value, str) for _, value in track):
        _texts(drawing, track, top, window)
        return
    numbers = [(at_ns, float(value)) for at_ns, value in track]
    low, high = min(value for _, value in numbers), max(value for _, value in numbers)
    span = high - low
    if not span:
        low, span = (0.0, 1.0) if low in (0.0, 1.0) else (low - 0.5, 1.0)
    points = list(_steps([(window.x(at_ns), top + LEVEL * (1 - (value - low) / span)) for at_ns, value in numbers]))
    drawing.line("curve", [*points, (RIGHT, points[-1][1])])
    if not any(isinstance(value, bool) for _, value in track):
        drawing.text(RIGHT + 4, points[-1][1] + 4, f"{numbers[-1][1]:.4g}", "tiny")


def _texts(drawing: Drawing, track: Track, top: float, window: Window) -> None:
    """Write texts where they begin; one that the next one leaves no room is cut, and a change has a stroke."""
    ends = [*(window.x(at_ns) for at_ns, _ in track[1:]), RIGHT + 60.0]
    for (at_ns, value), end in zip(track, ends, strict=True):
        x = window.x(at_ns)
        drawing.line("curve", [(x, top), (x, top + LEVEL)])
        room = int((end - x - 8) / CHARACTER)
        if room > 1:
            drawing.text(x + 4, top + LEVEL - 4, _short(str(value), room), "tiny")


def _steps(points: Sequence[tuple[float, float]]) -> Iterator[tuple[float, float]]:
    yield points[0]
    for (_, y), (x, new_y) in pairwise(points):
        yield x, y
        yield x, new_y


def _short(text: str, longest: int) -> str:
    return text if len(text) <= longest else f"{text[: longest - 1]}…"
