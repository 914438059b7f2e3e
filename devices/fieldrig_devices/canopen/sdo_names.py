"""SDO messages by name: object and value of the request and of its answer.

Source: CiA 301 version 4.2, 7.2.4.3 (command specifiers and their bits) and table 22 (abort codes).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.canopen.abort import NAMES
from fieldrig_devices.canopen.datatypes import Integer
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.variable import Variable
from fieldrig_devices.drive_profile.words import meaning_of

REQUESTS: Final = {
    0: "SDO write segment", 1: "SDO write", 2: "SDO read", 3: "SDO read segment", 4: "SDO abort",
    5: "SDO block read", 6: "SDO block write",
}  # fmt: skip
ANSWERS: Final = {
    0: "SDO segment", 1: "SDO segment written", 2: "SDO value", 3: "SDO written", 4: "SDO abort",
    5: "SDO block write answer", 6: "SDO block read answer",
}  # fmt: skip
WRITE, ABORT, VALUE, WRITTEN = 1, 4, 2, 3
WITH_OBJECT: Final = (frozenset({1, 2, 4}), frozenset({2, 3, 4}))
"""Command specifiers of requests and of answers that name an object."""
LENGTH: Final = 8

OnNumber = Callable[[int, int, int, int], None]
"""Called with node-ID, index, sub-index and number when a node has accepted a number, or answered with it."""


@dataclass(frozen=True, slots=True)
class _Write:
    index: int
    subindex: int
    data: bytes


class SdoNames:
    """Names the messages of the default SDO channels of a bus."""

    def __init__(self, dictionaries: Mapping[int, Dictionary], on_number: OnNumber) -> None:
        self._dictionaries, self._on_number = dictionaries, on_number
        self._writes: dict[int, _Write] = {}
        """The expedited download that each node has not answered yet."""

    def named(self, node_id: int, data: bytes, *, is_request: bool) -> tuple[str, str]:
        """Return the service and what it says."""
        if len(data) != LENGTH:
            return "SDO", f"{data.hex(' ').upper()} (expected eight bytes)"
        specifier = data[0] >> 5
        kind = (REQUESTS if is_request else ANSWERS).get(specifier, "SDO")
        if specifier not in WITH_OBJECT[0 if is_request else 1]:
            return kind, data.hex(" ").upper()
        index, subindex = int.from_bytes(data[1:3], "little"), data[3]
        name = self._name_of(node_id, index, subindex)
        if specifier == ABORT:
            self._writes.pop(node_id, None)
            code = int.from_bytes(data[4:], "little")
            words = NAMES.get(code, "unknown code").lower().replace("_", " ")
            return kind, f"{name}: {code >> 16:04X} {code & 0xFFFF:04X}h {words}"
        if specifier == (WRITE if is_request else VALUE):
            return kind, f"{name} = {self._value(node_id, index, subindex, data, is_request)}"
        if specifier == WRITTEN and not is_request:
            self._note(node_id, index, subindex)
        return kind, name

    def _value(self, node_id: int, index: int, subindex: int, data: bytes, is_request: bool) -> str:
        payload = expedited(data)
        if payload is None:
            return f"{int.from_bytes(data[4:], 'little')} bytes in segments" if data[0] & 1 else "in segments"
        if is_request:
            self._writes[node_id] = _Write(index, subindex, payload)
        else:
            self._on_number(node_id, index, subindex, int.from_bytes(payload, "little"))
        return value_words(self._dictionaries.get(node_id), index, subindex, payload)

    def _note(self, node_id: int, index: int, subindex: int) -> None:
        write = self._writes.pop(node_id, None)
        if write is not None and (write.index, write.subindex) == (index, subindex):
            self._on_number(node_id, index, subindex, int.from_bytes(write.data, "little"))

    def _name_of(self, node_id: int, index: int, subindex: int) -> str:
        return object_words(self._dictionaries.get(node_id), index, subindex)


def expedited(data: bytes) -> bytes | None:
    """Return the data that an initiate message itself has; None if they come in segments."""
    if not data[0] & 2:
        return None
    unused = data[0] >> 2 & 3 if data[0] & 1 else 0
    return data[4 : 8 - unused]


def object_words(dictionary: Dictionary | None, index: int, subindex: int) -> str:
    """Return `6041:00 Statusword`, or only the numbers of an object without a name."""
    variable = None if dictionary is None else dictionary.get(index, subindex)
    return f"{index:04X}:{subindex:02X}{'' if variable is None else f' {variable.name}'}"


def value_words(dictionary: Dictionary | None, index: int, subindex: int, data: bytes) -> str:
    """Return the value by the type of the object, or as bytes if the type is not known or does not fit."""
    return typed_words(None if dictionary is None else dictionary.get(index, subindex), data)


def typed_words(variable: Variable | None, data: bytes) -> str:
    """Return the value of a variable, or its bytes if the type is not known or does not fit."""
    if variable is None or variable.type.size not in (None, len(data)):
        return raw_words(data)
    value = variable.type.decode(data)
    if not isinstance(variable.type, Integer) or isinstance(value, str):
        return str(value)
    return _numbers(variable)(int(value))


def number_words(variable: Variable | None, length: int) -> Callable[[int], str] | None:
    """Return what `typed_words` is for a whole number of `length` bits, as a function of the bits; None for others.

    Logs are full of such numbers, and this takes a third of the time.
    """
    if variable is None or type(variable.type) is not Integer or variable.type.bits != length:
        return None
    words = _numbers(variable)
    if not variable.type.is_signed:
        return words
    sign, above = 1 << length - 1, 1 << length
    return lambda number: words(number - above if number & sign else number)


def _numbers(variable: Variable) -> Callable[[int], str]:
    """Return what says a number of an object: `4663 (1237h, operation enabled)`."""
    is_signed = isinstance(variable.type, Integer) and variable.type.is_signed
    meaning = meaning_of(variable.index, variable.name)
    if meaning is None:
        return str if is_signed else _unsigned_words
    said = meaning

    def words(number: int) -> str:
        notes = [f"{number:X}h"] if number > 9 and not is_signed else []
        notes += [meant] if (meant := said(number)) else []
        return f"{number} ({', '.join(notes)})" if notes else str(number)

    return words


def _unsigned_words(number: int) -> str:
    return f"{number} ({number:X}h)" if number > 9 else str(number)


def raw_words(data: bytes) -> str:
    """Return bytes whose type is not known, with the number that they are if they are the size of one."""
    number = f" ({int.from_bytes(data, 'little')})" if len(data) in (1, 2, 4) else ""
    return f"{data.hex(' ').upper()}{number}"
