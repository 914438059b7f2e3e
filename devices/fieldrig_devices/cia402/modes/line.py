"""The straight line between set positions in the cyclic CiA 402 modes, which lasts as long as 60C2h says.

Until the first set position arrives, the axis is brought to rest.  The position demand (6062h) is that of the line, so
an axis that is limited to 607Fh has a following error from what it has not done yet.
"""

from typing import ClassVar

from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.modes.interpolator import Interpolator
from fieldrig_devices.cia402.modes.mode import Mode
from fieldrig_devices.cia402.units import Direction


class LinePosition(Mode):
    has_offset: ClassVar[bool] = False
    """True if the position offset (60B0h) is added."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._line = Interpolator()
        self._is_begun = self._is_led = False
        self._behind = 0.0
        self._is_cut = False
        """True if the end of the line is a limit of the travel, beyond which the set position is."""

    def begin(self) -> None:
        self._is_begun, self._is_led = True, False
        self.come_to_rest()

    def end(self) -> None:
        self._is_begun = False

    def go_on(self) -> None:
        super().go_on()
        self._is_led = False

    def _lead(self, begin: float, position: int, ahead_s: float = 0.0) -> None:
        """Start a line from `begin` to `position` in user units; `ahead_s` of its time have already passed."""
        self._line.go(begin, self._aim(position), self.context.interpolation_s, ahead_s)
        self._is_led = True

    def _aim(self, position: int) -> float:
        context = self.context
        context.travel.is_limited = False
        offset = context.units.distance(context.objects[objects.POSITION_OFFSET]) if self.has_offset else 0.0
        wanted = context.absolute(position, Direction.SHORTEST) + offset
        end = context.travel.within(wanted, context.motion.position)
        self._is_cut = context.travel.is_limited
        return end

    @property
    def behind(self) -> float:
        return self._behind if self._is_begun and self._is_led and not self.is_halted else 0.0

    def _follow(self, place: float) -> None:
        """Move to `place` in this cycle, as far as 607Fh and the limit switches allow."""
        context, motion = self.context, self.context.motion
        most = context.largest_speed * context.cycle_s
        way = place - motion.position
        self._behind = 0.0
        context.travel.is_limited = self._is_cut or abs(way) > most
        if abs(way) > most:
            limited = min(max(way, -most), most)
            self._behind, way = way - limited, limited
        if context.travel.bars(way):
            way = context.held_back(motion.speed, way / context.cycle_s) * context.cycle_s
        motion.follow(motion.position + way, context.cycle_s)
