"""Data of field bus modules in the object tree, and the IO map update that exchanges them.

Source: PacDrive manual 3223 (digest PD-067, PD-307): the system updates the IO map cyclically, at the priority of IEC
task 4.  Between two updates, received data are not visible and written data are not sent; the values of one message
change together.  The period and the names of the data are our choice.
"""

import logging
import struct
from collections.abc import Iterable, Sequence
from math import isnan
from typing import Final, Literal, NamedTuple, Protocol

from pydantic import Field

from fieldrig.clock import MS
from fieldrig.device import Value
from fieldrig.settings import Settings
from fieldrig_devices.iec.tasks.system_work import IO_MAP_PRIORITY
from fieldrig_devices.max4.configuration.files import Symbol
from fieldrig_devices.max4.configuration.tree import Group, Kind, Object, Parameter, Type
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.registers.form import LARGEST_F32

log = logging.getLogger(__name__)


class _Form(NamedTuple):
    iec: Type
    bits: int
    code: str = ""
    """Format character of `struct`, or an empty string for a single bit."""
    low: int | None = None
    high: int | None = None


FORMS: Final = {
    "bool": _Form(Type.BOOL, 1),
    "u8": _Form(Type.UINT, 8, "B", high=0xFF),
    "s8": _Form(Type.INT, 8, "b", low=-0x80, high=0x7F),
    "u16": _Form(Type.UINT, 16, "H"),
    "s16": _Form(Type.INT, 16, "h"),
    "u32": _Form(Type.UDINT, 32, "I"),
    "s32": _Form(Type.DINT, 32, "i"),
    "f32": _Form(Type.LREAL, 32, "f"),
}


class Element(Settings):
    """One value in a message."""

    name: Symbol = Field(description="name of the parameter in the object tree")
    type: Literal["bool", "u8", "s8", "u16", "s16", "u32", "s32", "f32"] = Field(
        default="u16", description="type in the message"
    )

    @property
    def form(self) -> _Form:
        return FORMS[self.type]

    @property
    def words(self) -> int:
        """Number of registers."""
        return (self.form.bits + 15) // 16


class Data:
    """The values of one message, as parameters of a group."""

    def __init__(self, group: Group, elements: Sequence[Element], *, is_output: bool) -> None:
        self._elements = elements
        kind = Kind.INPUT if is_output else Kind.OUTPUT
        self._parameters = [
            group.add(Parameter(element.name, element.form.iec, kind, low=element.form.low, high=element.form.high))
            for element in elements
        ]

    def clear(self) -> None:
        for parameter in self._parameters:
            parameter.put(parameter.checked(0))

    def packed(self) -> bytes:
        """The values packed bit by bit for a PDO or coils, the first value in the lowest bits."""
        word = at = 0
        for form, parameter in self._each():
            raw = int.from_bytes(_raw("<", form, parameter.value), "little")
            word |= raw << at
            at += form.bits
        return word.to_bytes((at + 7) // 8, "little")

    def unpack(self, data: bytes) -> None:
        """Take the values from packed bits; values that `data` does not contain completely keep theirs."""
        word, size, at = int.from_bytes(data, "little"), 8 * len(data), 0
        for form, parameter in self._each():
            if at + form.bits > size:
                return
            raw = word >> at & (1 << form.bits) - 1
            parameter.put(_value("<", form, raw.to_bytes((form.bits + 7) // 8, "little")))
            at += form.bits

    def registers(self) -> bytes:
        """The values in one or two registers each, the high word first."""
        return b"".join(
            _raw(">", form, parameter.value).rjust((form.bits + 15) // 16 * 2, b"\x00")
            for form, parameter in self._each()
        )

    def unpack_registers(self, data: bytes) -> None:
        """Take the values from registers; values that `data` does not contain completely keep theirs."""
        at = 0
        for form, parameter in self._each():
            end = at + (form.bits + 15) // 16 * 2
            if end > len(data):
                return
            parameter.put(_value(">", form, data[end - max(form.bits // 8, 1) : end]))
            at = end

    def _each(self) -> Iterable[tuple[_Form, Parameter]]:
        pairs = zip(self._elements, self._parameters, strict=True)
        return ((element.form, parameter) for element, parameter in pairs)


def _raw(order: str, form: _Form, value: Value) -> bytes:
    if not form.code:
        return bytes((bool(value),))
    if form.code == "f":
        value = min(max(float(value), -LARGEST_F32), LARGEST_F32)
    return struct.pack(order + form.code, value)


def _value(order: str, form: _Form, raw: bytes) -> Value:
    if not form.code:
        return any(raw)
    value: int | float = struct.unpack(order + form.code, raw)[0]
    if form.code != "f":
        return value
    return 0.0 if isnan(value) else min(max(value, -LARGEST_F32), LARGEST_F32)  # a parameter is never infinite


class Part(Protocol):
    """The part of the IO map that belongs to one module."""

    def take(self) -> None:
        """Put received data into the tree."""

    def give(self) -> None:
        """Send data that have changed in the tree."""


class IoMap:
    """The cyclic update; the faces add their modules to `parts` at each boot."""

    def __init__(self, controller: Controller, every_ms: int, duration_us: int) -> None:
        """An update takes `duration_us` of processor time from a program."""
        self._controller, self._every_ns, self._duration_us = controller, every_ms * MS, duration_us
        self._passed_ns = 0
        self._is_due = False
        self.parts: list[Part] = []
        controller.on_boot(self._begin)
        controller.each_cycle(self._on_cycle)

    def _on_cycle(self) -> None:
        self._passed_ns += self._controller.cycle_ns
        if self._passed_ns < self._every_ns:
            return
        self._passed_ns = 0
        if self.parts and not self._is_due:
            self._is_due = True
            self._controller.at_priority(IO_MAP_PRIORITY, self._duration_us, self._update)

    def _begin(self) -> None:
        self.parts.clear()
        self._is_due = False

    def _update(self) -> None:
        self._is_due = False
        for part in self.parts:
            part.take()
        for part in self.parts:
            part.give()


def add_object(parent: Object, name: str, type_name: str, symbol: str) -> Object:
    """Add an object, without its symbolic name if an object of the configuration has taken that name."""
    try:
        return parent.add(name, type_name, symbol)
    except ValueError as taken:
        log.warning("%s", taken)
        return parent.add(name, type_name, "")
