"""Cyclic synchronous position and velocity: a set-point with every SYNC, and straight lines between them.

Source: CiA 402-2, chapters 'cyclic synchronous position mode' and 'cyclic synchronous velocity mode'.  A set-point
takes effect on arrival (a synchronous RPDO brings it with the SYNC), and is reached after the time of 60C2h.
Our choices: until the first set-point arrives, an axis stands still or keeps its speed; when set-points stop arriving,
it keeps the last one; it approaches a position too far for 607Fh at the maximum speed, with a following error.
"""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.modes.interpolator import Interpolator
from fieldrig_devices.cia402.modes.line import LinePosition
from fieldrig_devices.cia402.modes.mode import FOLLOWS, Mode
from fieldrig_devices.cia402.motor import Kind
from fieldrig_devices.cia402.options import Ramp

NEARLY: Final = 1 + 1e-6
"""Tolerance for times that add up to a cycle except for rounding."""


class CyclicPosition(LinePosition):
    number = 8
    has_offset = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._is_fresh = False
        """True if the line was started since the last cycle; a further set-point then only moves its end."""

    def writers(self) -> dict[tuple[int, int], Callable[[int], None]]:
        return {(objects.TARGET_POSITION, 0): self._on_target, (objects.POSITION_OFFSET, 0): self._on_offset}

    def _on_target(self, position: int) -> None:
        if not self._is_begun or self.is_halted:
            return
        line, left_s = self._line, self._line.left_s
        if self._is_fresh and self._is_led:
            line.end = self._aim(position)
        elif self._is_led and 0 < left_s <= self.context.cycle_s * NEARLY:
            self._lead(line.end, position, -left_s)  # the rest of the line ends before the next cycle
        else:
            self._lead(self.context.motion.position, position)
        self._is_fresh = True

    def _on_offset(self, _offset: int) -> None:
        if self._is_led:
            self._on_target(self.context.objects[objects.TARGET_POSITION])

    def step(self) -> None:
        self._is_fresh = False
        if self._is_led and not self.is_halted:
            self._follow(self._line.step(self.context.cycle_s))
        else:
            super().step()

    @property
    def status(self) -> int:
        """Bit 12 is 0 as well while the axis comes to rest from another mode, and no set-point has come yet."""
        if self.is_halted:
            return self.halted_status
        follows = self._is_led or self.context.motion.is_done
        return FOLLOWS if follows and not self.context.travel.held else 0


class CyclicVelocity(Mode):
    number = 9
    kind = Kind.VELOCITY

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._line = Interpolator()
        self._is_active = self._is_led = False
        self._velocity = 0.0

    def begin(self) -> None:
        self._is_active, self._is_led = True, False
        self._velocity = self.context.motion.speed
        self._line.stand(self._velocity)

    def end(self) -> None:
        self._is_active = False

    def writers(self) -> dict[tuple[int, int], Callable[[int], None]]:
        return {(objects.TARGET_VELOCITY, 0): self._on_target, (objects.VELOCITY_OFFSET, 0): self._on_offset}

    def _on_offset(self, _offset: int) -> None:
        if self._is_led:
            self._on_target(self.context.objects[objects.TARGET_VELOCITY])

    def _on_target(self, velocity: int) -> None:
        if not self._is_active or self.is_halted:
            return
        context = self.context
        wanted = context.units.speed(velocity + context.objects[objects.VELOCITY_OFFSET])
        most = context.largest_speed
        context.travel.is_limited = abs(wanted) > most
        self._line.go(self._velocity, min(max(wanted, -most), most), context.interpolation_s)
        self._is_led = True

    def halt(self, ramp: Ramp) -> None:
        self.is_halted = True
        rate = self.context.ramp_limits(ramp).deceleration
        self._line.go(self._velocity, 0.0, abs(self._velocity) / rate)

    def go_on(self) -> None:
        super().go_on()
        self._is_led = False
        self._line.stand(self._velocity)

    def step(self) -> None:
        context = self.context
        wanted, before = self._line.step(context.cycle_s), self._velocity
        self._velocity = (
            context.held_back(before, wanted) if context.travel.is_barred(wanted, context.motor.position) else wanted
        )
        context.track(self._velocity)

    @property
    def value(self) -> float:
        return self._velocity

    @property
    def status(self) -> int:
        if self.is_halted:
            return self.halted_status
        return 0 if self.context.travel.held else FOLLOWS
