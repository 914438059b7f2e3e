"""Cyclic synchronous position and velocity: a set-point with every SYNC, on a straight line between them.

Source: CiA 402-2, chapters 'cyclic synchronous position mode' and 'cyclic synchronous velocity mode'.  A set-point
counts from its coming (an RPDO of a synchronous type brings it with the SYNC), and is reached after the time of 60C2h.
Ours: until the first one comes the axis stands; when none comes any more it keeps the last one; a position that 607Fh
forbids is followed as fast as allowed.
"""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.modes.interpolator import Interpolator
from fieldrig_devices.cia402.modes.mode import BIT_12, Mode
from fieldrig_devices.cia402.motor import Kind
from fieldrig_devices.cia402.options import Ramp

FOLLOWS: Final = BIT_12


class CyclicPosition(Mode):
    number = 8

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._line = Interpolator()
        self._is_active = False

    def begin(self) -> None:
        self._is_active = True
        self._line.stand(self.context.motion.position)

    def end(self) -> None:
        self._is_active = False

    def writers(self) -> dict[tuple[int, int], Callable[[int], None]]:
        return {(objects.TARGET_POSITION, 0): self._on_target}

    def _on_target(self, position: int) -> None:
        if not self._is_active or self.is_halted:
            return
        context = self.context
        context.is_limited = False
        offset = context.units.distance(context.objects[objects.POSITION_OFFSET])
        target = context.within(context.absolute(position) + offset)
        self._line.go(context.motion.position, target, context.interpolation_s)

    def go_on(self) -> None:
        super().go_on()
        self._line.stand(self.context.motion.position)

    def step(self) -> None:
        context, motion = self.context, self.context.motion
        if self.is_halted:
            super().step()
            return
        wanted = self._line.step(context.cycle_s)
        most = context.way(context.objects[objects.MAX_VELOCITY]) * context.cycle_s
        way = wanted - motion.position
        if abs(way) > most:
            context.is_limited = True
            way = min(max(way, -most), most)
        motion.follow(motion.position + way, context.cycle_s)

    @property
    def status(self) -> int:
        return self.halted_status if self.is_halted else FOLLOWS


class CyclicVelocity(Mode):
    number = 9
    kind = Kind.VELOCITY

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._line = Interpolator()
        self._is_active = False
        self._velocity = 0.0

    def begin(self) -> None:
        self._is_active = True
        self._velocity = self.context.motion.speed
        self._line.stand(self._velocity)

    def end(self) -> None:
        self._is_active = False

    def writers(self) -> dict[tuple[int, int], Callable[[int], None]]:
        return {(objects.TARGET_VELOCITY, 0): self._on_target}

    def _on_target(self, velocity: int) -> None:
        if not self._is_active or self.is_halted:
            return
        context = self.context
        wanted = context.units.speed(velocity + context.objects[objects.VELOCITY_OFFSET])
        most = context.way(context.objects[objects.MAX_VELOCITY])
        context.is_limited = abs(wanted) > most
        self._line.go(self._velocity, min(max(wanted, -most), most), context.interpolation_s)

    def halt(self, ramp: Ramp) -> None:
        self.is_halted = True
        rate = self.context.ramp_limits(ramp).deceleration
        self._line.go(self._velocity, 0.0, abs(self._velocity) / rate)

    def go_on(self) -> None:
        super().go_on()
        self._line.stand(self._velocity)

    def step(self) -> None:
        context = self.context
        self._velocity = self._line.step(context.cycle_s)
        context.motion.stand(context.motor.position)
        context.motion.speed = self._velocity

    @property
    def value(self) -> float:
        return self._velocity

    @property
    def status(self) -> int:
        return self.halted_status if self.is_halted else FOLLOWS
