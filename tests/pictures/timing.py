"""Timing diagrams: lanes of bars over a time axis, such as the frames on a bus."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Final

from fieldrig.text.svg import Drawing

LEFT: Final = 130
LANE: Final = 48
LABEL: Final = 14
INSIDE: Final = -1
BAR: Final = 26
CHARACTER: Final = 6.6
"""Width of a character of a bar's label, at most."""
NAME_CHARACTER: Final = 9.6
"""Width of a character of a lane's name, at most."""
UNITS: Final = ((1_000_000_000, "s"), (1_000_000, "ms"), (1_000, "us"))


@dataclass(frozen=True, slots=True)
class Bar:
    """Something that lasts from one instant to another; `style` is a class of `svg.STYLE`."""

    start_ns: int
    end_ns: int
    label: str
    style: str = "bus"


@dataclass(frozen=True, slots=True)
class Lane:
    name: str
    bars: Sequence[Bar]
    about: str = ""
    """A second, smaller line below the name."""


def spans(samples: Sequence[tuple[int, str]], style: str = "device") -> list[Bar]:
    """A bar for each time in which successive samples (instant, label) are equal; an empty label has none."""
    bars: list[Bar] = []
    start = samples[0][0]
    for (_, before), (now, after) in pairwise(samples):
        if after != before:
            bars.append(Bar(start, now, before, style))
            start = now
    bars.append(Bar(start, samples[-1][0], samples[-1][1], style))
    return [bar for bar in bars if bar.label]


def timing(lanes: Sequence[Lane], start_ns: int, end_ns: int, title: str, about: str, width: int = 880) -> str:
    """The picture of what the lanes show between two instants; the axis counts from the first."""
    drawing = Drawing(width, title, about)
    return drawing.render(draw_timing(drawing, lanes, start_ns, end_ns))


def draw_timing(drawing: Drawing, lanes: Sequence[Lane], start_ns: int, end_ns: int, top: float = 20) -> float:
    """Draw the diagram and return where it ends."""
    left = max(LEFT, *(_width_of_names(lane) for lane in lanes))
    right = drawing.width - 30
    scale = (right - left) / (end_ns - start_ns)
    rows = [_rows_of_labels(lane, start_ns, scale) for lane in lanes]
    ends = list(accumulate((LANE + LABEL * (max(above, default=-1) + 1) for above in rows), initial=top))
    _draw_axis(drawing, end_ns - start_ns, left, right, top, ends[-1])
    for lane, above, end in zip(lanes, rows, ends[1:], strict=True):
        y = end - 6
        drawing.text(20, y - 12 if lane.about else y - 6, lane.name, "name")
        drawing.text(20, y + 3, lane.about, "tiny")
        drawing.line("line", [(left, y), (right, y)])
        for bar, row in zip(lane.bars, above, strict=True):
            x = left + (bar.start_ns - start_ns) * scale
            drawing.rect(bar.style, x, y - BAR, _length(bar, scale), BAR, radius=2)
            if row != INSIDE:
                drawing.line("grid", [(x, y - BAR), (x, y - BAR - LABEL * row - 12)])
        for bar, row in zip(lane.bars, above, strict=True):  # behind all lines, which their halos interrupt
            x = left + (bar.start_ns - start_ns) * scale
            if row == INSIDE:
                drawing.text(x + _length(bar, scale) / 2, y - 9, bar.label, "tiny", "middle")
            else:
                drawing.text(x + 2, y - BAR - LABEL * row - 4, bar.label, "tiny halo")
    return ends[-1] + 40


def _rows_of_labels(lane: Lane, start_ns: int, scale: float) -> list[int]:
    """The row above the lane for each label, so that none covers another, or INSIDE if the bar has room for it."""
    rows: list[int] = []
    ends: list[float] = []
    for bar in lane.bars:
        x = (bar.start_ns - start_ns) * scale
        if len(bar.label) * CHARACTER + 4 < _length(bar, scale):
            rows.append(INSIDE)
            continue
        row = next((row for row, end in enumerate(ends) if end <= x), len(ends))
        ends[row : row + 1] = [x + len(bar.label) * CHARACTER + 6]
        rows.append(row)
    return rows


def _width_of_names(lane: Lane) -> int:
    return 20 + round(max(len(lane.name) * NAME_CHARACTER, len(lane.about) * CHARACTER)) + 8


def _length(bar: Bar, scale: float) -> float:
    return max((bar.end_ns - bar.start_ns) * scale, 2)


def _draw_axis(drawing: Drawing, length_ns: int, left: int, right: float, top: float, bottom: float) -> None:
    unit_ns, unit = next(row for row in UNITS if row[0] <= length_ns)
    step = next(
        factor * 10**power for power in range(12) for factor in (1, 2, 5) if length_ns / (factor * 10**power) <= 12
    )
    for instant in range(0, length_ns + 1, step):
        x = left + (right - left) * instant / length_ns
        drawing.line("grid", [(x, top), (x, bottom)])
        drawing.text(x, bottom + 16, f"{instant / unit_ns:g}", "tiny", "middle")
    drawing.text(right, bottom + 32, unit, "tiny", "end")
