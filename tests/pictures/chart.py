"""Charts: values over time, as a rig had them."""

from collections.abc import Mapping, Sequence
from typing import Final

from fieldrig.text.svg import Drawing

LEFT: Final = 70
TOP: Final = 30
HEIGHT: Final = 200
STYLES: Final = ("curve", "second", "line")
Curve = Sequence[tuple[float, float]]


def chart(curves: Mapping[str, Curve], top_value: float, x_unit: str, y_unit: str, title: str, about: str) -> str:
    """The picture of up to three curves by name, from 0 to `top_value`; points are (x, y)."""
    drawing = Drawing(880, title, about)
    longest = max(x for curve in curves.values() for x, _ in curve)
    right, bottom = drawing.width - 40, TOP + HEIGHT
    for tick in range(6):
        x, y = LEFT + (right - LEFT) * tick / 5, bottom - HEIGHT * tick / 5
        drawing.line("grid", [(x, TOP), (x, bottom)])
        drawing.line("grid", [(LEFT, y), (right, y)])
        drawing.text(x, bottom + 18, f"{longest * tick / 5:g}", "tiny", "middle")
        drawing.text(LEFT - 8, y + 4, f"{top_value * tick / 5:g}", "tiny", "end")
    drawing.text(right, bottom + 36, x_unit, "small", "end")
    drawing.text(LEFT - 8, TOP - 12, y_unit, "small", "end")
    for number, (name, curve) in enumerate(curves.items()):
        points = [(LEFT + (right - LEFT) * x / longest, bottom - HEIGHT * y / top_value) for x, y in curve]
        drawing.line(STYLES[number], points)
        drawing.line(STYLES[number], [(LEFT + 200 * number, bottom + 32), (LEFT + 24 + 200 * number, bottom + 32)])
        drawing.text(LEFT + 30 + 200 * number, bottom + 36, name, "small")
    return drawing.render(bottom + 50)
