"""Data of field bus modules in the object tree, and the IO map update that takes them there.

Source: PacDrive manual 3223 (digest PD-067, PD-307): the IO map is updated cyclically by the system, at the priority of
IEC tasks 4.  Between two updates nothing that a module sends is seen and nothing of what is written is sent; all of one
message changes at once.  How often it happens, and how data are named, is our choice.
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
from fieldrig_devices.max4.configuration.files import Symbol
from fieldrig_devices.max4.configuration.tree import Group, Kind, Object, Parameter, Type
from fieldrig_devices.max4.core import Controller

log = logging.getLogger(__name__)


class _Form(NamedTuple):
    iec: Type
    bits: int
    code: str = ""
    """Of `struct`; "" for a single bit."""
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
_LARGEST_F32: Final = 3.4028234663852886e38


class Element(Settings):
    """One value in a message."""

    name: Symbol = Field(description="of the parameter in the object tree")
    type: Literal["bool", "u8", "s8", "u16", "s16", "u32", "s32", "f32"] = Field(default="u16", description="its form")

    @property
    def form(self) -> _Form:
        return FORMS[self.type]

    @property
    def words(self) -> int:
        """Registers."""
        return (self.form.bits + 15) // 16


class Data:
    """The values of one message, as parameters of a group."""

    def __init__(self, group: Group, elements: Sequence[Element], *, is_output: bool) -> None:
        self._elements = elements
        kind = Kind.INPUT if is_output else Kind.OUTPUT
        self._parameters = [
            group.add(Parameter(one.name, one.form.iec, kind, low=one.form.low, high=one.form.high)) for one in elements
        ]

    def clear(self) -> None:
        for parameter in self._parameters:
            parameter.put(parameter.checked(0))

    def packed(self) -> bytes:
        """Bit by bit, the first value in the lowest bits: a PDO, or coils."""
        word = at = 0
        for form, parameter in self._each():
            raw = int.from_bytes(_raw("<", form, parameter.value), "little")
            word |= raw << at
            at += form.bits
        return word.to_bytes((at + 7) // 8, "little")

    def unpack(self, data: bytes) -> None:
        """The reverse; values of which not everything is there stay."""
        word, size, at = int.from_bytes(data, "little"), 8 * len(data), 0
        for form, parameter in self._each():
            if at + form.bits > size:
                return
            raw = word >> at & (1 << form.bits) - 1
            parameter.put(_value("<", form, raw.to_bytes((form.bits + 7) // 8, "little")))
            at += form.bits

    def registers(self) -> bytes:
        """One value in one or two registers, the high word first."""
        return b"".join(
            _raw(">", form, parameter.value).rjust((form.bits + 15) // 16 * 2, b"\x00")
            for form, parameter in self._each()
        )

    def unpack_registers(self, data: bytes) -> None:
        at = 0
        for form, parameter in self._each():
            end = at + (form.bits + 15) // 16 * 2
            if end > len(data):
                return
            parameter.put(_value(">", form, data[end - max(form.bits // 8, 1) : end]))
            at = end

    def _each(self) -> Iterable[tuple[_Form, Parameter]]:
        return ((one.form, parameter) for one, parameter in zip(self._elements, self._parameters, strict=True))


def _raw(order: str, form: _Form, value: Value) -> bytes:
    if not form.code:
        return bytes((bool(value),))
    if form.code == "f":
        value = min(max(float(value), -_LARGEST_F32), _LARGEST_F32)
    return struct.pack(order + form.code, value)


def _value(order: str, form: _Form, raw: bytes) -> Value:
    if not form.code:
        return any(raw)
    value: int | float = struct.unpack(order + form.code, raw)[0]
    if form.code != "f":
        return value
    return 0.0 if isnan(value) else min(max(value, -_LARGEST_F32), _LARGEST_F32)  # no parameter is infinite


class Part(Protocol):
    """One module's share of the IO map."""

    def take(self) -> None:
        """What has come in goes into the tree."""

    def give(self) -> None:
        """What has changed in the tree goes out."""


class IoMap:
    """`parts` are filled at each boot, by whoever has modules."""

    def __init__(self, controller: Controller, every_ms: int) -> None:
        self._controller, self._every_ns = controller, every_ms * MS
        self._passed_ns = 0
        self.parts: list[Part] = []
        controller.on_boot(self.parts.clear)
        controller.each_cycle(self._on_cycle)

    def _on_cycle(self) -> None:
        self._passed_ns += self._controller.cycle_ns
        if self._passed_ns < self._every_ns:
            return
        self._passed_ns = 0
        for part in self.parts:
            part.take()
        for part in self.parts:
            part.give()


def add_object(parent: Object, name: str, type_name: str, symbol: str) -> Object:
    """Without its symbolic name if an object of the configuration has got that since."""
    try:
        return parent.add(name, type_name, symbol)
    except ValueError as taken:
        log.warning("%s", taken)
        return parent.add(name, type_name, "")
