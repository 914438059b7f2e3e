"""A terminal session: commands with their real output."""

from collections.abc import Sequence
from typing import Final

from fieldrig.text.svg import Drawing

LINE: Final = 19
CHARACTER: Final = 7.9
LEFT: Final = 20


def terminal(lines: Sequence[str], title: str, about: str) -> str:
    """The picture of a session; a line that begins with `$ ` is a command."""
    width = max(440, int(2 * LEFT + CHARACTER * max(map(len, lines))))
    drawing = Drawing(width, title, about)
    for number, line in enumerate(lines):
        drawing.text(LEFT, 34 + LINE * number, line, "mono prompt" if line.startswith("$ ") else "mono")
    return drawing.render(34 + LINE * len(lines))
