"""Large rigs, by the files that the rig file extends: an overview of the parts."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from tests.pictures.wiring import Part, addresses_of

from fieldrig.config.rig_file import load
from fieldrig.text.svg import Drawing

WIDTH: Final = 1010
BUSES: Final = 20
"""Left edge of the names of buses."""
ADDRESSES: Final = 120
"""Left edge of their addresses."""
FRAME: Final = (310, 642)
"""Left edge and width of the frames of the parts."""
WIRES: Final = 980
LINE: Final = 22
BOX: Final = (120, 40)
ABREAST: Final = 5
TOP: Final = 48
HEADING: Final = 34
GAP: Final = 22


def parts_of(file: Path, names: Mapping[str, str]) -> dict[str, Part]:
    """The parts by name.  `names` has a name for each file; a device of several files is in the last of these parts."""
    whole = load(file)
    owner = {device: name for part, name in names.items() for device in load(file.with_name(part)).devices}
    return {
        name: Part.of(whole, [device for device in whole.devices if owner.get(device) == name])
        for name in names.values()
    }


def overview(file: Path, names: Mapping[str, str], title: str, about: str) -> str:
    """The picture of the parts, each with its buses and devices, and of the wires that join them."""
    drawing = Drawing(WIDTH, title, about)
    drawing.text(BUSES, 30, "buses and where masters and tools join them", "small")
    drawing.text(FRAME[0], 30, "devices", "small")
    drawing.text(WIRES + 10, 30, "wires", "small", "end")
    top: float = TOP
    for name, part in parts_of(file, names).items():
        top = _draw_part(drawing, name, part, top) + GAP
    drawing.line("wires-line", [(WIRES, TOP), (WIRES, top - GAP)])
    return drawing.render(top)


def _draw_part(drawing: Drawing, name: str, part: Part, top: float) -> float:
    """Draw the part and return where it ends."""
    buses = [bus for bus, entry in part.buses.items() if not entry.kind.startswith("wires")]
    lines = [(bus, address) for bus in buses for address in addresses_of(part.buses[bus]) or [part.buses[bus].kind]]
    height = max(HEADING + (BOX[1] + 10) * -(-len(part.devices) // ABREAST) + 4, LINE * len(lines) + 16)
    drawing.rect("frame", FRAME[0], top, FRAME[1], height, radius=8)
    drawing.text(FRAME[0] + 12, top + 22, name, "name")
    for number, (bus, address) in enumerate(lines):
        y = top + 20 + LINE * number
        if bus not in [before for before, _ in lines[:number]]:
            drawing.text(BUSES, y, bus, "name")
        drawing.text(ADDRESSES, y, address, "small")
        drawing.line("bus-line", [(FRAME[0] - 16, y - 5), (FRAME[0], y - 5)])
    for number, (device, entry) in enumerate(part.devices.items()):
        x = FRAME[0] + 12 + (BOX[0] + 4) * (number % ABREAST)
        y = top + HEADING + (BOX[1] + 10) * (number // ABREAST)
        drawing.rect("device", x, y, *BOX)
        drawing.text(x + BOX[0] / 2, y + 17, device, "small name", "middle")
        drawing.text(x + BOX[0] / 2, y + 32, entry.kind, "tiny", "middle")
    drawing.line("wires-line", [(FRAME[0] + FRAME[1], top + height / 2), (WIRES, top + height / 2)])
    return top + height
