"""The sensors of an ST1 besides its own resolver: a second one, an encoder, analog input, temperature and supply."""

from math import floor, isnan, tau
from typing import Final

from fieldrig.clock import Clock
from fieldrig_bus.wires import Signal
from fieldrig_devices.st1.registers import COUNT

FULL_SCALE_V: Final = 10.0
LARGEST: Final = 1e12
"""Limit for the value of a wire."""
TO_COUNTS: Final = {"rad": COUNT / tau, "turn": float(COUNT)}
"""Factors to counts of a resolver by unit; the others are counts already."""
TEMPERATURE_UNITS: Final = 16
"""Units of DAP_TEMP for one degree (2153-2160)."""


def limited(value: float) -> float:
    return 0.0 if isnan(value) else min(max(value, -LARGEST), LARGEST)


class Sensors:
    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self.second = self.incremental = Signal("", 0.0)
        self.analog_v = 0.0
        self.temperature_degc = 20.0
        self.supply_v = 320.0

    @property
    def second_counts(self) -> int:
        """The second resolver, 65536 counts a turn."""
        return self._counts(self.second)

    @property
    def incremental_counts(self) -> int:
        """The incremental encoder, in its own counts if the wire has no unit of an angle."""
        return self._counts(self.incremental)

    @property
    def analog(self) -> int:
        """The analog input: 32767 at 10 V."""
        volts = min(max(self.analog_v, -FULL_SCALE_V), FULL_SCALE_V)
        return round(volts / FULL_SCALE_V * 0x7FFF)

    @property
    def temperature(self) -> int:
        return round(self.temperature_degc * TEMPERATURE_UNITS)

    def _counts(self, signal: Signal) -> int:
        value = float(signal.at(self._clock.now_ns()))
        return floor(limited(value) * TO_COUNTS.get(signal.unit, 1.0))
