"""The wiring of a rig file: its devices side by side, its buses as lines below them, and a dot for each link."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path
from typing import Final, Self

from fieldrig.config.entries import BusEntry, DeviceEntry
from fieldrig.config.rig_file import RigConfig, load
from fieldrig.text.svg import Drawing

LEFT: Final = 240
COLUMN: Final = 108
ROW: Final = 46
TOP: Final = 24
BOX: Final = 44
GAP: Final = 10
CHARACTER: Final = 9.4
"""Width of a character of a device's name, at most."""
SMALL_CHARACTER: Final = 6.4


@dataclass(frozen=True, slots=True)
class Part:
    """The content of a picture: devices of a rig, and the buses that they are linked to."""

    buses: Mapping[str, BusEntry]
    devices: Mapping[str, DeviceEntry]

    @classmethod
    def of(cls, config: RigConfig, devices: Iterable[str] | None = None) -> Self:
        """The whole rig, or these of its devices with their buses in the order of the file; wires come last."""
        if devices is None:
            return cls(config.buses, config.devices)
        shown = {name: config.devices[name] for name in devices}
        linked = {bus for device in shown.values() for buses in device.links.values() for bus in buses}
        buses = [name for name in config.buses if name in linked]
        buses.sort(key=lambda name: config.buses[name].kind.startswith("wires"))
        return cls({name: config.buses[name] for name in buses}, shown)

    @property
    def widths(self) -> list[int]:
        """The widths of the columns of its devices, in pixels."""
        names = {name: entry.kind.rpartition(":")[2] for name, entry in self.devices.items()}
        texts = [max(len(name) * CHARACTER, len(kind) * SMALL_CHARACTER) for name, kind in names.items()]
        return [max(COLUMN, round(text) + GAP + 10) for text in texts]

    @property
    def width(self) -> int:
        return LEFT + sum(self.widths) + 20


def wiring(file: Path, title: str, about: str) -> str:
    """The picture of a rig file."""
    part = Part.of(load(file))
    drawing = Drawing(part.width, title, about)
    return drawing.render(draw_wiring(drawing, part))


def draw_wiring(drawing: Drawing, part: Part, top: float = TOP) -> float:
    """Draw the wiring and return where it ends."""
    first = top + BOX + 40
    rows = {bus: first + ROW * number for number, bus in enumerate(part.buses)}
    right = LEFT + sum(part.widths)
    for name, y in rows.items():
        entry = part.buses[name]
        style = "wires" if entry.kind.startswith("wires") else "bus"
        drawing.line(f"{style}-line", [(LEFT - 20, y), (right, y)])
        drawing.text(20, y - 2, name, "name")
        drawing.text(20, y + 14, ", ".join([entry.kind, *addresses_of(entry)[:1]]), "tiny")
        for number, address in enumerate(addresses_of(entry)[1:]):
            drawing.text(20, y + 27 + 13 * number, address, "tiny")
    lefts = accumulate(part.widths, initial=LEFT)
    for (name, device), x, width in zip(part.devices.items(), lefts, part.widths, strict=False):
        linked = [rows[bus] for buses in device.links.values() for bus in buses if bus in rows]
        middle = x + (width - GAP) / 2
        drawing.rect("device", x, top, width - GAP, BOX)
        drawing.text(middle, top + 19, name, "name", "middle")
        drawing.text(middle, top + 35, device.kind.rpartition(":")[2], "tiny", "middle")
        spread = 12 if len(linked) > 1 else 0
        for place, y in enumerate(linked):
            at = middle + spread * (place - (len(linked) - 1) / 2)
            drawing.line("line", [(at, top + BOX), (at, y)])
            drawing.dot(at, y)
    return first + ROW * (len(rows) - 1) + 36


def addresses_of(entry: BusEntry) -> list[str]:
    """The addresses at which outside programs join the bus, if the rig file names any."""
    settings = entry.bus.settings
    found = {key: getattr(settings, key, None) for key in ("socketcand", "listen", "pty", "path")}
    texts = []
    for key, value in found.items():
        if isinstance(value, dict):  # a port for each service
            texts += [f"{service} {address}" for service, address in value.items()]
        elif value:
            texts.append(f"pty {value}" if key in ("pty", "path") else str(value))
    return texts
