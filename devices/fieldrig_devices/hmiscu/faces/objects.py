"""The object dictionary of the controller as a CiA 401 slave: its EDS file, and the point that each object shows.

Source: CiA 301 and CiA 401; objects below 6000h are ours, because the manual has no CANopen slave (digest section 13).
`python -m fieldrig_devices.hmiscu.faces.objects` writes the file.

    6000h  inputs DI0 to DI7, DI8 to DI13 with FI0 and FI1, keys      2000h to 2008h  pins of the blocks
    6200h  outputs DQ0 to DQ7, FQ0 and FQ1, lamps                     2010h           counters of the pulse output
    6401h  AI0, AI1, TI0, TI1      6411h  AQ0, AQ1
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from fieldrig_devices.cia402.eds_file import Table, write
from fieldrig_devices.cia402.node_objects import NodeFacts, communication, head
from fieldrig_devices.cia402.objects import U8, U32, Row
from fieldrig_devices.cia402.pdo_rows import pdo_rows
from fieldrig_devices.hmiscu.blocks.pins import BlockType, Side
from fieldrig_devices.hmiscu.blocks.tables import BLOCK_TYPES
from fieldrig_devices.hmiscu.names import BLOCK_NAMES

EDS: Final = Path(__file__).with_name("hmiscu.eds")
I16: Final = 0x03
I32: Final = 0x04
FIRST_BLOCK: Final = 0x2000
COUNTERS: Final = 0x2010
DEVICE_TYPE: Final = 0x000F_0191
"""CiA 401 with digital and analog inputs and outputs."""
PRODUCT: Final = 0x0053_4355

BITS: Final[Mapping[str, tuple[str, ...]]] = {
    "6000:01": tuple(f"DI{number}" for number in range(8)),
    "6000:02": (*(f"DI{number}" for number in range(8, 14)), "FI0", "FI1"),
    "6000:03": tuple(f"panel.key{number}" for number in range(1, 9)),
    "6200:01": tuple(f"DQ{number}" for number in range(8)),
    "6200:02": ("FQ0", "FQ1"),
    "6200:03": tuple(f"panel.lamp{number}" for number in range(1, 9)),
}
"""Points of the bits of an object, the lowest first."""
WORDS: Final[Mapping[str, str]] = {
    **{f"6401:{number:02d}": name for number, name in enumerate(("AI0", "AI1", "TI0", "TI1"), 1)},
    **{f"6411:{number:02d}": name for number, name in enumerate(("AQ0", "AQ1"), 1)},
    "2010:01": "PTO00.Distance",
    "2010:02": "PTO00.Position",
    "2010:03": "PTO00.State",
}

_FACTS: Final = NodeFacts(
    file="hmiscu.eds",
    description="HMISCU as a CiA 401 slave, with its pulse and PWM outputs",
    created="11-23-2026",
    vendor="Schneider Electric",
    product="HMISCU",
    product_code=PRODUCT,
    received_pdos=4,
    transmitted_pdos=4,
    comments=(
        "The manual describes no objects, so the layout is fieldrig's.",
        "Objects of channels and terminals that a controller does not have show 0 and ignore writes.",
    ),
)
_PROFILE: Final = Table(
    [
        Row(0x6000, 1, "DI0 to DI7", U8, "ro", is_mappable=True),
        Row(0x6000, 2, "DI8 to DI13, FI0, FI1", U8, "ro", is_mappable=True),
        Row(0x6000, 3, "Keys 1 to 8", U8, "ro", is_mappable=True),
        Row(0x6005, None, "Global interrupt enable digital", U8, "rw", 1),
        Row(0x6200, 1, "DQ0 to DQ7", U8, "rww", is_mappable=True),
        Row(0x6200, 2, "FQ0, FQ1", U8, "rww", is_mappable=True),
        Row(0x6200, 3, "Lamps 1 to 8", U8, "rww", is_mappable=True),
        *(Row(0x6206, number, f"Error mode of output byte {number}", U8, "rw", 255) for number in (1, 2, 3)),
        *(Row(0x6207, number, f"Error value of output byte {number}", U8, "rw") for number in (1, 2, 3)),
        *(Row(0x6401, number, f"Analog input {number}", I16, "ro", is_mappable=True) for number in range(1, 5)),
        *(Row(0x6411, number, f"Analog output {number}", I16, "rww", is_mappable=True) for number in (1, 2)),
        Row(0x6423, None, "Global interrupt enable analog", 0x01, "rw", 0),
        Row(COUNTERS, 1, "Pulses of the present move", U32, "ro", is_mappable=True),
        Row(COUNTERS, 2, "Position in pulses", I32, "ro", is_mappable=True),
        Row(COUNTERS, 3, "State of the axis", U8, "ro", is_mappable=True),
    ],
    {
        0x6000: "Read inputs 8-bit",
        0x6200: "Write outputs 8-bit",
        0x6206: "Error mode output 8-bit",
        0x6207: "Error value output 8-bit",
        0x6401: "Read analog input 16-bit",
        0x6411: "Write analog output 16-bit",
        COUNTERS: "Pulse output",
    },
    frozenset({0x6000, 0x6200, 0x6206, 0x6207, 0x6401, 0x6411}),
)
_RECEIVED: Final = (("6200:01", "6200:02", "6200:03"), ("6411:01", "6411:02"), (), ())
_TRANSMITTED: Final = (("6000:01", "6000:02", "6000:03"), ("6401:01", "6401:02", "6401:03", "6401:04"), (), ())
"""Mapped objects of the PDOs; a master maps what it needs of the blocks and counters into the others."""


def _types() -> Iterator[tuple[int, str, BlockType]]:
    """Yield the index, the name and the type of each block."""
    for number, (name, type_name) in enumerate(BLOCK_NAMES.items()):
        yield FIRST_BLOCK + number, name, BLOCK_TYPES[type_name]


def pin_objects() -> dict[str, str]:
    """Return the points of pins by their objects; a reference from block to block has no object."""
    return {
        f"{index:04X}:{number:02X}": f"{name}.{pin.name}"
        for index, name, block in _types()
        for number, pin in enumerate(block.pins, 1)
        if pin.type != "PTO_REF"
    }


def _blocks() -> Table:
    rows, names = [], {}
    for index, name, block in _types():
        names[index] = name
        for number, pin in enumerate(block.pins, 1):
            if pin.type == "PTO_REF":
                continue
            access = "rww" if pin.side is Side.INPUT else "ro"
            rows.append(Row(index, number, pin.name, U32 if pin.type == "DWORD" else U8, access, is_mappable=True))
    return Table(rows, names)


def points_by_object() -> dict[str, str]:
    """Return the points of the objects in the EDS file."""
    bits = {f"{key}.{number}": name for key, names in BITS.items() for number, name in enumerate(names)}
    return bits | dict(WORDS) | pin_objects()


def eds_text() -> str:
    blocks = _blocks()
    return write(
        head(_FACTS),
        [
            communication(_FACTS, DEVICE_TYPE, "4.2"),
            pdo_rows(_RECEIVED, _TRANSMITTED, (_PROFILE, blocks)),
            blocks,
            _PROFILE,
        ],
    )


if __name__ == "__main__":
    EDS.write_text(eds_text(), encoding="utf-8", newline="\n")
