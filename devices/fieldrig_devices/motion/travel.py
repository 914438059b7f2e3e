"""Limits of an axis's travel: limit switches and software limits.

Source: CiA 402-2, 60FDh bits 0 and 1, 607Dh; the effect of limit switches outside of homing is left to the drive.  Our
reading: an axis that runs onto a switch is stopped, and its direction stays barred, even if the axis overruns the
switch, until the axis is commanded the other way or to stand still.  The unit of length is the caller's.
"""

from math import inf
from typing import Final, Protocol

from fieldrig_devices.motion.profile import Limits, Profile
from fieldrig_devices.motion.smooth import brake, move

NEGATIVE, POSITIVE = 0x1, 0x2
"""Bits of the limit switches, as in 60FDh."""
_SWITCHES: Final = NEGATIVE | POSITIVE


class Switches(Protocol):
    @property
    def inputs(self) -> int:
        """Active switches as bits, as in 60FDh."""


class Travel:
    def __init__(self, switches: Switches) -> None:
        self._switches = switches
        self.held = 0
        """Bit of the switch that holds the axis, or 0."""
        self.is_limited = False
        """True if a limit holds back a set value."""
        self.range: tuple[float, float] | None = None
        """Software limits, lower and upper; None if there are none."""

    @property
    def is_there(self) -> bool:
        """True if anything limits the travel: an active switch, a switch that holds the axis, or a software limit."""
        return self.range is not None or self.held != 0 or bool(self._switches.inputs & _SWITCHES)

    @property
    def is_held_back(self) -> bool:
        return self.is_limited or self.held != 0

    def bars(self, direction: float, others: int = 0) -> bool:
        """True if the axis must not move in `direction`, of which only the sign counts.

        `others` has further bits that bar the axis like active switches.
        """
        active = self._switches.inputs & _SWITCHES | self.held | others
        if not active:
            return False
        self.held = active & (POSITIVE if direction > 0 else NEGATIVE if direction < 0 else 0)
        return bool(self.held)

    def is_barred(self, direction: float, position: float) -> bool:
        """True if a limit switch or, for modes without position control, a software limit bars `direction`."""
        others, ends = 0, self.range
        if ends is not None:
            others = (POSITIVE if position > ends[1] else 0) | (NEGATIVE if position < ends[0] else 0)
        return self.bars(direction, others)

    def within(self, position: float, now: float | None = None) -> float:
        """Return `position`, limited to the software limits.

        Pass the present position as `now` if the axis follows at once: an axis that is already beyond a limit stays
        there instead of jumping back to it.
        """
        ends = self.range
        if ends is None or ends[0] <= position <= ends[1]:
            return position
        self.is_limited = True
        low, high = ends if now is None else (min(ends[0], now), max(ends[1], now))
        return min(max(position, low), high)

    def stop_ahead(
        self,
        position: float,
        speed: float,
        wanted: float,
        limits: Limits,
        cycle_s: float,
        acceleration: float = 0.0,
    ) -> Profile | None:
        """Return the profile that stops at the software limit ahead, or None while there is no need to brake yet.

        For modes that control the speed.  An axis that is already beyond the limit brakes to rest.
        """
        ends, direction = self.range, speed or wanted
        if ends is None or direction == 0 or speed * wanted < 0:  # an axis that reverses stops anyway
            return None
        way = ends[1] - position if direction > 0 else position - ends[0]
        soon = min(abs(speed) + limits.acceleration * cycle_s, max(abs(speed), abs(wanted)))
        if way > _stopping_way(soon, limits, acceleration, cycle_s) + soon * cycle_s:
            return None
        self.is_limited = True
        if way <= 0:
            return brake(speed, limits, acceleration)
        slower = limits._replace(speed=abs(wanted or speed))
        return move(way if direction > 0 else -way, speed, slower, acceleration)

    def release(self) -> None:
        """Release the axis at the start of another motion."""
        self.held, self.is_limited = 0, False


def _stopping_way(speed: float, limits: Limits, acceleration: float, cycle_s: float) -> float:
    """Return the way from a speed, without its sign, to rest, after one more cycle of the present acceleration."""
    if limits.jerk == inf:
        return speed * speed / (2 * limits.deceleration)
    soon = min(abs(acceleration) + limits.jerk * cycle_s, limits.acceleration)
    return brake(speed, limits, soon).distance
