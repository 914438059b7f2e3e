"""The object dictionary of a drive without an EDS of its maker: every object that the engine knows.

Source: CiA 301 and CiA 402-2.  `python -m fieldrig_devices.cia402.single.own_objects` writes the file.
"""

from dataclasses import replace
from pathlib import Path
from typing import Final

from fieldrig_devices.cia402 import objects, si_units
from fieldrig_devices.cia402.eds_file import axis_objects, pdo_objects, write
from fieldrig_devices.cia402.homing_methods import ALL_METHODS
from fieldrig_devices.cia402.node_objects import MORE, NodeFacts, communication, head
from fieldrig_devices.cia402.objects import EMPTY_PDOS, I8, I32, RECEIVED, ROWS, TRANSMITTED, U32, Row
from fieldrig_devices.drives.motor import INCREMENTS_PER_TURN

EDS: Final = Path(__file__).with_name("cia402-drive.eds")
"""The EDS file of the drive, for a CANopen master."""
DEVICE_TYPE: Final = objects.SERVO_DRIVE
PRODUCT: Final = 0x0000_0402
VERSION: Final = "1.0"
PEAK_TORQUE: Final = 3_000
"""Start value of 6072h, in 0.1 % of the rated torque."""

_FACTS: Final = NodeFacts(
    file="cia402-drive.eds",
    description="Servo drive, CiA 402, with every mode of operation",
    created="11-28-2026",
    vendor="fieldrig",
    product="CiA 402 drive",
    product_code=PRODUCT,
    received_pdos=len(RECEIVED) + EMPTY_PDOS,
    transmitted_pdos=len(TRANSMITTED) + EMPTY_PDOS,
    comments=(
        "A drive that exists in fieldrig only, with the objects that CiA 402-2 describes.",
        "A user unit is a millionth of a turn of the motor, whatever the resolution of the encoder.",
    ),
)
_STARTS: Final = {(objects.MAX_TORQUE, None): PEAK_TORQUE, (objects.INTERPOLATION_TIME, 1): 1}
"""Start values that differ from those of an axis of a controller: the torque of the motor, and a SYNC of 1 ms."""


def _rows() -> list[Row]:
    rows = [replace(row, start=_STARTS.get((row.index, row.subindex), row.start)) for row in ROWS]
    methods = [Row(objects.HOMING_METHODS, place, f"Supported homing methods, method {place}", I8, "ro", method)
               for place, method in enumerate(sorted(ALL_METHODS), 1)]  # fmt: skip
    units = [
        Row(si_units.POSITION, None, "SI unit position", U32, "rw", si_units.INCREMENT_POSITIONS),
        Row(si_units.VELOCITY, None, "SI unit velocity", U32, "rw", si_units.INCREMENT_VELOCITIES),
        Row(si_units.ACCELERATION, None, "SI unit acceleration", U32, "rw", si_units.INCREMENT_ACCELERATIONS),
    ]
    name = objects.NAMES[objects.VELOCITY_RESOLUTION]
    sensor = [
        Row(objects.VELOCITY_SENSOR, None, "Velocity sensor actual value", I32, "ro", is_mappable=True),
        Row(objects.VELOCITY_RESOLUTION, 1, f"{name}, encoder increments per second", U32, "rw", INCREMENTS_PER_TURN),
        Row(objects.VELOCITY_RESOLUTION, 2, f"{name}, motor revolutions per second", U32, "rw", 1),
    ]
    return [row for row in rows if row.index != objects.HOMING_METHODS] + methods + units + sensor


def eds_text() -> str:
    """Return the text of the file."""
    drive = axis_objects(0, _rows(), is_only=True)
    return write(head(_FACTS), [communication(_FACTS, DEVICE_TYPE, VERSION, MORE), drive, pdo_objects(0)])


if __name__ == "__main__":
    EDS.write_text(eds_text(), encoding="utf-8", newline="\n")
