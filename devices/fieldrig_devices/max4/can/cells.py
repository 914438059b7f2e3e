"""The manufacturer-specific objects of the CAN face: diagnosis, messages, parameters, and the service channel.

Source: ours (docs/devices/pacdrive/cia402.md).  A wrong command is answered with an SDO abort; the refusal of a drive
appears in the window of its service channel, because the channel is slow (digest PD-028).
"""

import struct
from collections.abc import Callable
from typing import Final

from fieldrig.device import Value
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.live import show_number, show_text
from fieldrig_devices.canopen.variable import Variable
from fieldrig_devices.max4.can.motor import AxisMotor
from fieldrig_devices.max4.can.objects import AXIS, CONTROLLER, MESSAGE, PARAMETER, SERVICE
from fieldrig_devices.max4.configuration.tree import Access, Parameter, Type
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.sercos.idn import Element, ServiceError

IDLE, BUSY, DONE, REFUSED = range(4)
READ, WRITE = 1, 2
ACCESS: Final = {access: number for number, access in enumerate(Access)}
_REAL: Final = struct.Struct("<d")


def connect(dictionary: Dictionary, controller: Controller) -> None:
    """Connect the objects of the controller, which every node has."""

    def at(index: int, subindex: int) -> Variable:
        return dictionary.find(index, subindex)

    show_number(at(CONTROLLER, 1), lambda: controller.diagnosis.code)
    show_text(at(CONTROLLER, 2), lambda: controller.diagnosis.ext)
    show_text(at(CONTROLLER, 3), lambda: controller.diagnosis.msg)
    _commands(at(CONTROLLER, 4), controller.quit_all)
    show_number(at(CONTROLLER, 5), lambda: int(controller.is_booted))
    show_text(at(MESSAGE, 2), lambda: _message(controller, at(MESSAGE, 1).number))
    show_number(at(MESSAGE, 3), lambda: len(controller.logger))
    ParameterWindow(dictionary, controller)


def connect_axis(dictionary: Dictionary, number: int, motor: AxisMotor) -> None:
    """Connect the objects of axis `number` of the node, counted from 0."""

    def at(subindex: int) -> Variable:
        return dictionary.find(AXIS + number, subindex)

    show_number(at(1), lambda: motor.axis.diag_code if motor.axis is not None else 0)
    show_text(at(2), lambda: motor.axis.diag_msg if motor.axis is not None else "")
    _commands(at(3), lambda: motor.axis.quit_errors() if motor.axis is not None else None)
    show_number(at(4), lambda: motor.axis.axis_state.value if motor.axis is not None else 0)
    show_number(at(5), lambda: motor.axis.mc4_state if motor.axis is not None else 0)
    show_text(at(6), lambda: motor.axis.name if motor.axis is not None else "")
    show_number(at(7), lambda: motor.axis.log_adr if motor.axis is not None else 0)
    show_number(at(8), lambda: motor.axis.ring_address if motor.axis is not None else 0)
    ServiceWindow(dictionary, number, motor)


class ParameterWindow:
    """A window that shows one parameter at a time, by logical address or path."""

    def __init__(self, dictionary: Dictionary, controller: Controller) -> None:
        self._controller = controller
        self._address = dictionary.find(PARAMETER, 1)
        self._address.writer = self._on_address
        path = dictionary.find(PARAMETER, 2)
        path.writer = self._on_path
        show_text(path, self._path)
        show_number(dictionary.find(PARAMETER, 3), lambda: self._parameter().type.number)
        number, text = dictionary.find(PARAMETER, 4), dictionary.find(PARAMETER, 5)
        number.reader = self._read_number
        number.writer = lambda data: self._write(float(_REAL.unpack(data)[0]))
        show_text(text, lambda: _shown(self._parameter().value))
        text.writer = lambda data: self._write_text(data.decode("latin-1"))
        show_number(dictionary.find(PARAMETER, 6), lambda: ACCESS[self._parameter().access])

    def _parameter(self) -> Parameter:
        parameter = self._controller.tree.parameter_at(self._address.number)
        if parameter is None:
            raise Abort(Code.NO_DATA)
        return parameter

    def _path(self) -> str:
        wanted = self._parameter()
        return next(path for path, parameter in self._controller.tree.parameters() if parameter is wanted)

    def _on_address(self, data: bytes) -> None:
        if self._controller.tree.at(int.from_bytes(data, "little")) is None:
            raise Abort(Code.INVALID_VALUE)
        self._address.set(data)

    def _on_path(self, data: bytes) -> None:
        try:
            parameter = self._controller.tree.parameter(data.decode("latin-1"))
        except KeyError:
            raise Abort(Code.INVALID_VALUE) from None
        self._address.set(parameter.address.to_bytes(4, "little"))

    def _read_number(self) -> bytes:
        value = self._parameter().value
        if isinstance(value, str):
            raise Abort(Code.PARAMETER_INCOMPATIBLE)
        return _REAL.pack(value)

    def _write_text(self, text: str) -> None:
        if self._parameter().type is Type.STRING:
            self._write(text)
            return
        try:
            self._write(float(text))
        except ValueError:
            raise Abort(Code.INVALID_VALUE) from None

    def _write(self, value: Value) -> None:
        parameter = self._parameter()
        if not parameter.is_writable:
            raise Abort(Code.READ_ONLY)
        try:
            parameter.set(value)
        except ValueError:
            raise Abort(Code.INVALID_VALUE) from None


class ServiceWindow:
    """A window to the service channel of the drive: a request and its result."""

    def __init__(self, dictionary: Dictionary, number: int, motor: AxisMotor) -> None:
        self._motor = motor
        self._idn, self._element, order, self._state, self._error, self._data, shown = (
            dictionary.find(SERVICE + number, subindex) for subindex in range(1, 8)
        )
        order.writer = self._on_order
        show_number(shown, lambda: int.from_bytes(self._data.data[:4], "little", signed=True))
        self._orders = 0

    def _on_order(self, data: bytes) -> None:
        axis, order = self._motor.axis, data[0]
        if not order:
            return
        if axis is None or self._state.number == BUSY:
            raise Abort(Code.DEVICE_STATE)
        idn, element = self._idn.number, Element(self._element.number)
        if order == WRITE and element is not Element.DATA:
            raise Abort(Code.INVALID_VALUE)
        self._orders += 1
        mine = self._orders
        self._show(BUSY, 0)

        def done(outcome: bytes | ServiceError) -> None:
            if mine == self._orders:  # not a request from before a reset of the node
                self._on_done(order, outcome)

        if order == READ:
            axis.read(idn, done, element)
        else:
            axis.write(idn, self._data.data, done)

    def _on_done(self, order: int, outcome: bytes | ServiceError) -> None:
        if isinstance(outcome, ServiceError):
            self._show(REFUSED, outcome.code)
            return
        if order == READ:
            self._data.set(outcome)
        self._show(DONE, 0)

    def _show(self, state: int, error: int) -> None:
        self._error.set(error.to_bytes(2, "little"))
        self._state.set(bytes((state,)))


def _message(controller: Controller, number: int) -> str:
    lines = controller.logger.lines()
    if not 1 <= number <= len(lines):
        raise Abort(Code.NO_DATA)
    return lines[number - 1]


def _shown(value: Value) -> str:
    return str(int(value)) if isinstance(value, bool) else str(value)


def _commands(variable: Variable, act: Callable[[], None]) -> None:
    def write(data: bytes) -> None:
        if data != b"\x00":
            act()

    variable.writer = write
