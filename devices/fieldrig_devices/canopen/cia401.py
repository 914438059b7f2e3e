"""CiA 401, generic I/O modules: polarity, filters and error values between the objects and the I/O terminals.

Source: CiA 401 version 3, chapters 6 and 7.  Supports 8-bit digital and 16-bit analog channels; `cia401_events` decides
which changes are events.  The input filter constant (6003h) has no effect because these inputs don't bounce.
"""

from collections.abc import Callable
from functools import partial

from fieldrig_devices.canopen.cia401_events import AnalogGate, DigitalGate
from fieldrig_devices.canopen.datatypes import INTEGER16, UNSIGNED8, DataType, Integer, Value, clamp
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.service import Reset, Service, State
from fieldrig_devices.canopen.terminals import Terminal
from fieldrig_devices.canopen.variable import Variable

# Indices; the sub-index is the channel or byte.
DIGITAL_INPUT, INPUT_POLARITY = 0x6000, 0x6002
DIGITAL_OUTPUT, OUTPUT_POLARITY, ERROR_MODE, ERROR_VALUE, FILTER_MASK = 0x6200, 0x6202, 0x6206, 0x6207, 0x6208
ANALOG_INPUT, ANALOG_OUTPUT = 0x6401, 0x6411
ANALOG_ERROR_MODE, ANALOG_ERROR_VALUE = 0x6443, 0x6444


class Cia401(Service):
    """The profile of a node whose device type (1000h) is CiA 401."""

    def __init__(self, dictionary: Dictionary) -> None:
        self.terminals: dict[Variable, Terminal] = {}
        self._inputs: list[DigitalInput] = []
        self._outputs: list[DigitalOutput | AnalogOutput] = []
        self._gates: list[DigitalGate | AnalogGate] = []
        self._is_fault = self._is_lost = False
        for variable in _members(dictionary, DIGITAL_INPUT, UNSIGNED8):
            self._inputs.append(DigitalInput(dictionary, variable))
            self.terminals[variable] = self._inputs[-1]
            self._gates.append(DigitalGate(dictionary, variable))
        for variable in _members(dictionary, ANALOG_INPUT, INTEGER16):
            self._gates.append(AnalogGate(dictionary, variable))
        for variable in _members(dictionary, DIGITAL_OUTPUT, UNSIGNED8):
            self._add_output(variable, DigitalOutput(dictionary, variable))
        for variable in _members(dictionary, ANALOG_OUTPUT, INTEGER16):
            self._add_output(variable, AnalogOutput(dictionary, variable))

    def _add_output(self, variable: Variable, output: "DigitalOutput | AnalogOutput") -> None:
        self.terminals[variable] = output
        self._outputs.append(output)

    def reset(self, scope: Reset) -> None:
        self._is_lost = False
        self._set_fault(False)  # outputs follow their objects, which a reset may have set to power-on values
        for digital_input in self._inputs:
            digital_input.reset()
        for gate in self._gates:
            gate.reset()

    def enter(self, state: State) -> None:
        """Set outputs to their error values in 'stopped'; let them follow their objects in 'operational' (6206h)."""
        if state is State.STOPPED:
            self._set_fault(True)
        elif state is State.OPERATIONAL:
            self._set_fault(self._is_lost)

    def on_communication_error(self, is_lost: bool) -> None:
        self._is_lost = is_lost
        self._set_fault(is_lost or self._is_fault)

    def _set_fault(self, is_fault: bool) -> None:
        self._is_fault = is_fault
        for output in self._outputs:
            output.set_fault(is_fault)


class DigitalInput:
    """One byte of inputs; 6002h inverts its bits."""

    def __init__(self, dictionary: Dictionary, variable: Variable) -> None:
        self._variable = variable
        self._polarity = dictionary.get(INPUT_POLARITY, variable.subindex)
        self._inverted = 0
        self.watchers: list[Callable[[], None]] = []
        if self._polarity is not None:
            self._inverted = self._polarity.number
            self._polarity.watchers.append(self.reset)

    @property
    def value(self) -> int:
        return self._variable.number ^ self._inverted

    def put(self, value: Value) -> None:
        self._variable.put(int(value) ^ self._inverted)

    def reset(self) -> None:
        """Apply the present polarity: the state of the terminal stays, and the object changes."""
        if self._polarity is not None:
            state, self._inverted = self.value, self._polarity.number
            self.put(state)


class DigitalOutput:
    """One byte of outputs; 6202h inverts its bits, 6208h holds them, and 6206h and 6207h define the error values."""

    def __init__(self, dictionary: Dictionary, variable: Variable) -> None:
        self._variable = variable
        self._number = partial(dictionary.number, subindex=variable.subindex)
        self._is_fault = False
        self._inverted, self._mask = 0, 0xFF
        self.value = 0
        self.watchers: list[Callable[[], None]] = []
        variable.watchers.append(self._update)
        for index in (OUTPUT_POLARITY, ERROR_MODE, ERROR_VALUE, FILTER_MASK):
            parameter = dictionary.get(index, variable.subindex)
            if parameter is not None:
                parameter.watchers.append(self._configure)

    def put(self, value: Value) -> None:
        """Write the object, not the terminal: for a signal that drives an output object (`direction: in`)."""
        self._variable.put(value)

    def set_fault(self, is_fault: bool) -> None:
        self._is_fault = is_fault
        self._configure()

    def _configure(self) -> None:
        if self._is_fault:
            self._mask = self._number(ERROR_MODE, default=0)
        else:
            self._inverted = self._number(OUTPUT_POLARITY, default=0)
            self._mask = self._number(FILTER_MASK, default=0xFF)
        self._update()

    def _update(self) -> None:
        data = self._variable.data
        wanted = self._number(ERROR_VALUE, default=0) if self._is_fault else data[0] ^ self._inverted
        value = self.value & ~self._mask | wanted & self._mask
        if value != self.value:
            self.value = value
            _notify(self.watchers)


class AnalogOutput:
    """One analog output; 6443h and 6444h define its error value."""

    def __init__(self, dictionary: Dictionary, variable: Variable) -> None:
        self._variable = variable
        self._mode = dictionary.get(ANALOG_ERROR_MODE, variable.subindex)
        self._error_value = dictionary.get(ANALOG_ERROR_VALUE, variable.subindex)
        self._is_fault = False
        self.value: Value = variable.value
        self.watchers: list[Callable[[], None]] = []
        for source in (variable, self._mode, self._error_value):
            if source is not None:
                source.watchers.append(self._update)

    def put(self, value: Value) -> None:
        """Write the object, not the terminal: for a signal that drives an output object (`direction: in`)."""
        self._variable.put(value)

    def set_fault(self, is_fault: bool) -> None:
        self._is_fault = is_fault
        self._update()

    def _update(self) -> None:
        value = self._wanted()
        if value != self.value:
            self.value = value
            _notify(self.watchers)

    def _wanted(self) -> Value:
        if not self._is_fault:
            return self._variable.value
        if self._mode is None or self._mode.number == 0:
            return self.value
        error_value = 0 if self._error_value is None else self._error_value.value
        if isinstance(error_value, str):
            return self.value
        limited = clamp(error_value, self._variable.type.low, self._variable.type.high)
        return int(limited) if isinstance(self._variable.type, Integer) else limited


def _members(dictionary: Dictionary, index: int, data_type: DataType) -> list[Variable]:
    """Return the channels of an object that have the data type of the profile."""
    return [variable for variable in dictionary.members(index) if variable.type is data_type]


def _notify(watchers: list[Callable[[], None]]) -> None:
    for watcher in watchers:
        watcher()
