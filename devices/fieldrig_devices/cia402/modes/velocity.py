"""Velocity mode (vl), as frequency inverters have it: a speed in turns per minute, through a ramp function.

Source: CiA 402-2, chapter 'velocity mode'.  6042h times the set-point factor (604Bh) and the dimension factor (604Ch)
is the speed of the motor in min-1; 6043h and 6044h are in the unit of 6042h.  Our choices: with bit 4 at 0 the axis
comes to rest by the quick stop ramp (604Ah), and bit 10 of the status word shows that the ramp has reached its input; a
target of 0 is a standstill, whatever the minimum of 6046h is, since a master that writes 0 wants the axis to stop.
Left out: 6047h (limits by direction), 604Dh to 604Fh and the ramp times, percentages and references from 6050h on.
"""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.context import SMALLEST, Context
from fieldrig_devices.cia402.modes.mode import TARGET_REACHED
from fieldrig_devices.cia402.modes.speed import SpeedMode
from fieldrig_devices.cia402.options import Ramp
from fieldrig_devices.motion.profile import Limits

ENABLE: Final = 0x0010
UNLOCK: Final = 0x0020
REFERENCE: Final = 0x0040
"""Bits of the control word: the ramp gives the speed, follows its input, and has 6042h as its input."""
ALL: Final = ENABLE | UNLOCK | REFERENCE


class Velocity(SpeedMode):
    number = 2

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._bits = 0
        self._locked: float | None = None
        """The output at which the ramp is locked."""

    def control(self, word: int, rising: int) -> None:
        bits = word & ALL if self.context.behaviour.has_ramp_bits else ALL
        if bits == self._bits:
            return
        was_locked = self._locked is not None
        self._bits = bits
        is_locked = bits & (ENABLE | UNLOCK) == ENABLE
        if is_locked and not was_locked:
            self._locked = self.context.motion.speed if self._is_active else 0.0
        elif not is_locked:
            self._locked = None
        self._update()

    def begin(self) -> None:
        self._ask()
        super().begin()

    def writers(self) -> dict[tuple[int, int], Callable[[int], None]]:
        ramps = (objects.VL_ACCELERATION, objects.VL_DECELERATION, objects.VL_QUICK_STOP)
        factors = (objects.VL_AMOUNT, objects.VL_SET_POINT_FACTOR, objects.VL_DIMENSION_FACTOR)
        parameters = {(index, subindex): self._on_number for index in (*ramps, *factors) for subindex in (1, 2)}
        return {(objects.VL_TARGET, 0): self._on_number, **parameters}

    def _on_number(self, _number: int) -> None:
        self._update()

    def _update(self) -> None:
        self._ask()
        if self._is_active and not self.is_halted:
            self.run()

    def _ask(self) -> None:
        context = self.context
        if self._locked is not None:
            self._asked = self._locked
            return
        target = context.objects[objects.VL_TARGET] if self._bits == ALL else 0
        rpm = target * self._factor(objects.VL_SET_POINT_FACTOR) * self._factor(objects.VL_DIMENSION_FACTOR)
        low = context.objects.numbers[objects.VL_AMOUNT, 1]
        if rpm and abs(rpm) < low:
            rpm = low if rpm > 0 else -low
        self._asked = context.units.velocity_sign * context.of_rpm(rpm)

    def _factor(self, index: int) -> float:
        """Numerator by denominator; a 0 counts as 1."""
        numbers = self.context.objects.numbers
        return (numbers[index, 1] or 1) / (numbers[index, 2] or 1)

    def shown(self, speed: float) -> int:
        """A speed in increments per second, in the unit of 6042h."""
        context = self.context
        factor = self._factor(objects.VL_SET_POINT_FACTOR) * self._factor(objects.VL_DIMENSION_FACTOR)
        return round(context.units.velocity_sign * speed / context.of_rpm(1.0) / factor)

    def _rate(self, index: int) -> float:
        numbers = self.context.objects.numbers
        return max(self.context.of_rpm(numbers[index, 1]) / max(numbers[index, 2], 1), SMALLEST)

    def limits(self) -> Limits:
        context = self.context
        most = context.of_rpm(context.objects.numbers[objects.VL_AMOUNT, 2])
        stop = objects.VL_DECELERATION if self._bits & ENABLE else objects.VL_QUICK_STOP
        speed = max(min(most, context.largest_speed), SMALLEST)
        return Limits(speed, self._rate(objects.VL_ACCELERATION), self._rate(stop))

    def ramp_limits(self, ramp: Ramp) -> Limits:
        index = {Ramp.SLOW_DOWN: objects.VL_DECELERATION, Ramp.QUICK_STOP: objects.VL_QUICK_STOP}.get(ramp)
        if index is None:
            return super().ramp_limits(ramp)
        rate = self._rate(index)
        return Limits(self.context.largest_speed, rate, rate)

    @property
    def status(self) -> int:
        if self.is_halted:
            return self.halted_status
        motion = self.context.motion
        return TARGET_REACHED if motion.is_done and motion.speed == self._asked else 0
