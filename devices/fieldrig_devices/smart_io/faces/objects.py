"""The object dictionary of a node without a PAM, as a CiA 401 module: its EDS file, and the point of each object.

Source: CiA 301 and CiA 401; the layout is ours, as the manual knows the ring only.
`python -m fieldrig_devices.smart_io.faces.objects` writes the file.

    6000h  inputs, two bytes for each of 16 modules: IN 0 to IN 7, IN 8 to IN 11; then keys 1 to 32 in four bytes
    6200h  outputs in the same way; then LEDs 1 to 32       6411h  analog output in mV
    2000h  character and blinking of the display            2001h  error word of the node
    2010h to 2017h  DC motors 1 to 8: order, two values, position, ready, error word
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from fieldrig_devices.cia402.eds_file import Table, write
from fieldrig_devices.cia402.node_objects import NodeFacts, communication, head
from fieldrig_devices.cia402.objects import I16, I32, U8, U32, Row
from fieldrig_devices.cia402.pdo_rows import pdo_rows
from fieldrig_devices.smart_io.addresses import MODULES, addresses_of
from fieldrig_devices.smart_io.settings import MOST_KEYS, MOST_MOTORS

EDS: Final = Path(__file__).with_name("smart_io.eds")
DEVICE_TYPE: Final = 0x000B_0191
"""CiA 401 with digital inputs and outputs and analog outputs."""
PRODUCT: Final = 0x0600_7004
FIRST_MOTOR: Final = 0x2010
_BYTES: Final = 2 * MODULES + MOST_KEYS // 8
_MOTOR_ROWS: Final = (
    ("order", "Order", U8, "rww"),
    ("value", "Value", I32, "rww"),
    ("second", "Second value", I32, "rww"),
    ("position", "Position in pulses", I32, "ro"),
    ("ready", "Ready", U8, "ro"),
    ("error", "Error word", U32, "ro"),
)
_FACTS: Final = NodeFacts(
    file="smart_io.eds",
    description="Smart-IO node as a CiA 401 module",
    created="11-26-2026",
    vendor="Socapel",
    product="Smart-IO",
    product_code=PRODUCT,
    received_pdos=4,
    transmitted_pdos=4,
    comments=(
        "The manual describes no objects, so the layout is fieldrig's.",
        "Bytes of modules that are not fitted show 0 and ignore writes.",
    ),
)
_RECEIVED: Final = (
    tuple(f"6200:{number:02X}" for number in range(1, 9)),
    ("6411:01", "2000:01", "2000:02"),
    tuple(f"6200:{number:02X}" for number in range(33, 37)),
    ("2010:02", "2010:01"),
)
_TRANSMITTED: Final = (
    tuple(f"6000:{number:02X}" for number in range(1, 9)),
    ("2001:01",),
    tuple(f"6000:{number:02X}" for number in range(33, 37)),
    ("2010:04", "2010:05"),
)
"""Mapped objects of the PDOs: modules 1 to 4, keyboard and the first motor; a master may map others."""


def points_by_object() -> dict[str, str]:
    """Return the points of the objects; a node without some of them leaves these out."""
    points = {"6411:01": "analog1", "2000:01": "display.character", "2000:02": "display.blink", "2001:01": "error_word"}
    for index, terminal, scanned in ((0x6000, "key", "scan"), (0x6200, "led", "out")):
        for module in range(1, MODULES + 1):
            for place, address in enumerate(addresses_of(module)):
                points[f"{index:04X}:{2 * module - 1 + place // 8:02X}.{place % 8}"] = f"{scanned}{address}"
        for place in range(MOST_KEYS):
            points[f"{index:04X}:{2 * MODULES + 1 + place // 8:02X}.{place % 8}"] = f"{terminal}{place + 1}"
    for number in range(1, MOST_MOTORS + 1):
        for subindex, (point, *_) in enumerate(_MOTOR_ROWS, 1):
            points[f"{FIRST_MOTOR + number - 1:04X}:{subindex:02X}"] = f"motor{number}.{point}"
    return points


def _profile() -> Table:
    return Table(
        [
            *(Row(0x6000, number, _byte("Inputs", "Keys", number), U8, "ro", is_mappable=True) for number in _each()),
            Row(0x6005, None, "Global interrupt enable digital", U8, "rw", 1),
            *(Row(0x6200, number, _byte("Outputs", "LEDs", number), U8, "rww", is_mappable=True) for number in _each()),
            *(Row(0x6206, number, f"Error mode of output byte {number}", U8, "rw", 255) for number in _each()),
            *(Row(0x6207, number, f"Error value of output byte {number}", U8, "rw") for number in _each()),
            Row(0x6411, 1, "Analog output, mV", I16, "rww", is_mappable=True),
            Row(0x6443, 1, "Error mode of the analog output", U8, "rw", 1),
            Row(0x6444, 1, "Error value of the analog output", I32, "rw"),
            Row(0x2000, 1, "Character of the display", U8, "rww", 0x20, is_mappable=True),
            Row(0x2000, 2, "Blinking of the display", U8, "rww", is_mappable=True),
            Row(0x2001, 1, "Error word", U32, "ro", is_mappable=True),
        ],
        {
            0x6000: "Read inputs 8-bit",
            0x6200: "Write outputs 8-bit",
            0x6206: "Error mode output 8-bit",
            0x6207: "Error value output 8-bit",
            0x6411: "Write analog output 16-bit",
            0x6443: "Analog output error mode",
            0x6444: "Analog output error value",
            0x2000: "Display",
            0x2001: "Node",
        },
        frozenset({0x6000, 0x6200, 0x6206, 0x6207, 0x6411, 0x6443, 0x6444}),
    )


def _each() -> Iterator[int]:
    yield from range(1, _BYTES + 1)


def _byte(of_modules: str, of_keyboard: str, number: int) -> str:
    if number > 2 * MODULES:
        first = 8 * (number - 2 * MODULES) - 7
        return f"{of_keyboard} {first} to {first + 7}"
    return f"{of_modules} {'8 to 11' if number % 2 == 0 else '0 to 7'} of module {(number + 1) // 2}"


def _motors() -> Table:
    indices = range(FIRST_MOTOR, FIRST_MOTOR + MOST_MOTORS)
    rows = [
        Row(index, subindex, name, kind, access, is_mappable=True)
        for index in indices
        for subindex, (_, name, kind, access) in enumerate(_MOTOR_ROWS, 1)
    ]
    return Table(rows, {index: f"DC motor {index - FIRST_MOTOR + 1}" for index in indices})


def eds_text() -> str:
    tables = (_motors(), _profile())
    return write(
        head(_FACTS), [communication(_FACTS, DEVICE_TYPE, "2.5"), pdo_rows(_RECEIVED, _TRANSMITTED, tables), *tables]
    )


if __name__ == "__main__":
    EDS.write_text(eds_text(), encoding="utf-8", newline="\n")
