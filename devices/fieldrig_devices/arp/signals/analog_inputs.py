"""The six analog inputs: two load cells with range and filter, two of +-10 V, two of 0 to 10 V.

Source: manual 3.1 (@Par[2] to [4]), 5.6.1; digest chapters 6.1 and 9.  A load cell is read in microvolts.  Its
converter gives a value at the output rate of @Par[4], through a first-order low-pass that is at -3 dB at the manual's
frequency; every rate of its table is 25 times that frequency, so one coefficient serves all.  Every input saturates.

Left out: the stop frequencies of the table, which a first-order filter does not have; noise and resolution.
"""

import math
from typing import Final

from fieldrig.clock import S
from fieldrig_devices.arp.fixed import SCALE
from fieldrig_devices.arp.parameters import GENERAL, Par, Parameters

_LOAD_CELL_VOLT: Final = (0.0, 0.010, 0.020)  # @Par[2], [3]: none, +-10 mV, +-20 mV
_RAW_PER_LOAD_CELL_VOLT: Final = 1_000_000 * SCALE
_VOLT_SPANS: Final = {3: (-10.0, 10.0), 4: (-10.0, 10.0), 5: (0.0, 10.0), 6: (0.0, 10.0)}


def _kept_each_conversion() -> float:
    """Share of a deviation that is left after one conversion: 1 - a of y += a (x - y).

    It follows from |H|^2 = 1/2 at a 25th of the rate: a^2 + 2 c a - 2 c = 0 with c = 1 - cos(2 pi / 25).
    """
    c = 1 - math.cos(2 * math.pi / 25)
    return 1 + c - math.sqrt(c * c + 2 * c)


_KEPT: Final = _kept_each_conversion()


class _LoadCell:
    def __init__(self, channel: int, limit_volt: float) -> None:
        self.channel, self._limit_volt = channel, limit_volt
        self._filtered_volt: float | None = None

    def convert(self, volt: float, kept: float) -> int:
        """The raw value after conversions of `volt` that leave the share `kept` of an older deviation.

        The first conversion after power-on starts without a deviation.
        """
        volt = max(-self._limit_volt, min(self._limit_volt, volt))
        before = self._filtered_volt
        self._filtered_volt = volt if before is None else volt + (before - volt) * kept
        return round(self._filtered_volt * _RAW_PER_LOAD_CELL_VOLT)


class AnalogInputs:
    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._volts = [0.0] * 7
        self._raw = [0] * 7
        self._cells: list[_LoadCell] = []
        self._period_ns = S
        self._conversions = 0

    def start(self) -> None:
        """Read ranges and filter.  The card does so only at power-on."""
        table = self._parameters.ram[GENERAL]
        ranges = (table[Par.LOAD_CELL_1_RANGE], table[Par.LOAD_CELL_2_RANGE])
        limits = [_LOAD_CELL_VOLT[code // SCALE] for code in ranges]
        self._raw[1] = self._raw[2] = 0
        self._cells = [_LoadCell(channel, limit) for channel, limit in enumerate(limits, 1) if limit]
        self._period_ns = S * SCALE // table[Par.LOAD_CELL_FILTER_HZ]

    def take(self, channel: int, volt: float) -> None:
        """Take the new voltage of a wire."""
        self._volts[channel] = volt
        if channel in _VOLT_SPANS:
            low, high = _VOLT_SPANS[channel]
            self._raw[channel] = round(max(low, min(high, volt)) * SCALE)

    def control(self, now_ns: int) -> None:
        """Perform the conversions that are due, once per control loop, before the regulators."""
        conversions = now_ns // self._period_ns
        if conversions == self._conversions:
            return
        kept = _KEPT ** (conversions - self._conversions)
        self._conversions = conversions
        for cell in self._cells:
            self._raw[cell.channel] = cell.convert(self._volts[cell.channel], kept)

    def read(self, channel: int) -> int:
        """Value of ADC 1 to 6, in the scale that programs use."""
        return self._raw[channel]
