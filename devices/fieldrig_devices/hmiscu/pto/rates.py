"""Rates of the ramps from the pins, and the frequency of the first and the last period (digest 9.1 and 9.2).

A rate that a calculation finds below 1000 Hz/s is raised to it, and what follows uses the raised one (SCU-089).
"""

from fractions import Fraction
from math import isqrt
from typing import Literal

from fieldrig_bus.signals.parabola import Exact
from fieldrig_devices.hmiscu.pto.settings import LOWEST_RATE_HZ_PER_S

RampUnit = Literal["ms", "Hz/ms"]


def rate(unit: RampUnit, pin: int, from_hz: Exact, to_hz: Exact) -> Fraction:
    """Return the rate in Hz/s of a ramp between two frequencies, from a pin or a configured value.

    The pin is the time of the whole ramp in ms, or its rate in Hz/ms (SCU-085 to SCU-088, SCU-091).
    """
    difference = Fraction(to_hz) - from_hz
    hz_per_ms = Fraction(pin) if unit == "Hz/ms" else abs(difference) / pin
    return max(1000 * hz_per_ms, Fraction(LOWEST_RATE_HZ_PER_S))


def end_frequency(configured_hz: int, rate_hz_per_s: Exact) -> int:
    """Return the frequency of the first or last period: as configured, or for 0 sqrt(rate / 2), to the nearest Hz.

    From rest the first pulse takes sqrt(2 / rate), so this is the mean frequency of that period (SCU-020, SCU-021).
    """
    if configured_hz:
        return configured_hz
    return (isqrt(2 * rate_hz_per_s.numerator // rate_hz_per_s.denominator) + 1) // 2
