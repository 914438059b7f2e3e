"""Names of the blocks of a controller without a program, which masters use (SCU-009, SCU-010)."""

from collections.abc import Mapping
from typing import Final

SIMPLE: Final = "PTO00"
PWM_NAMES: Final = ("PWM00", "PWM01")
BLOCK_NAMES: Final[Mapping[str, str]] = {
    SIMPLE: "PTOSimple",
    "MoveRelative": "PTOMoveRelative",
    "MoveVelocity": "PTOMoveVelocity",
    "Stop": "PTOStop",
    "GetParam": "PTOGetParam",
    "SetParam": "PTOSetParam",
    "GetDiag": "PTOGetDiag",
    "PWM00": "PWM",
    "PWM01": "PWM",
}
"""Types of the blocks by their names; a channel that has another name in the settings is also found by this one."""
