"""The front of a single drive: the LEDs of CiA 303-3, the state of CiA 402, its motor and its terminals."""

from math import tau
from typing import Final

from fieldrig.front import Clamp, Front, Group, Led, Plate, Switch, Text
from fieldrig_devices.canopen.front import RUN_AND_ERR
from fieldrig_devices.cia402.single.settings import INPUTS, Cia402DriveSettings
from fieldrig_devices.motion.front import motion, position, shaft

_DECIMALS: Final = 4
_MODES: Final = (
    (0, "none"),
    (1, "profile position"),
    (2, "velocity"),
    (3, "profile velocity"),
    (4, "torque"),
    (6, "homing"),
    (7, "interpolated position"),
    (8, "cyclic synchronous position"),
    (9, "cyclic synchronous velocity"),
    (10, "cyclic synchronous torque"),
)
"""Values of 6061h (CiA 402-2)."""


def front_of(settings: Cia402DriveSettings) -> Front:
    motor = settings.motor
    return Front(
        Plate("", "servo drive", {"node-ID": "node_id"}),
        [
            Group(
                [
                    *RUN_AND_ERR,
                    Led("brake", "brake", "the drive lifts the holding brake", colour="yellow"),
                    Text(
                        "state", "state", "of the drive (CiA 402)", good=("operation enabled",),
                        bad=("fault", "fault reaction active"),
                    ),
                    Text("mode", "mode", "mode of operation, as in 6061h", names=_MODES),
                    Text("error", "error_code", "as in 603Fh", names=((0, "none"),), hex_digits=4),
                    Text("status word", "status_word", "as in 6041h", hex_digits=4),
                ],
                "state",
            ),
            motion(
                position(_DECIMALS, settings.low_stop_rad, settings.high_stop_rad),
                ("speed", motor.max_speed_rpm),
                ("torque", motor.peak_torque_nm),
                shaft("position", tau),
            ),
            Group(
                [
                    Switch("STO", "sto", "safe torque off permits a torque"),
                    Switch("mains", "mains", "supply of the power stage"),
                    Switch("blocked", "blocked", "the shaft is blocked"),
                ],
                "supply and shaft",
            ),
            Group([Clamp(name.replace("_", " "), name, is_set=True) for name in INPUTS], "digital inputs"),
        ],
    )  # fmt: skip
