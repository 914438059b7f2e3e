"""The PID instruction: one regulator for each analog output, with its flags.

Source: manual 5.8; digest chapter 14.  The instruction is executed if the axis of its output is of kind 3, and ends
when the axis changes its kind.  Its flags are those of the axis of the output: F271 to F274, F303 to F306.  Executed
again with the same numbers, it changes nothing; with other numbers, the new regulator replaces the old one.  The stop
flag ends it and is cleared.
"""

from typing import Final, NamedTuple

from fieldrig_devices.arp.card_errors import CardErrors
from fieldrig_devices.arp.fixed import SCALE
from fieldrig_devices.arp.parameters import Kind, Parameters, ParX
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.arp.signals.analog_inputs import AnalogInputs
from fieldrig_devices.arp.signals.analog_outputs import AnalogOutputs
from fieldrig_devices.arp.signals.axis_values import AxisValues
from fieldrig_devices.arp.signals.regulator import Gains, Regulator


class _Flags(NamedTuple):
    start: int
    stop: int
    reset: int
    present: int


_FLAGS: Final = {1: _Flags(271, 272, 273, 274), 2: _Flags(303, 304, 305, 306)}  # by output


class Regulators:
    def __init__(
        self,
        parameters: Parameters,
        variables: list[int],
        flags: list[int],
        errors: CardErrors,
        inputs: AnalogInputs,
        outputs: AnalogOutputs,
        axes: AxisValues,
        readings: Readings,
    ) -> None:
        self._parameters, self._variables, self._flags, self._errors = parameters, variables, flags, errors
        self._inputs, self._outputs, self._axes, self._readings = inputs, outputs, axes, readings
        self._present: dict[int, Regulator] = {}
        self._version = -1
        self._now_ns = 0

    def regulate(self, cell: int, output: int, first: int) -> None:
        """Execute PID with 25 variables from V`first`."""
        if not self._is_of_kind_3(output):
            return
        present = self._present.get(output)
        if present is not None and (present.cell, present.first) == (cell, first):
            return
        regulator = Regulator(cell, first, self._variables, self._inputs, self._axes, self._errors, self._readings)
        regulator.gains = self._gains(output)
        self._present[output] = regulator
        flags = _FLAGS[output]
        self._flags[flags.present], self._flags[flags.reset] = 1, 1 - self._flags[flags.start]
        self._outputs.regulate(output, regulator.at_rest())

    def reset(self) -> None:
        for output in tuple(self._present):
            self._end(output)

    def control(self, now_ns: int) -> None:
        """Run the regulators, once per control loop, after inputs and axes, before the outputs."""
        period_ns, self._now_ns = now_ns - self._now_ns, now_ns
        if not self._present or period_ns <= 0:
            return
        if self._version != self._parameters.version:
            self._refresh()
        for output, regulator in tuple(self._present.items()):
            flags = _FLAGS[output]
            if self._flags[flags.stop]:
                self._flags[flags.stop] = 0
                self._end(output)
                continue
            self._outputs.regulate(output, regulator.control(period_ns, is_started=bool(self._flags[flags.start])))
            self._flags[flags.reset] = int(regulator.is_reset)

    def _end(self, output: int) -> None:
        del self._present[output]
        flags = _FLAGS[output]
        self._flags[flags.present] = self._flags[flags.reset] = 0
        self._outputs.regulate(output, None)

    def _refresh(self) -> None:
        self._version = self._parameters.version
        for output, regulator in tuple(self._present.items()):
            regulator.gains = self._gains(output)
            if not self._is_of_kind_3(output):
                self._end(output)

    def _is_of_kind_3(self, axis: int) -> bool:
        return self._parameters.ram[axis][ParX.KIND] == Kind.PID * SCALE

    def _gains(self, axis: int) -> Gains:
        kp, ki, kd = self._parameters.ram[axis][ParX.KP : ParX.KD + 1]
        return Gains(kp / SCALE, ki / SCALE, kd / SCALE)
