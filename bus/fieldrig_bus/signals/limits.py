"""The limits of a pulse train and of a PWM signal, for what a device sends and for bytes from outside."""

from fractions import Fraction
from typing import Any, Final

from fieldrig_bus.signals import pwm
from fieldrig_bus.signals.parabola import Exact
from fieldrig_bus.signals.pulse_train import FASTEST_HZ, STEEPEST_HZ_PER_S, PulseTrain

_WIDEST: Final = (1 << 63) - 1


def check_pulse_train(train: PulseTrain) -> None:
    """Raise TypeError or ValueError for a segment that no sender may publish."""
    _check_whole("value", train.value, -_WIDEST, _WIDEST)
    _check_whole("start_ns", train.start_ns, -_WIDEST, _WIDEST)
    _check_whole("epoch_ns", train.epoch_ns, -_WIDEST, _WIDEST)
    _check_exact("frequency", train.frequency, 0, FASTEST_HZ)
    _check_exact("rate", train.rate, -STEEPEST_HZ_PER_S, STEEPEST_HZ_PER_S)
    _check_exact("phase", train.phase, 0, 1)
    if train.count is not None:
        _check_whole("count", train.count, 0, _WIDEST)
    _check_whole("sent", train.sent, 0, _WIDEST)
    _check_whole("direction", train.direction, -1, 1)
    if train.direction == 0:
        raise ValueError("direction 0: expected 1 or -1")
    if train.phase == 1:
        raise ValueError("phase 1: expected less than a period")
    if abs(train.value) > train.sent or (train.sent - train.value) % 2:
        raise ValueError(f"value {train.value} and sent {train.sent}: no pulses in two directions add up to these")
    _check_course(train)


def _check_course(train: PulseTrain) -> None:
    """Refuse a train that does not get as far as it says, or gets too fast."""
    if train.count is None:
        if train.rate or not train.frequency:
            raise ValueError("count: expected a number for a train that changes its frequency, or has none")
    elif train.count:
        begins = train.count - (0 if train.phase else 1) - train.phase
        square = Fraction(train.frequency) ** 2 + 2 * train.rate * begins
        if square < 0 or (square == 0 and (begins or not train.rate > 0)):
            raise ValueError(f"count {train.count}: the frequency is zero before the last pulse begins")
        if square + 2 * max(train.rate, 0) > FASTEST_HZ**2:
            raise ValueError(f"rate {train.rate}: the frequency grows above {FASTEST_HZ} Hz")


def check_pwm(signal: pwm.Pwm) -> None:
    """Raise TypeError or ValueError for a PWM signal that is not possible."""
    if isinstance(signal.value, bool):
        raise TypeError("value: expected a number, found bool")
    if not 0 <= signal.value <= 100:
        raise ValueError(f"value {signal.value}: expected a duty of 0 to 100 %")
    _check_whole("start_ns", signal.start_ns, -_WIDEST, _WIDEST)
    _check_exact("frequency", signal.frequency, 0, pwm.FASTEST_HZ)
    if not signal.frequency:
        raise ValueError("frequency 0: expected more; an output at rest has a duty of 0 %")


def _check_whole(what: str, value: Any, low: float, high: float) -> None:
    if type(value) is not int:
        raise TypeError(f"{what}: expected int, found {type(value).__name__}")
    if not low <= value <= high:
        raise ValueError(f"{what}: expected an integer from {low} to {high}")


def _check_exact(what: str, value: Exact, low: float, high: float) -> None:
    if type(value) is not int and type(value) is not Fraction:
        raise TypeError(f"{what}: expected int or Fraction, found {type(value).__name__}")
    if not low <= value <= high:
        raise ValueError(f"{what} {value}: expected {low} to {high}")
    if max(abs(value.numerator), value.denominator) > _WIDEST:
        raise ValueError(f"{what} {value}: expected a numerator and a denominator of 64 bits")
