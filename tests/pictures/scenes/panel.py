"""The screen of an ARP card's terminal, as it shows it while the cell runs."""

from collections.abc import Callable, Mapping
from typing import Final

from tests.pictures.recording import recorded
from tests.pictures.svg import Drawing

from fieldrig.clock import S
from fieldrig.rig import Rig

WIDTH: Final = 16
HEIGHT: Final = 22
"""Size of a cell; a terminal's own is square."""
TOP: Final = 40
LEFT: Final = 40
COLUMNS: Final = 16
LEDS: Final = ("F7", "F8", "F9", "F10", "F11", "F12")


def terminal_screen() -> str:
    """The eight lines of the TR4, and its LEDs, eight seconds after the start of the cell."""
    found: dict[str, str] = {}

    def play(rig: Rig) -> None:
        rig.set("panel", "6200:01", 1)
        rig.run_until(S)
        rig.set("line", "F33", True)
        rig.run_until(8 * S)
        found.update({key: str(rig.get("terminal", key)) for key in ("screen", *(f"led.{name}" for name in LEDS))})

    recorded("arp-cell-virtual.yaml", play)
    lines = found["screen"].split("\n")
    about = "Eight lines of sixteen characters: a title, tension, set point, number of sheets and stage of the cell."
    width = 2 * LEFT + WIDTH * COLUMNS
    drawing = Drawing(width, "Terminal of the ARP cell while the film runs", about)
    drawing.rect("outside", LEFT - 12, TOP - 12, WIDTH * COLUMNS + 24, HEIGHT * len(lines) + 24, radius=8)
    for row, line in enumerate(lines):
        for column, character in enumerate(line):
            if character != " ":
                x, y = LEFT + WIDTH * (column + 0.5), TOP + HEIGHT * (row + 0.75)
                drawing.text(x, y, character, "mono", "middle")
    bottom = TOP + HEIGHT * len(lines) + 40
    for place, name in enumerate(LEDS):
        x = LEFT + 44 * place
        drawing.rect("wires" if found[f"led.{name}"] == "True" else "device", x, bottom - 12, 14, 14, radius=7)
        drawing.text(x + 17, bottom, name, "tiny")
    return drawing.render(bottom + 30)


PICTURES: Final[Mapping[str, Callable[[], str]]] = {"arp-terminal": terminal_screen}
