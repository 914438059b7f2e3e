"""The encoding of what a wire carries, as one JSON array, and its limits.

    ["tank.level", 1.5, "m"]                                     a signal: name, value, unit
    ["axis.encoder", 7, "count", 12, 1.5, 0.0]                   a motion: and instant in ns, speed, acceleration
    ["pto.pulse", "pulses", 0, "count", 0, 20000, 1, 0, 1, null, 1, 0, 1, 0, 0]
        a pulse train: name, kind, position, unit, start in ns, frequency, rate, count, direction, phase, total, epoch
    ["pwm.out", "pwm", 25, "%", 0, 10, 1]                        pulse-width modulation: duty, start in ns, frequency

Frequency, rate and phase are two numbers each, numerator and denominator.
"""

import json
from fractions import Fraction
from math import isfinite
from typing import Any, Final

from fieldrig.outside.untrusted import WIDEST, read_json
from fieldrig.points.values import show_number
from fieldrig_bus.signals.limits import check_pulse_train, check_pwm
from fieldrig_bus.signals.parabola import Exact
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.signals.signal import Motion, Signal

LONGEST_NAME: Final = 256
"""Longest name or unit, in characters."""
LONGEST_UNIT: Final = 32
LONGEST_SIGNAL: Final = 4096
"""Largest encoded signal, in bytes."""
_LATEST_NS = (1 << 63) - 1
_PULSES: Final = "pulses"
_PWM: Final = "pwm"


def encode(message: Signal) -> bytes:
    """A signal as JSON."""
    fields: list[Any] = [message.name, message.value, message.unit]
    match message:
        case Motion():
            fields += [message.time_ns, message.speed, message.acceleration]
        case PulseTrain():
            fields[1:1] = [_PULSES]
            fields += [message.start_ns, *_ratio(message.frequency), *_ratio(message.rate), message.count]
            fields += [message.direction, *_ratio(message.phase), message.sent, message.epoch_ns]
        case Pwm():
            fields[1:1] = [_PWM]
            fields += [message.start_ns, *_ratio(message.frequency)]
    return json.dumps(fields, separators=(",", ":"), allow_nan=False).encode()


def decode(data: bytes) -> Signal:
    """The inverse of `encode`.  ValueError for anything else."""
    signal = _read(read_json(data, LONGEST_SIGNAL, deepest=1))
    if signal is None:
        raise ValueError(f"not a signal: {data[:80]!r}")
    check_sent(signal)
    return signal


def check_sent(message: Any) -> None:
    """Raise TypeError or ValueError for a message that cannot be on a wire."""
    if not isinstance(message, Signal):
        raise TypeError(f"expected a Signal, found {type(message).__name__}")
    check_text("name", message.name, LONGEST_NAME)
    check_text("unit", message.unit, LONGEST_UNIT)
    value = message.value
    if type(value) is float:
        if not isfinite(value):
            raise ValueError(f"value {value}: expected a finite number")
    else:
        _check_number("value", value)
    match message:
        case Motion():
            _check_motion(message)
        case PulseTrain():
            check_pulse_train(message)
        case Pwm():
            check_pwm(message)


def check_text(what: str, text: Any, longest: int) -> None:
    """Raise TypeError or ValueError for what is not a text, or is longer than this."""
    if type(text) is not str:
        raise TypeError(f"{what}: expected str, found {type(text).__name__}")
    if len(text) > longest:
        raise ValueError(f"{what} of {len(text)} characters: expected at most {longest}")
    if not text.isascii():
        text.encode()  # ValueError for half of a surrogate pair, which is not text


def show(message: Signal) -> str:
    """A signal as one line, with all digits of its value."""
    text = f"{message.name} = {show_number(message.value)} {message.unit}".rstrip()
    match message:
        case Motion():
            text += f", {show_number(message.speed)} {message.unit}/s"
        case PulseTrain():
            text += f", {_decimal(message.frequency)} Hz" + (f", {_decimal(message.rate)} Hz/s" if message.rate else "")
            text += ", without end" if message.count is None else f", {message.count} pulses"
            text += " backwards" if message.direction < 0 else ""
        case Pwm():
            text += f", {_decimal(message.frequency)} Hz"
    return text


def _check_motion(motion: Motion) -> None:
    if isinstance(motion.value, bool):
        raise TypeError("value: expected a number, found bool: a digital signal does not move")
    _check_number("speed", motion.speed)
    _check_number("acceleration", motion.acceleration)
    if type(motion.time_ns) is not int:
        raise TypeError(f"time_ns: expected int, found {type(motion.time_ns).__name__}")
    if abs(motion.time_ns) > _LATEST_NS:
        raise ValueError(f"time_ns {motion.time_ns}: expected an instant of 64 bits")


def _check_number(what: str, value: Any) -> None:
    if not isinstance(value, bool | int | float):
        raise TypeError(f"{what}: expected bool, int or float, found {type(value).__name__}")
    if isinstance(value, float):
        if not isfinite(value):
            raise ValueError(f"{what} {value}: expected a finite number")
    elif not WIDEST[0] <= value <= WIDEST[1]:
        raise ValueError(f"{what}: expected an integer of 64 bits")


def _read(fields: Any) -> Signal | None:
    match fields:
        case [str(name), bool() | int() | float() as value, str(unit)]:
            return Signal(name, value, unit)
        case [str(name), int() | float() as value, str(unit), int(time_ns), int() | float() as speed, acceleration] if (
            isinstance(acceleration, int | float)
        ):
            return Motion(name, value, unit, time_ns, speed, acceleration)
        case [str(name), str(kind), int() | float() as value, str(unit), *rest] if kind == _PULSES and len(rest) == 11:
            start_ns, frequency, _, rate, _, count, direction, phase, _, sent, epoch_ns = rest
            frequency, rate, phase = (_exact(*rest[field : field + 2]) for field in (1, 3, 7))
            return PulseTrain(name, value, unit, start_ns, frequency, rate, count, direction, phase, sent, epoch_ns)
        case [str(name), str(kind), int() | float() as value, str(unit), start_ns, top, bottom] if kind == _PWM:
            return Pwm(name, value, unit, start_ns, _exact(top, bottom))
    return None


def _ratio(number: Exact) -> tuple[int, int]:
    return number.numerator, number.denominator


def _exact(top: Any, bottom: Any) -> Exact:
    """ValueError for anything but a numerator and a denominator above 0."""
    if type(top) is not int or type(bottom) is not int or bottom < 1:
        raise ValueError("expected a numerator and a denominator above 0")
    return top if bottom == 1 else Fraction(top, bottom)


def _decimal(number: Exact) -> str:
    return show_number(number if isinstance(number, int) else float(number))
