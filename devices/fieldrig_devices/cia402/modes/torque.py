"""Profile torque, which follows 6071h along the slope of 6087h, and cyclic synchronous torque, which has no slope.

Source: CiA 402-2, chapters 'profile torque mode' and 'cyclic synchronous torque mode'.  Torques are in 0.1 % of the
rated torque and limited by 6072h and 6073h.  The speed is limited by 6080h and the motor: our choice is that the torque
that would raise it fades out over the last `FADING` of that speed.
"""

from typing import ClassVar, Final

from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.modes.mode import FOLLOWS, TARGET_REACHED, Mode
from fieldrig_devices.cia402.motor import Kind
from fieldrig_devices.cia402.options import Ramp

FADING: Final = 0.2
"""Less than this lets the speed of a light motor swing, as torques act a cycle late."""


class ProfileTorque(Mode):
    number: ClassVar[int] = 4
    kind = Kind.TORQUE

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.torque = 0.0
        self._least = self._most = 0.0

    def begin(self) -> None:
        self.torque, self.gives = 0.0, Kind.TORQUE

    def end(self) -> None:
        self.torque = 0.0

    def halt(self, ramp: Ramp) -> None:
        self.is_halted = True

    def step(self) -> None:
        context, wanted = self.context, self._wanted()
        if context.travel.is_barred(self._speed() or wanted, context.motor.position):
            self._hold()
        else:
            context.track(context.motor.velocity)
            self.gives, self.torque = Kind.TORQUE, self._limited(self._next(wanted))  # no slope delays a limit

    def _speed(self) -> float:
        """The present speed, or 0 if the axis is at rest."""
        if self.gives is Kind.POSITION:
            return self.context.motion.speed
        velocity = self.context.motor.velocity
        return 0.0 if self.context.is_standing(velocity) else velocity

    def _hold(self) -> None:
        """Stop the axis at a limit and hold it there by position, which a torque cannot do."""
        context = self.context
        if self.gives is Kind.TORQUE:
            self.gives, self.torque = Kind.POSITION, 0.0
            context.track(context.motor.velocity)
            self.brake(Ramp.QUICK_STOP)
        else:
            context.motion.step(context.cycle_s)

    def _next(self, wanted: float) -> float:
        slope = self.context.objects[objects.TORQUE_SLOPE] * self.context.cycle_s
        return self.torque + min(max(wanted - self.torque, -slope), slope)

    def _wanted(self) -> float:
        numbers = self.context.objects
        target = 0 if self.is_halted else numbers[objects.TARGET_TORQUE] + self._offset()
        most = self.context.most_torque
        self._least, self._most = -most * self._share(-1), most * self._share(1)
        self.context.travel.is_limited = not self._least <= target <= self._most
        return self._limited(target)

    def _limited(self, torque: float) -> float:
        return min(max(torque, self._least), self._most)

    def _share(self, way: int) -> float:
        """The share of the torque that is left at the present speed: 1, and less from 0.8 of the largest speed on."""
        left = 1 - way * self.context.motor.velocity / self.context.motor_speed
        return min(max(left / FADING, 0.0), 1.0)

    def _offset(self) -> int:
        return 0

    @property
    def value(self) -> float:
        return round(self.torque if self.gives is Kind.TORQUE else self.context.motion.position)

    @property
    def status(self) -> int:
        if self.is_halted:
            return self.halted_status
        is_there = self.torque == self._wanted() and self.gives is Kind.TORQUE
        return TARGET_REACHED if is_there else 0


class CyclicTorque(ProfileTorque):
    number = 10

    def _next(self, wanted: float) -> float:
        return wanted

    def _offset(self) -> int:
        return self.context.objects[objects.TORQUE_OFFSET]

    @property
    def status(self) -> int:
        return 0 if self.is_halted or self.gives is not Kind.TORQUE else FOLLOWS
