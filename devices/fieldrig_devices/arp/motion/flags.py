"""The flags of an axis, numbered within its own 32: F257 is number 1 of axis 1, F289 of axis 2.

Source: manual 4.6; digest chapter 8.2.
"""

from enum import IntEnum
from typing import Final

FLAGS_BEFORE: Final = (0, 256, 288)
"""Number of flags before the axis' own, by axis."""


class AxisFlag(IntEnum):
    HOMING = 2
    HOMED = 3
    ARRIVED = 4
    SYNCHRONOUS = 5
    STOP = 6
    RUNNING = 7
    FINAL_SPEED = 8
    ARM_RISING = 9
    ARM_FALLING = 10
    PASSED_MAXIMUM = 11
    PASSED_MINIMUM = 12


class AxisFlags:
    """View of one axis' flags in the card's list."""

    __slots__ = ("_before", "_flags", "_stop")

    def __init__(self, axis: int, flags: list[int]) -> None:
        self._flags, self._before = flags, FLAGS_BEFORE[axis]
        self._stop = self._before + AxisFlag.STOP

    def __getitem__(self, flag: AxisFlag) -> int:
        return self._flags[self._before + flag]

    def __setitem__(self, flag: AxisFlag, bit: int) -> None:
        self._flags[self._before + flag] = bit

    @property
    def is_to_stop(self) -> bool:
        """F262: PAC, PRC, PVC and PST end, and leave the axis at its speed."""
        return self._flags[self._stop] != 0

    def clear(self) -> None:
        for flag in AxisFlag:
            self[flag] = 0
