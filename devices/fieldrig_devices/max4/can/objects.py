"""The object dictionary of the CAN face: the objects of a node besides its axes, and the EDS file of all objects.

Source: CiA 301, CiA 402-3 (device type of several axes); 2000h to 21FFh are ours.
`python -m fieldrig_devices.max4.can.objects` writes the file.
"""

from pathlib import Path
from typing import Final

from fieldrig_devices.cia402.eds_file import OCTETS, TEXT, Table, axis_objects, pdo_objects, write
from fieldrig_devices.cia402.node_objects import MORE, NodeFacts, communication, head
from fieldrig_devices.cia402.objects import AXES, EMPTY_PDOS, I32, RECEIVED, TRANSMITTED, U8, U16, U32, Row

EDS: Final = Path(__file__).with_name("max4-axes.eds")
"""The EDS file of the axes of the controller, for a CANopen master."""
REAL64: Final = 0x11

CONTROLLER: Final = 0x2000
"""Sub-indices: 1 DiagCode, 2 DiagExtCode, 3 DiagMsg, 4 acknowledge (quit) all, 5 booted."""
MESSAGE: Final = 0x2001
"""Sub-indices: 1 number of the entry to show, 1 is the newest; 2 the entry; 3 number of entries."""
PARAMETER: Final = 0x2002
"""Sub-indices: 1 logical address, 2 path, 3 type, 4 value as a number, 5 value as a text, 6 kind of access."""
AXIS: Final = 0x2100
"""First index of the objects of the axes, one per axis."""
SERVICE: Final = 0x2180
"""First index of the service channels, one per axis."""

FIRST_PARAMETER: Final = 0x1_0001
"""Logical address that is selected first: MsgFilter, the first parameter of the controller."""
SEVERAL_AXES: Final = 0xFFFF_0192
"""Value of 1000h for a device with several CiA 402 axes."""
PRODUCT: Final = 0x0000_4D34

_FACTS: Final = NodeFacts(
    file="max4-axes.eds",
    description="MAx-4 PacController, axes as a CiA 402 device",
    created="11-21-2026",
    vendor="ELAU",
    product="MAx-4",
    product_code=PRODUCT,
    received_pdos=AXES * (len(RECEIVED) + EMPTY_PDOS),
    transmitted_pdos=AXES * (len(TRANSMITTED) + EMPTY_PDOS),
    comments=(
        "Up to eight axes of a MAx-4; the manual describes no objects, so the layout is fieldrig's.",
        "Axis n from 0 has its objects at 6000h + n x 800h and its PDOs from number n x 64 + 1 on.",
        "Axes that a node has not show 0 in 67FFh + n x 800h and stay not ready to switch on.",
    ),
)
_CONTROLLER: Final = Table(
    [
        Row(CONTROLLER, 1, "DiagCode", U16, "ro", is_mappable=True),
        Row(CONTROLLER, 2, "DiagExtCode", TEXT, "ro"),
        Row(CONTROLLER, 3, "DiagMsg", TEXT, "ro"),
        Row(CONTROLLER, 4, "Quit controller and all axes", U8, "wo", low=0, high=1),
        Row(CONTROLLER, 5, "Boot has finished", U8, "ro", is_mappable=True),
        Row(MESSAGE, 1, "Which entry, 1 is the newest", U16, "rw", 1, low=1),
        Row(MESSAGE, 2, "Entry", TEXT, "ro"),
        Row(MESSAGE, 3, "Number of entries", U16, "ro"),
        Row(PARAMETER, 1, "Logical address", U32, "rw", f"{FIRST_PARAMETER:#010x}"),
        Row(PARAMETER, 2, "Path", TEXT, "rw"),
        Row(PARAMETER, 3, "Type of value", U8, "ro"),
        Row(PARAMETER, 4, "Value as a number", REAL64, "rw", ""),
        Row(PARAMETER, 5, "Value as a text", TEXT, "rw"),
        Row(PARAMETER, 6, "Kind of access", U8, "ro"),
    ],
    {CONTROLLER: "Controller", MESSAGE: "Message logger", PARAMETER: "Parameter by its logical address"},
)


def _axis(axis: int) -> Table:
    """The manufacturer-specific objects of one axis."""
    name = f"Axis {axis + 1}"
    state, service = AXIS + axis, SERVICE + axis
    return Table(
        [
            Row(state, 1, "DiagCode", U16, "ro", is_mappable=True),
            Row(state, 2, "DiagMsg", TEXT, "ro"),
            Row(state, 3, "Quit", U8, "wo", low=0, high=1),
            Row(state, 4, "AxisState", U8, "ro", is_mappable=True),
            Row(state, 5, "MC4State", U8, "ro", is_mappable=True),
            Row(state, 6, "Symbolic name", TEXT, "ro"),
            Row(state, 7, "Logical address", U32, "ro"),
            Row(state, 8, "RealTimeBusAdr", U8, "ro"),
            Row(service, 1, "IDN", U16, "rw"),
            Row(service, 2, "Element", U8, "rw", 7, low=1, high=7),
            Row(service, 3, "Order: 1 read, 2 write", U8, "wo", low=0, high=2),
            Row(service, 4, "State: 0 idle, 1 under way, 2 done, 3 refused", U8, "ro", is_mappable=True),
            Row(service, 5, "Service channel error", U16, "ro"),
            Row(service, 6, "Data", OCTETS, "rw"),
            Row(service, 7, "Data as a number", I32, "rw"),
        ],
        {state: f"{name}: MC-4", service: f"{name}: service channel"},
    )


def eds_text() -> str:
    axes = [table(axis) for axis in range(AXES) for table in (axis_objects, pdo_objects, _axis)]
    communication_objects = communication(_FACTS, SEVERAL_AXES, "V00.15.00", MORE)
    return write(head(_FACTS), [communication_objects, _CONTROLLER, *axes])


if __name__ == "__main__":
    EDS.write_text(eds_text(), encoding="utf-8", newline="\n")
