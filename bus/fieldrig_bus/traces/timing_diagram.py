"""Timing diagrams of wires as SVG: digital wires as high and low, numbers as steps with their values at the changes.

A line begins at the first value of its wire.  Changes that are closer together than half a pixel are drawn as one
stroke from the lowest to the highest of their values, so a picture does not grow with the number of changes.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import Final

from fieldrig.clock import MS, US, S
from fieldrig.points.values import show_number
from fieldrig.text.svg import Drawing
from fieldrig_bus.traces.waves import Value, Wave

WIDTH: Final = 880
RIGHT: Final = WIDTH - 40
TOP: Final = 20
NAME: Final = 8.0
"""Width of a character of a name, at most."""
LONGEST_NAME: Final = 40
CHARACTER: Final = 6.6
"""The same for the values at the changes."""
GAP: Final = 14
"""Space above a line, for its values."""
DIGITAL: Final = 20
ANALOG: Final = 44
MOST_TICKS: Final = 10
UNITS: Final = ((S, "s"), (MS, "ms"), (US, "us"), (1, "ns"))
MOST_OF_A_COLUMN: Final = 4

Step = tuple[float, Value]
"""A place from the left, in pixels, and the value from there on."""


@dataclass(frozen=True, slots=True)
class Window:
    """The time that a diagram shows."""

    start_ns: int
    end_ns: int
    """Instant of the right end, which is later than the left one."""
    origin_ns: int = 0
    """The instant from which the axis counts."""


def timing_diagram(waves: Sequence[Wave], window: Window, title: str, about: str) -> str:
    """Return the picture of some wires, one below the other."""
    drawing = Drawing(WIDTH, title, about)
    names = _names(waves)
    left = 40 + max((NAME * len(name) for name in names), default=0.0)
    heights = [GAP + (DIGITAL if wave.is_digital else ANALOG) + 8 for wave in waves]
    bottom = TOP + sum(heights) + 4
    _draw_axis(drawing, window, left, bottom)
    y = float(TOP)
    for wave, name, height in zip(waves, names, heights, strict=True):
        y += height
        _draw_lane(drawing, name, wave, steps_in(wave, window, left), left, y - 8)
    return drawing.render(bottom + 40)


def steps_in(wave: Wave, window: Window, left: float = 0.0) -> list[Step]:
    """The changes of a wire within a window, after the value that it has at the beginning, if it has one."""
    scale = (RIGHT - left) / (window.end_ns - window.start_ns)
    steps = (
        (left + (time_ns - window.start_ns) * scale, value)
        for time_ns, value in wave.values(window.start_ns, window.end_ns)
    )
    changed = (next(equal) for _, equal in groupby(steps, key=lambda step: step[1]))
    return _thinned(changed)


def ticks(window: Window) -> list[tuple[int, str]]:
    """The instants that the axis names, with their numbers in the unit of the axis."""
    span_ns = window.end_ns - window.start_ns
    step_ns = next(
        factor * 10**power for power in range(20) for factor in (1, 2, 5) if span_ns <= MOST_TICKS * factor * 10**power
    )
    unit_ns, _ = _unit(span_ns)
    from_ns, to_ns = window.start_ns - window.origin_ns, window.end_ns - window.origin_ns
    first_ns = -(-from_ns // step_ns) * step_ns
    return [
        (window.origin_ns + tick_ns, show_number(tick_ns / unit_ns)) for tick_ns in range(first_ns, to_ns + 1, step_ns)
    ]


def _unit(span_ns: int) -> tuple[int, str]:
    return next(row for row in UNITS if row[0] <= span_ns)


def _thinned(steps: Iterable[Step]) -> list[Step]:
    kept: list[Step] = []
    for _, column in groupby(steps, key=lambda step: round(2 * step[0])):
        same = list(column)
        if len(same) > MOST_OF_A_COLUMN:
            x, values = same[0][0], [value for _, value in same]
            same = [(x, value) for value in (values[0], min(values), max(values), values[-1])]
        kept += same
    return kept


def _names(waves: Sequence[Wave]) -> list[str]:
    """The names of the lanes: with the bus where there are several, printable, and not too long."""
    has_buses = len({wave.bus for wave in waves}) > 1
    whole = [f"{wave.bus}: {wave.name}" if has_buses else wave.name for wave in waves]
    shown = ["".join(character if character.isprintable() else "?" for character in name) for name in whole]
    return [name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 1]}…" for name in shown]


def _draw_axis(drawing: Drawing, window: Window, left: float, bottom: float) -> None:
    scale = (RIGHT - left) / (window.end_ns - window.start_ns)
    for tick_ns, name in ticks(window):
        x = left + (tick_ns - window.start_ns) * scale
        drawing.line("grid", [(x, TOP), (x, bottom)])
        drawing.text(x, bottom + 16, name, "tiny", "middle")
    drawing.text(RIGHT, bottom + 32, _unit(window.end_ns - window.start_ns)[1], "tiny", "end")


def _draw_lane(drawing: Drawing, name: str, wave: Wave, steps: Sequence[Step], left: float, base: float) -> None:
    drawing.line("grid", [(left, base), (RIGHT, base)])
    if wave.is_digital:
        drawing.text(20, base - 4, name, "name")
        _draw_steps(drawing, "curve", steps, lambda value: base - DIGITAL * value)
        return
    drawing.text(20, base - 18, name, "name")
    unit = "".join(character if character.isprintable() else "?" for character in wave.unit)
    drawing.text(20, base - 4, unit, "tiny")
    values = [value for _, value in steps]
    low, high = min(values, default=0), max(values, default=0)

    def height(value: Value) -> float:
        return base - (ANALOG * (value / 2 - low / 2) / (high / 2 - low / 2) if high > low else ANALOG / 2)

    _draw_steps(drawing, "second", steps, height)
    for (x, value), (end, _) in pairwise([*steps, (float(RIGHT), 0)]):
        text = f"{value:.6g}"
        if len(text) * CHARACTER + 6 <= end - x:
            drawing.text(x + 3, height(value) - 4, text, "tiny halo")


def _draw_steps(drawing: Drawing, style: str, steps: Sequence[Step], height: Callable[[Value], float]) -> None:
    if not steps:
        return
    points = [(steps[0][0], height(steps[0][1]))]
    for x, value in steps[1:]:
        points += [(x, points[-1][1]), (x, height(value))]
    drawing.line(style, [*points, (RIGHT, points[-1][1])])
