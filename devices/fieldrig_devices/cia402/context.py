"""The state that the modes of one axis share: its objects, motor and set values, and the limits of all modes."""

from collections.abc import Callable
from dataclasses import replace
from math import inf
from typing import Final

from fieldrig.clock import S
from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.axis_objects import AxisObjects
from fieldrig_devices.cia402.behaviour import Behaviour
from fieldrig_devices.cia402.limit_switches import BarringSwitches
from fieldrig_devices.cia402.motion import Motion
from fieldrig_devices.cia402.motor import Motor
from fieldrig_devices.cia402.options import Ramp
from fieldrig_devices.cia402.pace import Pace
from fieldrig_devices.cia402.permitted import JERK_LIMITED
from fieldrig_devices.cia402.si_units import SiUnits
from fieldrig_devices.cia402.units import BITS_32, Direction, Units, turn_of, units_of
from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.motion.travel import Travel

SMALLEST: Final = 1e-3
"""Replaces a speed of 0, at which no motion would ever end."""


class Context:
    def __init__(self, numbers: AxisObjects, motor: Motor, cycle_ns: int, behaviour: Behaviour) -> None:
        self.objects, self.motor, self.behaviour = numbers, motor, behaviour
        self.motion = Motion()
        self.pace = Pace()
        self.travel = Travel(BarringSwitches(motor, behaviour.limit_switch))
        """Limits of the motion.  Its software limits are those of 607Dh in increments, corrected by the home offset;
        there are none if min is not below max.  A limited motion is bit 11 of the status word."""
        self.on_home: Callable[[float], None] = lambda origin: None
        self.on_quick_stop: Callable[[], None] = lambda: None
        """Called when the drive has to stop quickly for a reason of its own."""
        self.units = Units()
        self.si = SiUnits()
        self.turn = BITS_32
        self.threshold = 0.0
        """Velocity threshold (606Fh), in increments per second."""
        self.velocity_window = 0.0
        """Velocity window (606Dh), in increments per second."""
        self.has_following_window = False
        """True if the following error window (6065h) is monitored."""
        self.largest_speed = 0.0
        """Maximum profile velocity (607Fh) or, if lower, maximum motor speed (6080h), in increments per second."""
        self.motor_speed = inf
        """Maximum motor speed (6080h), in increments per second."""
        self.use(cycle_ns, None)

    def use(self, cycle_ns: int, origin: float | None) -> None:
        """Set the cycle time, and the origin if the axis has been homed before; called before a start."""
        self.cycle_ns = cycle_ns
        self.cycle_s = cycle_ns / S
        self.origin = 0.0 if origin is None else origin
        """Zero of the user's positions, in increments of the motor."""
        self.is_homed = origin is not None
        self.refresh()

    def refresh(self) -> None:
        """Compute again what depends on objects, after any of them has changed."""
        self.pace.leave_band()
        numbers = self.objects.numbers

        def pair(index: int) -> tuple[int, int]:
            return numbers[index, 1], numbers[index, 2]

        encoder, gear = pair(objects.ENCODER_RESOLUTION), pair(objects.GEAR_RATIO)
        feed: tuple[float, int] = pair(objects.FEED_CONSTANT)
        if max(*feed, 1) == 1 and not self.behaviour.has_feed_constant:
            feed = encoder if self.si.per_turn is None else (self.si.per_turn, 1)
        units = units_of(encoder, gear, feed, numbers[objects.POLARITY, 0], self.origin)
        turn = self.motor.revolution
        self.units = self.si.scaled(units, turn, turn * max(gear[0], 1) / max(gear[1], 1))
        if self.behaviour.velocity_unit is not None:
            self.units = replace(
                self.units, per_speed_unit=self.behaviour.velocity_unit * turn / self.si.velocity_factor
            )
        self.turn = turn_of(*pair(objects.POSITION_RANGE))
        self.threshold = self.speed(numbers[objects.THRESHOLD, 0])
        self.velocity_window = numbers[objects.VELOCITY_WINDOW, 0] * self.units.per_speed_unit
        self.motor_speed = self._fastest()
        self.largest_speed = min(self.speed(numbers[objects.MAX_VELOCITY, 0]), self.motor_speed)
        self.has_following_window = numbers[objects.FOLLOWING_WINDOW, 0] != objects.NO_WINDOW
        self.travel.range = self._range()

    def set_home(self, home: float) -> None:
        """Move the user's zero, which lies beyond the home position by the home offset (607Ch)."""
        self.origin = home + self.units.distance(self.home_offset)
        self.is_homed = True
        self.refresh()
        self.on_home(self.origin)

    @property
    def home_offset(self) -> int:
        """The way from the home position to the user's zero, in user units (607Ch)."""
        return -self.behaviour.home_offset_sign * self.objects[objects.HOME_OFFSET]

    def track(self, speed: float) -> None:
        """Let the position demand follow the motor, in modes without position control."""
        self.motion.stand(self.motor.position + speed * self.cycle_s)
        self.motion.speed = speed

    # ---- limits, in increments

    def speed(self, velocity: float) -> float:
        """A velocity of the user in increments per second, without its sign."""
        return max(velocity * self.units.per_speed_unit, SMALLEST)

    def rate(self, acceleration: float) -> float:
        """An acceleration of the user in increments per second squared, without its sign."""
        return max(acceleration * self.units.per_rate_unit, SMALLEST)

    def limits(self, speed: float, acceleration: float, deceleration: float) -> Limits:
        """Profile limits from values in user units, restricted by 607Fh, 60C5h and 60C6h."""
        numbers = self.objects
        return Limits(
            min(self.speed(min(speed, numbers[objects.MAX_VELOCITY])), self.motor_speed),
            self.rate(min(acceleration, numbers[objects.MAX_ACCELERATION])),
            self.rate(min(deceleration, numbers[objects.MAX_DECELERATION])),
        )

    def _fastest(self) -> float:
        """Return the lower one of 6080h and what the motor can, beyond which a demand would only run ahead of it."""
        rpm = self.objects[objects.MAX_MOTOR_SPEED]
        given = inf if rpm == objects.NO_SPEED_LIMIT else max(self.of_rpm(rpm), SMALLEST)
        return min(given, self.motor.largest_speed)

    def of_rpm(self, rpm: float) -> float:
        """A speed of the motor in increments per second."""
        return rpm * self.motor.revolution / 60

    @property
    def most_torque(self) -> int:
        """The lower one of the limits for torque (6072h) and current (6073h), in 0.1 % of the rated torque."""
        numbers = self.objects
        by_current = round(numbers[objects.MAX_CURRENT] * self.motor.torque_by_current)
        return min(numbers[objects.MAX_TORQUE], by_current)

    def profile_limits(self, speed: float | None = None) -> Limits:
        """Profile limits from 6083h, 6084h and 60A4h, with the speed from 6081h unless it is given."""
        numbers = self.objects
        wanted = numbers[objects.PROFILE_VELOCITY] if speed is None else speed
        limits = self.limits(wanted, numbers[objects.PROFILE_ACCELERATION], numbers[objects.PROFILE_DECELERATION])
        return limits._replace(jerk=self._jerk)

    @property
    def _jerk(self) -> float:
        """The jerk of a profile in increments per second cubed; it has no limit unless 6086h says so."""
        numbers = self.objects
        if numbers[objects.PROFILE_TYPE] != JERK_LIMITED:
            return inf
        return self.rate(numbers.numbers[objects.PROFILE_JERK, 1])

    def ramp_limits(self, ramp: Ramp) -> Limits:
        index = {
            Ramp.SLOW_DOWN: objects.PROFILE_DECELERATION,
            Ramp.QUICK_STOP: objects.QUICK_STOP_DECELERATION,
            Ramp.LIMIT: objects.MAX_DECELERATION,
        }[ramp]
        rate = self.objects[index]
        limits = self.limits(self.objects[objects.MAX_VELOCITY], rate, rate)
        return limits._replace(jerk=self._jerk) if ramp is Ramp.SLOW_DOWN else limits

    def _range(self) -> tuple[float, float] | None:
        numbers = self.objects.numbers
        low, high = numbers[objects.POSITION_LIMIT, 1], numbers[objects.POSITION_LIMIT, 2]
        is_literal = low == high == 0 and self.behaviour.empty_limits_count
        if (low >= high and not is_literal) or (low, high) == objects.NO_POSITION_LIMITS:
            return None
        offset = self.home_offset
        ends = self.units.increments(low - offset), self.units.increments(high - offset)
        return min(ends), max(ends)

    def held_back(self, before: float, wanted: float) -> float:
        """The speed of this cycle if `wanted` is barred: the speed `before`, reduced by the quick stop deceleration."""
        sign = 1 if wanted > 0 else -1
        left = before * sign - self.ramp_limits(Ramp.QUICK_STOP).deceleration * self.cycle_s
        return sign * min(max(left, 0.0), abs(wanted))

    def absolute(self, shown: int, direction: Direction) -> float:
        """The position in increments that the user means by `shown`."""
        near = self.units.position(self.motion.position)
        return self.units.increments(self.turn.meant(shown, near, direction))

    def shown(self, increments: float) -> int:
        """The position as the user sees it."""
        return self.turn.shown(self.units.position(increments))

    def is_standing(self, speed: float) -> bool:
        """True if the speed is within the velocity threshold (606Fh)."""
        return abs(speed) <= self.threshold

    @property
    def interpolation_s(self) -> float:
        """Interpolation time period (60C2h) in seconds, at least one cycle."""
        numbers = self.objects.numbers
        value: float = numbers[objects.INTERPOLATION_TIME, 1]
        return max(value * 10.0 ** numbers[objects.INTERPOLATION_TIME, 2], self.cycle_s)
