"""One tension regulator: the computation of the PID instruction in every control period.

Source: manual 5.8.1 and its list of the table; digest chapter 14, which supplies the algorithm, since the diagram is
lost.  The measured tension and speed are kept up to date while the regulator is in reset, for calibration; the other
diagnostic values are 0.  Anti-windup: the integrator ignores an error that would drive the filter further beyond MAXPID
or MINPID.  The interpretation `pid_ramp_start` determines where the reference begins its ramp.
"""

from typing import Final, NamedTuple

from fieldrig.clock import S
from fieldrig_devices.arp.card_errors import CardErrors
from fieldrig_devices.arp.fixed import LIMIT, OUT_OF_RANGE, SCALE, WRONG_PARAMETER
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.arp.signals.analog_inputs import AnalogInputs
from fieldrig_devices.arp.signals.analog_outputs import LIMIT_VOLT
from fieldrig_devices.arp.signals.axis_values import AxisValues

_SPEED_SOURCES: Final = (0, 1, 2)  # SWCVEL: none, axis 1, axis 2


class Table(NamedTuple):
    """The variables that the program supplies, in their order."""

    refpid: float
    sgloff: float
    deltar: float
    offref: float
    kmis: float
    offmis: float
    kff: float
    kerr: float
    maxerr: float
    maxpid: float
    minpid: float
    kreg: float
    kout: float
    maxdac: float
    mindac: float
    offdac: float
    swcvel: float
    kvel: float


class Gains(NamedTuple):
    """Gains @ParX[11] to [13] of the axis of the output."""

    kp: float
    ki: float
    kd: float


_GIVEN: Final = len(Table._fields)
SIZE: Final = _GIVEN + 7
"""Number of variables in the table, including the seven DG_... variables."""


def _clamp(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


class Regulator:
    def __init__(
        self,
        cell: int,
        first: int,
        variables: list[int],
        inputs: AnalogInputs,
        axes: AxisValues,
        errors: CardErrors,
        readings: Readings,
    ) -> None:
        self.cell, self.first = cell, first
        self._variables, self._inputs, self._axes, self._errors = variables, inputs, axes, errors
        self._starts_at_sgloff = readings.pid_ramp_start == "sgloff"
        self.gains = Gains(0.0, 0.0, 0.0)
        self.is_reset = True
        self._raw: list[int] = []
        self._table = Table(*(0.0,) * _GIVEN)
        self._speed_source = 0
        self._reference = 0  # in units of 1e-9 raw, so that the step of a period is a whole number
        self._sum = 0.0
        self._last_error: float | None = None
        self._read_table()

    def at_rest(self) -> float:
        """Voltage of the output while the regulator is off."""
        return _clamp(self._table.offdac, -LIMIT_VOLT, LIMIT_VOLT)

    def control(self, period_ns: int, *, is_started: bool) -> float:
        """Compute one period.  Returns the voltage of the output."""
        self._read_table()
        table = self._table
        measured = self._inputs.read(self.cell) / SCALE * table.kmis + table.offmis
        speed = self._axes.speed(self._speed_source) / SCALE * table.kvel if self._speed_source else 0.0
        self._advance(period_ns, is_started)
        reference = self._reference / (S * SCALE) + table.offref
        if self.is_reset:
            volts = self.at_rest()
            self._tell(measured, reference, 0.0, 0.0, 0.0, speed, volts)
            return volts
        error = _clamp((reference - measured) * table.kerr, -abs(table.maxerr), abs(table.maxerr))
        filtered = self._filter(error, period_ns / S)
        regulated = filtered * table.kreg + reference * table.kff + speed
        volts = _clamp(_clamp(regulated * table.kout, table.mindac, table.maxdac), -LIMIT_VOLT, LIMIT_VOLT)
        self._tell(measured, reference, error, filtered, regulated, speed, volts)
        return volts

    def _read_table(self) -> None:
        """Read the table, which the program may change at any time."""
        raw = self._variables[self.first : self.first + _GIVEN]
        if raw == self._raw:
            return
        self._raw = raw
        self._table = Table(*(value / SCALE for value in raw))
        self._speed_source = int(self._table.swcvel)
        if self._table.swcvel not in _SPEED_SOURCES:
            self._speed_source = 0
            self._errors.warn(WRONG_PARAMETER)

    def _advance(self, period_ns: int, is_started: bool) -> None:
        """Switch on and off, and advance the ramp of the reference."""
        refpid, sgloff, deltar = self._raw[:3]
        if self.is_reset:
            self._reference = sgloff * S if self._starts_at_sgloff else 0
            if not is_started:
                return
            self.is_reset = False
        target, step = (refpid if is_started else sgloff) * S, max(0, deltar) * period_ns
        self._reference = min(max(target, self._reference - step), self._reference + step)
        if self._reference == target and not is_started:
            self.is_reset = True
            self._sum, self._last_error = 0.0, None

    def _filter(self, error: float, period_s: float) -> float:
        kp, ki, kd = self.gains
        last, self._last_error = self._last_error, error
        slope = 0.0 if last is None else (error - last) / period_s
        total = self._sum + error * period_s
        value = kp * error + ki * total + kd * slope
        drives_beyond = value > self._table.maxpid if error > 0 else value < self._table.minpid
        if not drives_beyond:
            self._sum = total
        return _clamp(value, self._table.minpid, self._table.maxpid)

    def _tell(self, *values: float) -> None:
        """Write the diagnostic variables, in their order: DG_MIS, REF, ERR, PID, OUT, VEL, DAC."""
        raw = [round(value * SCALE) for value in values]
        if max(raw) > LIMIT or min(raw) < -LIMIT:
            raw = [max(-LIMIT, min(LIMIT, value)) for value in raw]
            self._errors.warn(OUT_OF_RANGE)
        first = self.first + _GIVEN
        self._variables[first : first + len(raw)] = raw
