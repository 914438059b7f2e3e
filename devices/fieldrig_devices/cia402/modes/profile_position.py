"""Profile position: set-points with a handshake, single or in sequence.

Source: CiA 402-2, chapter 'profile position mode'; 60F2h for the base of a relative set-point, and for the direction to
an absolute one within the range of 607Bh.  A set-point keeps the profile values that were valid on its arrival.  The
buffer holds one set-point besides the active one, unless `Behaviour` says another number.
"""

from collections import deque
from collections.abc import Callable
from typing import Final, NamedTuple

from fieldrig.clock import MS
from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.modes.mode import BIT_12, TARGET_REACHED, Mode
from fieldrig_devices.cia402.options import Ramp
from fieldrig_devices.cia402.permitted import FROM_ACTUAL, JERK_USES, POSITIONING, PROFILE_TYPES, RELATIVE_OPTION
from fieldrig_devices.cia402.units import Direction
from fieldrig_devices.cia402.window import Window
from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.motion.smooth import move, pass_through

NEW_SET_POINT: Final = 0x0010
CHANGE_IMMEDIATELY: Final = 0x0020
RELATIVE: Final = 0x0040
CHANGE_ON_SET_POINT: Final = 0x0200
ACKNOWLEDGE: Final = BIT_12
FROM_DEMAND: Final = 1


class SetPoint(NamedTuple):
    position: int
    is_relative: bool
    is_passed: bool
    """True with 'change on set-point': the axis does not stop at the set-point before this one."""
    direction: Direction
    limits: Limits


