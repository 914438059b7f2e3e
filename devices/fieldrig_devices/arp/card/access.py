"""External access to a card: the implementation of `CardAccess` that its ports use."""

from collections.abc import Sequence
from typing import Final

from fieldrig_devices.arp.card.operation import Operation
from fieldrig_devices.arp.card.parts import Parts
from fieldrig_devices.arp.card.permanent import COUNT
from fieldrig_devices.arp.card.states import HELD
from fieldrig_devices.arp.card_access import CardState, Progress
from fieldrig_devices.arp.language.instructions import WRITABLE, numbers
from fieldrig_devices.arp.parameters import PARAMETERS
from fieldrig_devices.arp.runtime.program import ArpProgram

OUTPUTS: Final = numbers("O")
_LOW, _HIGH = -(2**31), 2**31 - 1


class Access:
    def __init__(self, parts: Parts, operation: Operation) -> None:
        self._parts, self._operation = parts, operation
        self.number = parts.number
        self.V, self.F, self.I, self.O = parts.V, parts.F, parts.I, parts.O
        self.parameters, self.errors = parts.parameters, parts.errors
        self.position, self.speed = parts.axes.position, parts.axes.speed
        self.tracking_error = parts.axes.tracking_error
        self.analog_input = parts.analog_inputs.read
        self.save_parameter, self.save_parameters = operation.save_parameter, operation.save_parameters
        self.saving = operation.saving
        self.run_program, self.stop_program = operation.run_program, operation.stop_program
        self.reset, self.load = operation.reset, operation.load

    @property
    def state(self) -> CardState:
        return self._operation.state

    @property
    def program(self) -> ArpProgram | None:
        return self._operation.program

    @property
    def program_name(self) -> str:
        return self._operation.program_name

    @property
    def program_object(self) -> bytes:
        return self._operation.program_object

    @property
    def loading(self) -> Progress | None:
        return self._operation.loading

    def analog_output(self, channel: int) -> int:
        return round(self._parts.analog_outputs.volts(channel) * 1_000)

    def set_variables(self, first: int, values: Sequence[int]) -> bool:
        """Write variables; they are permanent when this returns."""
        is_valid = 1 <= first <= COUNT + 1 - len(values) and all(_LOW <= value <= _HIGH for value in values)
        if is_valid:
            self.V[first : first + len(values)] = values
            self._parts.permanent.keep()
        return is_valid

    def set_flag(self, number: int, bit: int) -> bool:
        is_valid = number in WRITABLE and bit in (0, 1)
        if is_valid:
            self.F[number] = int(bit)
        return is_valid

    def set_output(self, number: int, bit: int) -> bool:
        is_valid = number in OUTPUTS and bit in (0, 1) and self.state not in HELD
        if is_valid:
            self.O[number] = int(bit)
        return is_valid

    def set_parameter(self, group: int, number: int, raw: int) -> bool:
        return group in range(len(PARAMETERS)) and self.parameters.set_ram(group, number, raw)
