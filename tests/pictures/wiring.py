"""The wiring of a rig file: its devices side by side, its buses as lines below them, and a dot for each link."""

from pathlib import Path
from typing import Final

from fieldrig.config import BusEntry, RigConfig, load
from fieldrig.svg import Drawing

LEFT: Final = 240
COLUMN: Final = 108
ROW: Final = 46
TOP: Final = 24
BOX: Final = 44


def wiring(file: Path, title: str, about: str) -> str:
    """The picture of a rig file."""
    config = load(file)
    drawing = Drawing(width_of(config), title, about)
    return drawing.render(draw_wiring(drawing, config))


def width_of(config: RigConfig) -> int:
    return LEFT + COLUMN * len(config.devices) + 20


def draw_wiring(drawing: Drawing, config: RigConfig, top: float = TOP) -> float:
    """Draw the wiring and return where it ends."""
    first = top + BOX + 40
    rows = {bus: first + ROW * number for number, bus in enumerate(config.buses)}
    right = LEFT + COLUMN * len(config.devices)
    for name, y in rows.items():
        entry = config.buses[name]
        style = "wires" if entry.kind.startswith("wires") else "bus"
        drawing.line(f"{style}-line", [(LEFT - 20, y), (right, y)])
        drawing.text(20, y - 2, name, "name")
        drawing.text(20, y + 14, ", ".join([entry.kind, *address_of(entry)]), "tiny")
    for number, (name, device) in enumerate(config.devices.items()):
        x = LEFT + COLUMN * number
        linked = [rows[bus] for buses in device.links.values() for bus in buses]
        drawing.rect("device", x, top, COLUMN - 10, BOX)
        drawing.text(x + (COLUMN - 10) / 2, top + 19, name, "name", "middle")
        drawing.text(x + (COLUMN - 10) / 2, top + 35, device.kind.rpartition(":")[2], "tiny", "middle")
        spread = 12 if len(linked) > 1 else 0
        for place, y in enumerate(linked):
            at = x + (COLUMN - 10) / 2 + spread * (place - (len(linked) - 1) / 2)
            drawing.line("line", [(at, top + BOX), (at, y)])
            drawing.dot(at, y)
    return first + ROW * (len(rows) - 1) + 36


def address_of(entry: BusEntry) -> list[str]:
    """The addresses at which outside programs join the bus, if the rig file names any."""
    settings = entry.bus.settings
    found = {key: getattr(settings, key, None) for key in ("socketcand", "listen", "pty", "path")}
    return [f"pty {value}" if key in ("pty", "path") else str(value) for key, value in found.items() if value]
