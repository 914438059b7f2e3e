"""EDS and DCF files of other makers' drives: what each declares, and where it is.

The expected facts are read from the files: device type (1000h), modes (6502h, or else the objects that there are, if
6060h accepts them), the increments of 608Fh, and oddities with their lines.  The files are not part of the project;
`FIELDRIG_DRIVE_FILES` names the folder that has them, or it is `shared/eds/drives` beside a folder above this one.
"""

import os
from pathlib import Path
from typing import NamedTuple

import pytest

PLACES = [parent / "shared" / "eds" / "drives" for parent in Path(__file__).parents]
FOLDER = Path(os.environ.get("FIELDRIG_DRIVE_FILES", next((path for path in PLACES if path.is_dir()), "no-folder")))


class Facts(NamedTuple):
    device_type: int
    modes: set[int]
    increments: int
    oddity: str
    """The beginning of one of the findings, with its line."""


ALL = {1, 2, 3, 4, 6, 7, 8, 9, 10}
USUAL = 4_096
FILES = {
    "CANOPEN-SDK--ZeroErr_Driver_V1.5.eds": Facts(0x00420192, {1, 3, 4, 8, 9, 10}, USUAL, "60C1:01 is INTEGER16"),
    "CANOPEN-SDK--elmo.dcf": Facts(0x00000192, ALL - {2}, USUAL, "60E3:01 is UNSIGNED8"),
    "EPOS_Canopen--maxon-70_10.eds": Facts(0x00020192, {1, 3, 6, 8, 9} , USUAL, ""),
    "Eyou_Canopen_master--YiyouServo_V1.4.eds": Facts(0x00020192, ALL - {2, 6}, USUAL, "6072:00 is INTEGER16"),
    "canopen--e35.eds": Facts(0x00020192, ALL | {-2, -1}, 2_000, "60B2:00 is INTEGER32"),
    "cob_robots--Elmo.dcf": Facts(0x00000192, ALL - {2}, USUAL, "6502h (supported drive modes) has no default"),
    "cob_robots--ElmoSimplIQ.dcf": Facts(0x00020192, {1, 3, 4, 6, 7}, USUAL, "6083:00 is 0"),
    "cob_robots--Schunk_0_63.dcf": Facts(0, {1, 2, 7}, USUAL, "the device type 0x00000000"),
    "emec-drv-canopen-tester--emecdrv5.eds": Facts(0x92020100, {1, 8}, USUAL, "the device type 0x92020100"),
    "husarion_ugv_ros--roboteq_motor_controllers_v80_21a.eds": Facts(
        0x192, ALL - {6, 7}, USUAL, "the file describes several axes"
    ),
    "kacanopen--605.3150.51-V-EK-2-60.eds": Facts(0x00020192, {-1, 1, 3, 6}, 2_048, ""),
    "kacanopen--605.3150.55-D-EK-2-60.eds": Facts(0x00020192, {-1, 1, 3, 6}, 2_048, "6060h is not mappable"),
    "kacanopen--605.3150.67-B-EK-2-60.eds": Facts(0x00420192, {*range(-9, 0), 1, 3, 6}, 3_000, "607F:00 is 0"),
    "kacanopen--605.3150.71-A-EK-3-60.eds": Facts(0x00020192, {-1, 1, 3, 6}, 2_048, ""),
    "kacanopen--epos2_347717.eds": Facts(0, {1, 3, 6, 8, 9}, USUAL, "the device type 0x00000000"),
    "maxon_epos4_ros1--epos4_50_15_can_ec90flat_gp52c_mile800_node1.dcf": Facts(
        0x00020192, {1, 3, 6, 8, 9, 10}, USUAL, ""
    ),
    "pilz_robots--prbt_0_1.dcf": Facts(0, {1, 2, 7}, USUAL, "the device type 0x00000000"),
    "ros2_canopen--fake_slaves-cia402_slave.eds": Facts(0xFFFF0192, {1, 3, 6, 8}, USUAL, ""),
    "ros2_canopen--robot_control-cia402_slave.eds": Facts(0x00060192, {1, 3, 6, 7}, USUAL, "6083:00 is 0"),
    "ros_canopen_demo_JetsonTX2_RoboteqSDC3260--roboteq_motor_controllers_v60.eds": Facts(
        0, set(), USUAL, "the object is missing"
    ),
}  # fmt: skip


def path_of(name: str) -> Path:
    if not (FOLDER / name).is_file():
        pytest.skip(f"{name} is not here")
    return FOLDER / name
