"""Ladder diagrams: parties side by side, and below each other what they send, from the first instant to the last."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from fieldrig.text.svg import Drawing

TOP: Final = 62
RUNG: Final = 21
LEFT: Final = 150
RIGHT: Final = 110
TIME_X: Final = 66
PART: Final = 16


@dataclass(frozen=True, slots=True)
class Rung:
    time_s: float
    sender: int
    receiver: int
    """Places of the parties, from the left."""
    label: str


@dataclass(frozen=True, slots=True)
class Part:
    """The rungs of one part of the conversation."""

    name: str
    rungs: Sequence[Rung]


def ladder(parties: Sequence[str], parts: Sequence[Part], title: str, about: str, width: int = 880) -> str:
    """Return the picture.  The parties are as far from each other as the width allows."""
    drawing = Drawing(width, title, about)
    step = (width - LEFT - RIGHT) / (len(parties) - 1)
    places = [LEFT + step * place for place in range(len(parties))]
    bottom = TOP + sum(len(part.rungs) * RUNG + PART for part in parts)
    for x, name in zip(places, parties, strict=True):
        drawing.rect("device", x - 70, 18, 140, 26)
        drawing.text(x, 36, name, "small name", "middle")
        drawing.line("grid", [(x, 44), (x, bottom)])
    y = float(TOP)
    for part in parts:
        drawing.line("grid", [(12, y), (width - 12, y)])
        drawing.text(14, y + 15, part.name, "tiny name")
        for rung in part.rungs:
            y += RUNG
            _draw(drawing, rung, places, y)
        y += PART
    return drawing.render(bottom + 14)


def _draw(drawing: Drawing, rung: Rung, places: Sequence[float], y: float) -> None:
    start, end = places[rung.sender], places[rung.receiver]
    drawing.text(TIME_X, y + 8, f"{rung.time_s:.2f} s", "tiny", "end")
    drawing.line("line", [(start, y + 8), (end, y + 8)], arrow=True)
    drawing.text((start + end) / 2, y + 4, rung.label, "tiny halo", "middle")
