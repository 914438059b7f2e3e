"""How far an axis may go: limit switches, and software limits.

Source: CiA 402-2, 60FDh bits 0 and 1, 607Dh; what limit switches do outside of homing is left to the drive.  Ours:
whoever moves an axis stops it when it goes onto one; the direction stays barred, also when the switch was overrun,
until the axis is to go the other way or nowhere.  The unit of length is the caller's.
"""

from typing import Final, Protocol

from fieldrig_devices.motion.profile import Limits, Profile, brake, move

NEGATIVE, POSITIVE = 0x1, 0x2
"""Bits of limit switches, as in 60FDh."""
_SWITCHES: Final = NEGATIVE | POSITIVE


class Switches(Protocol):
    @property
    def inputs(self) -> int:
        """As in 60FDh."""


class Travel:
    def __init__(self, switches: Switches) -> None:
        self._switches = switches
        self.held = 0
        """The bit of the switch that holds the axis."""
        self.is_limited = False
        """A set value is held back by something else."""
        self.range: tuple[float, float] | None = None
        """Software limits."""

    @property
    def is_there(self) -> bool:
        """Whether anything limits the way at all: a switch that is on, one that has held the axis, or an end."""
        return self.range is not None or self.held != 0 or bool(self._switches.inputs & _SWITCHES)

    @property
    def is_held_back(self) -> bool:
        return self.is_limited or self.held != 0

    def bars(self, direction: float, others: int = 0) -> bool:
        """Whether the axis may not go on; its sign counts.  `others` bar like active switches."""
        active = self._switches.inputs & _SWITCHES | self.held | others
        if not active:
            return False
        self.held = active & (POSITIVE if direction > 0 else NEGATIVE if direction < 0 else 0)
        return bool(self.held)

    def is_barred(self, direction: float, position: float) -> bool:
        """By a limit switch, or, for who goes by no positions, by a software limit."""
        others, ends = 0, self.range
        if ends is not None:
            others = (POSITIVE if position > ends[1] else 0) | (NEGATIVE if position < ends[0] else 0)
        return self.bars(direction, others)

    def within(self, position: float, now: float | None = None) -> float:
        """`position`, or the software limit that it is beyond.

        `now` is for who is to be there in the next moment: an axis that is beyond a limit is not thrown back to it.
        """
        ends = self.range
        if ends is None or ends[0] <= position <= ends[1]:
            return position
        self.is_limited = True
        low, high = ends if now is None else (min(ends[0], now), max(ends[1], now))
        return min(max(position, low), high)

    def stop_ahead(
        self, position: float, speed: float, wanted: float, limits: Limits, cycle_s: float
    ) -> Profile | None:
        """For who comes to a speed and keeps it: the way to the software limit ahead, from when it is time for that; to
        rest, if it lies behind already."""
        ends, direction = self.range, speed or wanted
        if ends is None or direction == 0 or speed * wanted < 0:  # who turns round stops by himself
            return None
        way = ends[1] - position if direction > 0 else position - ends[0]
        soon = min(abs(speed) + limits.acceleration * cycle_s, max(abs(speed), abs(wanted)))
        if way > soon * soon / (2 * limits.deceleration) + soon * cycle_s:
            return None
        self.is_limited = True
        if way <= 0:
            return brake(speed, limits)
        return move(way if direction > 0 else -way, speed, limits._replace(speed=abs(wanted or speed)))

    def release(self) -> None:
        """Something else begins."""
        self.held, self.is_limited = 0, False
