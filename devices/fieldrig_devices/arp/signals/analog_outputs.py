"""The two analog outputs: their owners, the slopes of the DAC instruction, and diagnostic values.

Source: manual 3.1 (@Par[10] to [15]), 5.6.2; digest chapters 6.1 and 9.  An output belongs, in this order, to
diagnostics (its @Par[10] or [13] is not 0), to its axis if that is under position control, or to a PID instruction.
Otherwise it is free for DAC, which is ignored with W03 on an output that has an owner.  An owner cancels earlier DACs:
an output that has lost its owner is at 0 V until the next DAC.  The slope time is the time for a change of 10 V.
"""

from typing import Final, NamedTuple

from fieldrig.clock import MS
from fieldrig_devices.arp.card_errors import CardErrors
from fieldrig_devices.arp.fixed import SCALE, WRONG_PARAMETER
from fieldrig_devices.arp.parameters import GENERAL, Par, Parameters
from fieldrig_devices.arp.signals.axis_values import AxisValues

LIMIT_VOLT: Final = 10.0
_CHANNELS: Final = (1, 2)
_FIRST_OF_DIAGNOSTICS: Final = {1: Par.DIAGNOSTIC_1_SOURCE, 2: Par.DIAGNOSTIC_2_SOURCE}  # followed by gain and offset


class _Diagnostic(NamedTuple):
    axis: int
    code: int
    gain: float
    offset_volt: float


class _Free:
    """State of an output that DAC instructions drive."""

    def __init__(self) -> None:
        self.volts = self._from = self._to = 0.0
        self._since_ns = self._travel_ns = 0
        """Duration of the slope; 0 if the output does not move."""

    def aim(self, now_ns: int, volts: float, slope_ms: int) -> None:
        self._from, self._to, self._since_ns = self.volts, volts, now_ns
        self._travel_ns = round(abs(volts - self.volts) / LIMIT_VOLT * slope_ms * MS)
        if not self._travel_ns:
            self.volts = volts

    def move(self, now_ns: int) -> float:
        if self._travel_ns:
            passed_ns = now_ns - self._since_ns
            if passed_ns < self._travel_ns:
                self.volts = self._from + (self._to - self._from) * passed_ns / self._travel_ns
            else:
                self.volts, self._travel_ns = self._to, 0
        return self.volts

    def forget(self) -> None:
        self.volts, self._travel_ns = 0.0, 0


class AnalogOutputs:
    def __init__(self, parameters: Parameters, errors: CardErrors, axes: AxisValues) -> None:
        self._parameters, self._errors, self._axes = parameters, errors, axes
        self._version = -1
        self._diagnostics: list[_Diagnostic | None] = [None, None, None]
        self._regulated: list[float | None] = [None, None, None]
        self._free = [_Free(), _Free(), _Free()]
        self._volts = [0.0, 0.0, 0.0]
        self._now_ns = 0

    def write(self, channel: int, volt: int, slope_ms: int) -> None:
        """Execute DAC with raw volts.  Without a slope the output follows at once, else from the last `control` on."""
        if self._driven(channel) is not None:
            self._errors.warn(WRONG_PARAMETER)
            return
        self._free[channel].aim(self._now_ns, volt / SCALE, slope_ms)
        self._volts[channel] = self._free[channel].volts

    def regulate(self, channel: int, volts: float | None) -> None:
        """Set the voltage that a PID instruction drives, or None if no PID instruction drives this output."""
        self._regulated[channel] = volts

    def control(self, now_ns: int) -> None:
        """Update the outputs, once per control loop, after axes and regulators."""
        self._now_ns = now_ns
        for channel in _CHANNELS:
            volts = self._driven(channel)
            if volts is None:
                self._volts[channel] = self._free[channel].move(now_ns)
            else:
                self._free[channel].forget()
                self._volts[channel] = max(-LIMIT_VOLT, min(LIMIT_VOLT, volts))

    def release(self) -> None:
        """Set both outputs to 0 V (Enable low, blocked) until the next `control`, and cancel all DAC instructions."""
        for channel in _CHANNELS:
            self._free[channel].forget()
            self._volts[channel] = 0.0

    def volts(self, channel: int) -> float:
        return self._volts[channel]

    def _driven(self, channel: int) -> float | None:
        """Voltage that the owner of an output drives, or None if the output is free."""
        if self._version != self._parameters.version:
            self._refresh()
        diagnostic = self._diagnostics[channel]
        if diagnostic is not None:
            value = self._axes.diagnostic(diagnostic.axis, diagnostic.code)
            return value * diagnostic.gain + diagnostic.offset_volt
        volts = self._axes.volts(channel)
        return self._regulated[channel] if volts is None else volts

    def _refresh(self) -> None:
        self._version = self._parameters.version
        for channel, first in _FIRST_OF_DIAGNOSTICS.items():
            source, gain, offset = self._parameters.ram[GENERAL][first : first + 3]
            axis, code = divmod(source // SCALE, 10)
            diagnostic = _Diagnostic(axis + 1, code, gain / SCALE, offset / SCALE)
            self._diagnostics[channel] = diagnostic if code else None
