"""SVG by hand: shapes and text with the colours of the documentation, for light and dark pages.

The same calls give the same bytes: there are no dates, no generated ids and no measured fonts.
"""

from collections.abc import Iterable
from typing import Final
from xml.sax.saxutils import escape

STYLE: Final = """
    text { fill: #1c1c1c; }
    .sheet { fill: #ffffff; }
    .frame { fill: none; stroke: #555555; stroke-width: 2; }
    .outside { fill: #f6f1e7; stroke: #a67c2e; stroke-dasharray: 5 4; }
    .bus { fill: #e3eefb; stroke: #2f6fb3; }
    .device { fill: #e9f5ea; stroke: #3a8547; }
    .wires { fill: #fbeadf; stroke: #b3541e; }
    .bad { fill: #fbdcdc; stroke: #b02a2a; }
    .line { stroke: #555555; fill: none; stroke-width: 1.5; }
    .grid { stroke: #d9d9d9; fill: none; }
    .bus-line { stroke: #2f6fb3; fill: none; stroke-width: 3; }
    .wires-line { stroke: #b3541e; fill: none; stroke-width: 3; }
    .curve { stroke: #2f6fb3; fill: none; stroke-width: 2; }
    .second { stroke: #b3541e; fill: none; stroke-width: 2; }
    .dot { fill: #555555; }
    .small { font-size: 12px; fill: #4a4a4a; }
    .tiny { font-size: 11px; fill: #4a4a4a; }
    .name { font-weight: 600; }
    .mono { font-family: ui-monospace, Consolas, monospace; font-size: 13px; }
    .prompt { font-weight: 700; fill: #2f6fb3; }
    .halo { paint-order: stroke; stroke: #ffffff; stroke-width: 4px; }
    @media (prefers-color-scheme: dark) {
      text { fill: #eceff2; }
      .sheet { fill: #14181d; }
      .frame { stroke: #b9c0c7; }
      .outside { fill: #2c2618; stroke: #d3a859; }
      .bus { fill: #16293d; stroke: #6aa8e6; }
      .device { fill: #17301b; stroke: #71c07f; }
      .wires { fill: #352216; stroke: #e58a52; }
      .bad { fill: #3d1b1b; stroke: #e87a7a; }
      .line { stroke: #b9c0c7; }
      .grid { stroke: #333a42; }
      .bus-line, .curve { stroke: #6aa8e6; }
      .wires-line, .second { stroke: #e58a52; }
      .dot { fill: #b9c0c7; }
      .small, .tiny { fill: #b4bcc4; }
      .prompt { fill: #6aa8e6; }
      .halo { stroke: #14181d; }
    }
"""
ARROW: Final = """<defs>
    <marker id="arrow" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" markerHeight="8" orient="auto">
      <path class="dot" d="M0 0L8 4L0 8z"/>
    </marker>
  </defs>"""
FONT: Final = "system-ui, 'Segoe UI', Helvetica, Arial"


class Drawing:
    """A sheet that grows downwards; lengths are pixels."""

    def __init__(self, width: int, title: str, about: str, style: str = "") -> None:
        """`about` describes the picture to readers who cannot see it; `style` has further rules of CSS."""
        self.width, self._style = width, STYLE + style
        self._head = f'  <title id="title">{escape(title)}</title>\n  <desc id="about">{escape(about)}</desc>'
        self._shapes: list[str] = []

    def rect(self, style: str, x: float, y: float, width: float, height: float, radius: int = 4) -> None:
        at = f'x="{_px(x)}" y="{_px(y)}" width="{_px(width)}" height="{_px(height)}"'
        self._shapes.append(f'<rect class="{style}" {at} rx="{radius}"/>')

    def dot(self, x: float, y: float, radius: float = 4) -> None:
        self._shapes.append(f'<circle class="dot" cx="{_px(x)}" cy="{_px(y)}" r="{_px(radius)}"/>')

    def line(self, style: str, points: Iterable[tuple[float, float]], arrow: bool = False) -> None:
        """A line through the points, with an arrow head at the last one if `arrow`."""
        path = "L".join(f"{_px(x)} {_px(y)}" for x, y in points)
        head = ' marker-end="url(#arrow)"' if arrow else ""
        self._shapes.append(f'<path class="{style}" d="M{path}"{head}/>')

    def text(self, x: float, y: float, text: str, style: str = "", anchor: str = "start") -> None:
        """`anchor` is start, middle or end; `y` is the base line."""
        classes = f' class="{style}"' if style else ""
        at = f'x="{_px(x)}" y="{_px(y)}"' + (' xml:space="preserve"' if "mono" in style else "")
        self._shapes.append(f'<text {at} text-anchor="{anchor}"{classes}>{escape(text)}</text>')

    def render(self, height: float) -> str:
        """The whole file, cut at this height."""
        # With a size of its own, a browser shrinks a large picture to the page, and does not enlarge a small one.
        size = f'viewBox="0 0 {self.width} {_px(height)}" width="{self.width}" height="{_px(height)}"'
        head = f"""<svg xmlns="http://www.w3.org/2000/svg" {size} role="img"
    aria-labelledby="title about" font-family="{FONT}" font-size="14">
{self._head}
  <style>{self._style}  </style>
  {ARROW}
  <rect class="sheet" width="{self.width}" height="{_px(height)}" rx="10"/>"""
        return "\n".join([head, *(f"  {shape}" for shape in self._shapes), "</svg>", ""])


def _px(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")
