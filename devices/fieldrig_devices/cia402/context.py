"""What the modes of one axis share: its objects, its motor, its set values, and the limits that hold for all."""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import S
from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.axis_objects import AxisObjects
from fieldrig_devices.cia402.motion import Motion
from fieldrig_devices.cia402.motor import Motor
from fieldrig_devices.cia402.options import Ramp
from fieldrig_devices.cia402.pace import Pace
from fieldrig_devices.cia402.units import BITS_32, Direction, Units, turn_of, units_of
from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.motion.travel import Travel

SMALLEST: Final = 1e-3
"""In place of a speed of 0, with which no way comes to an end."""


class Context:
    def __init__(self, numbers: AxisObjects, motor: Motor, cycle_ns: int) -> None:
        self.objects, self.motor = numbers, motor
        self.motion = Motion()
        self.pace = Pace()
        self.travel = Travel(motor)
        """Its software limits are 607Dh in increments, corrected by the home offset; none at first, or if min is not
        below max.  That it is limited is bit 11 of the status word."""
        self.on_home: Callable[[float], None] = lambda origin: None
        self.units = Units()
        self.turn = BITS_32
        self.threshold = 0.0
        """606Fh, in increments per second."""
        self.velocity_window = 0.0
        """606Dh, likewise."""
        self.has_following_window = False
        """Whether 6065h is watched."""
        self.largest_speed = 0.0
        """607Fh, likewise."""
        self.use(cycle_ns, None)

    def use(self, cycle_ns: int, origin: float | None) -> None:
        """Before the start."""
        self.cycle_ns = cycle_ns
        self.cycle_s = cycle_ns / S
        self.origin = 0.0 if origin is None else origin
        """Zero of the user's positions, in increments."""
        self.is_homed = origin is not None
        self.refresh()

    def refresh(self) -> None:
        """Objects have changed."""
        self.pace.leave_band()
        numbers = self.objects.numbers

        def pair(index: int) -> tuple[int, int]:
            return numbers[index, 1], numbers[index, 2]

        self.units = units_of(
            pair(objects.ENCODER_RESOLUTION),
            pair(objects.GEAR_RATIO),
            pair(objects.FEED_CONSTANT),
            numbers[objects.POLARITY, 0],
            self.origin,
        )
        self.turn = turn_of(*pair(objects.POSITION_RANGE))
        self.threshold = self.way(numbers[objects.THRESHOLD, 0])
        self.velocity_window = numbers[objects.VELOCITY_WINDOW, 0] * self.units.per_unit
        self.largest_speed = self.way(numbers[objects.MAX_VELOCITY, 0])
        self.has_following_window = numbers[objects.FOLLOWING_WINDOW, 0] != objects.NO_WINDOW
        self.travel.range = self._range()

    def set_home(self, home: float) -> None:
        """607Ch: the user's zero lies by the home offset beyond the home position."""
        self.origin = home + self.units.distance(self.objects[objects.HOME_OFFSET])
        self.is_homed = True
        self.refresh()
        self.on_home(self.origin)

    def track(self, speed: float) -> None:
        """The set values go where the motor is in the next cycle, for who moves it by something else than positions."""
        self.motion.stand(self.motor.position + speed * self.cycle_s)
        self.motion.speed = speed

    # ---- limits, in increments

    def way(self, length: float) -> float:
        """A length, speed or acceleration without sign."""
        return max(length * self.units.per_unit, SMALLEST)

    def limits(self, speed: float, acceleration: float, deceleration: float) -> Limits:
        """Of a profile, from user units, within 607Fh, 60C5h and 60C6h."""
        numbers = self.objects
        return Limits(
            self.way(min(speed, numbers[objects.MAX_VELOCITY])),
            self.way(min(acceleration, numbers[objects.MAX_ACCELERATION])),
            self.way(min(deceleration, numbers[objects.MAX_DECELERATION])),
        )

    def profile_limits(self, speed: float | None = None) -> Limits:
        """By 6083h and 6084h; the speed by 6081h unless it is given."""
        numbers = self.objects
        wanted = numbers[objects.PROFILE_VELOCITY] if speed is None else speed
        return self.limits(wanted, numbers[objects.PROFILE_ACCELERATION], numbers[objects.PROFILE_DECELERATION])

    def ramp_limits(self, ramp: Ramp) -> Limits:
        index = {
            Ramp.SLOW_DOWN: objects.PROFILE_DECELERATION,
            Ramp.QUICK_STOP: objects.QUICK_STOP_DECELERATION,
            Ramp.LIMIT: objects.MAX_DECELERATION,
        }[ramp]
        rate = self.objects[index]
        return self.limits(self.objects[objects.MAX_VELOCITY], rate, rate)

    def _range(self) -> tuple[float, float] | None:
        numbers = self.objects.numbers
        low, high = numbers[objects.POSITION_LIMIT, 1], numbers[objects.POSITION_LIMIT, 2]
        if low >= high or (low, high) == (-0x8000_0000, 0x7FFF_FFFF):
            return None
        offset = numbers[objects.HOME_OFFSET, 0]
        ends = self.units.increments(low - offset), self.units.increments(high - offset)
        return min(ends), max(ends)

    def held_back(self, before: float, wanted: float) -> float:
        """The speed of this cycle, where `wanted` is barred: what a quick stop leaves of the speed `before`."""
        sign = 1 if wanted > 0 else -1
        left = before * sign - self.ramp_limits(Ramp.QUICK_STOP).deceleration * self.cycle_s
        return sign * min(max(left, 0.0), abs(wanted))

    def absolute(self, shown: int, direction: Direction) -> float:
        """A position that the user gives, in increments."""
        near = self.units.position(self.motion.position)
        return self.units.increments(self.turn.meant(shown, near, direction))

    def shown(self, increments: float) -> int:
        """A position for the user."""
        return self.turn.shown(self.units.position(increments))

    def is_standing(self, speed: float) -> bool:
        """Whether the motor stands (606Fh)."""
        return abs(speed) <= self.threshold

    @property
    def interpolation_s(self) -> float:
        """60C2h."""
        numbers = self.objects.numbers
        value: float = numbers[objects.INTERPOLATION_TIME, 1]
        return max(value * 10.0 ** numbers[objects.INTERPOLATION_TIME, 2], self.cycle_s)
