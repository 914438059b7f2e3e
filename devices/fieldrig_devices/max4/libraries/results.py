"""The values of lResult.

The manual gives only 0: the cam was taken (PD-191).  The other numbers are ours; below zero they are errors, and
calling again does not help.
"""

from enum import IntEnum


class Result(IntEnum):
    TAKEN = 0
    WAITING = 1
    """Another cam is waiting already; call again."""
    NO_AXIS = -1
    """lAxisId is not the logical address of an axis."""
    NO_ENCODER = -2
    """lEncId is not the logical address of an encoder."""
    NO_PROFILE = -3
    """lProfilId is not the number of a profile."""
    WRONG_VALUE = -4
    """A number is not finite, a factor is 0, or the lower limit is not below the upper one."""
    WRONG_MODE = -5
    """A set position mode that does not exist."""
    NOT_CONTROLLED = -6
    """The axis is not under control."""
    NO_MASTER_CAM = -7
    """A slave cam needs an active master cam (PD-186)."""