class ProfilePosition(Mode):
    number = 1

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._target = 0.0
        self._limits = Limits(1.0, 1.0, 1.0)
        self._waiting: deque[SetPoint] = deque()
        """Set-points behind the active one."""
        self._buffered = context.behaviour.set_points - 1
        self._is_acknowledged = False
        self._unshown_ns = 0
        """Time until bit 12 shows the acknowledgement."""
        self._is_moving = False
        self._is_passing = False
        self._is_asked = False
        self._is_stopped = False
        """True if a limit switch has stopped the axis and cancelled the set-point."""
        self._is_reached = False
        self._window = Window()

    def begin(self) -> None:
        self.come_to_rest()
        self._target = self.context.motion.end
        self._waiting.clear()
        self._is_moving = self._is_passing = self._is_stopped = self._is_reached = False
        self._is_acknowledged, self._unshown_ns = self.context.behaviour.acknowledges_at_start, 0
        self._window.reset()

    def end(self) -> None:
        self._waiting.clear()
        self._is_acknowledged = False

    def writers(self) -> dict[tuple[int, int], Callable[[int], None]]:
        rules = {
            objects.POSITIONING_OPTION: POSITIONING,
            objects.PROFILE_TYPE: PROFILE_TYPES,
            objects.JERK_USE: JERK_USES,
        }
        numbers = self.context.objects
        return {(index, 0): numbers.or_start(index, rule.check) for index, rule in rules.items()}

    def control(self, word: int, rising: int) -> None:
        was_asked, self._is_asked = self._is_asked, bool(word & NEW_SET_POINT)
        if rising & NEW_SET_POINT and not self._is_busy:
            self._take(word)
        if was_asked or not self.context.behaviour.acknowledges_at_start:
            self._update_acknowledge()

    @property
    def _is_busy(self) -> bool:
        """True while a drive that holds a single set-point moves to it."""
        return self._buffered == 0 and self._is_moving and not self._is_stopped

    def _take(self, word: int) -> None:
        context = self.context
        set_point = SetPoint(
            context.objects[objects.TARGET_POSITION],
            bool(word & RELATIVE),
            bool(word & CHANGE_ON_SET_POINT),
            Direction(context.objects[objects.POSITIONING_OPTION] >> 6),
            context.profile_limits(),
        )
        if word & CHANGE_IMMEDIATELY or not self._is_moving or self._is_stopped:
            self._waiting.clear()
            self._start(set_point)
        elif len(self._waiting) < self._buffered:
            self._waiting.append(set_point)
            if self._waiting[0].is_passed and not self.is_halted:
                self._run()
        else:
            return  # the buffer is full, which bit 12 has shown by staying set
        self._is_acknowledged = True
        self._unshown_ns = round(context.behaviour.acknowledge_ms * MS)

    def _update_acknowledge(self) -> None:
        is_full = self._is_busy if self._buffered == 0 else len(self._waiting) >= self._buffered
        if not self._is_asked and not is_full:
            self._is_acknowledged = False

    def _start(self, set_point: SetPoint, seconds: float = 0.0) -> None:
        context = self.context
        context.travel.is_limited = False
        target = (
            self._base() + context.units.distance(set_point.position)
            if set_point.is_relative
            else context.absolute(set_point.position, set_point.direction)
        )
        self._target, self._limits = context.travel.within(target), set_point.limits
        self._is_moving, self._is_stopped, self._is_reached = True, False, False
        self._window.reset()
        if not self.is_halted:
            self._run(seconds)

    def _base(self) -> float:
        """The position that a relative set-point is added to."""
        option = self.context.objects[objects.POSITIONING_OPTION] & RELATIVE_OPTION
        if option == FROM_DEMAND:
            return self.context.motion.position
        return float(self.context.motor.position) if option == FROM_ACTUAL else self._target

    def _run(self, seconds: float = 0.0) -> None:
        motion = self.context.motion
        distance = self._target - motion.position
        self._is_passing = (
            bool(self._waiting) and self._waiting[0].is_passed and distance != 0 and distance * motion.speed >= 0
        )
        profile = pass_through if self._is_passing else move
        motion.start(profile(distance, motion.speed, self._limits, motion.acceleration), seconds)

    def go_on(self) -> None:
        super().go_on()
        if self._is_moving and not self._is_stopped:
            self._run()

    def step(self) -> None:
        context = self.context
        motion = context.motion
        if self._is_acknowledged:
            self._unshown_ns = max(self._unshown_ns - context.cycle_ns, 0)
        is_driving = self._is_moving and not self.is_halted
        if is_driving and context.travel.bars(self._target - motion.position) and not self._is_stopped:
            self._give_up()
        motion.step(context.cycle_s)
        if self.is_halted or self._is_stopped or not motion.is_done:
            return
        if self._waiting:
            self._go_to_next()
        else:
            self._is_reached = self._is_in_window()
            self._is_moving = self._is_moving and not self._is_reached
            if self._buffered == 0 and not self._is_moving:
                self._update_acknowledge()

    def _give_up(self) -> None:
        self._is_stopped = True
        self._waiting.clear()
        self._update_acknowledge()
        self.brake(Ramp.QUICK_STOP)

    def _go_to_next(self) -> None:
        """Start the next set-point at the instant at which the one before it was reached."""
        motion, set_point = self.context.motion, self._waiting.popleft()
        seconds, motion.position = motion.overrun_s, motion.end
        self._start(set_point, seconds)
        self._update_acknowledge()

    def _is_in_window(self) -> bool:
        """True within the position window (6067h, 6068h); an axis that is pushed out of it is no longer there."""
        context = self.context
        window = context.objects[objects.POSITION_WINDOW]
        if window == objects.NO_WINDOW:
            return True
        is_inside = abs(round(self._target) - context.motor.position) <= window * context.units.per_unit
        return self._window.update(is_inside, context.objects[objects.POSITION_TIME], context.cycle_ns)

    @property
    def status(self) -> int:
        acknowledge = ACKNOWLEDGE if self._is_acknowledged and not self._unshown_ns else 0
        if self.is_halted:
            return acknowledge | self.halted_status
        return acknowledge | (TARGET_REACHED if self._is_reached else 0)
