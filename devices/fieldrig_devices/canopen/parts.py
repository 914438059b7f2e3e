"""The values of CANopen messages, one by one: objects by index, states, codes.

Source: CiA 301 version 4.2, 7.2.2 to 7.2.8.
"""

from collections.abc import Sequence
from typing import Final

from fieldrig.traces.parts import NO_BITS, Part
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.abort import NAMES
from fieldrig_devices.canopen.bit_names import ERROR_REGISTER, bits_of
from fieldrig_devices.canopen.datatypes import Integer
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.emcy_words import LENGTH, meaning_of
from fieldrig_devices.canopen.sdo_names import (
    ABORT,
    ANSWERS,
    REQUESTS,
    VALUE,
    WITH_OBJECT,
    WRITE,
    expedited,
    value_words,
)

EMCY_REST: Final = 3
"""The first byte of the manufacturer-specific field of an EMCY."""


def object_key(index: int, subindex: int) -> str:
    """Return `6041h`, or `1018h:01` for a sub-index."""
    return f"{index:04X}h:{subindex:02X}" if subindex else f"{index:04X}h"


def object_part(dictionary: Dictionary | None, index: int, subindex: int, data: bytes) -> Part:
    """Return the value of an object, by its type if an EDS describes it."""
    key = object_key(index, subindex)
    variable = None if dictionary is None else dictionary.get(index, subindex)
    if variable is None or variable.type.size not in (None, len(data)):
        return Part(key, "" if variable is None else variable.name, data.hex(" ").upper(), data.hex(" ").upper())
    value = variable.type.decode(data)
    bits = bits_of(variable) if isinstance(variable.type, Integer) else NO_BITS
    text = (
        f"{int.from_bytes(data, 'little'):0{2 * len(data)}X}h"
        if bits
        else value_words(dictionary, index, subindex, data)
    )
    return Part(key, variable.name, value, text, bits)


def emcy_parts(data: bytes, *, is_drive: bool = False) -> Sequence[Part]:
    """Return error code, error register and manufacturer-specific field."""
    if len(data) != LENGTH:
        return (raw_part(data),)
    code, register = int.from_bytes(data[:2], "little"), data[2]
    meaning = meaning_of(code, is_drive=is_drive)
    return (
        Part("error code", "", code, f"{code:04X}h {meaning}".strip()),
        Part("error register", "", register, f"{register:02X}h", ERROR_REGISTER),
        Part("manufacturer-specific field", "", data[EMCY_REST:].hex(), data[EMCY_REST:].hex(" ").upper()),
    )


def sdo_parts(dictionary: Dictionary | None, data: bytes, *, is_request: bool) -> Sequence[Part]:
    """Return the service of an SDO message, and the object with its value if the message has it."""
    if len(data) != LENGTH:
        return (raw_part(data),)
    specifier = data[0] >> 5
    kind = (REQUESTS if is_request else ANSWERS).get(specifier, "SDO")
    service = Part("service", "", kind, kind)
    if specifier not in WITH_OBJECT[0 if is_request else 1]:
        return service, raw_part(data)
    index, subindex = int.from_bytes(data[1:3], "little"), data[3]
    if specifier == ABORT:
        code = int.from_bytes(data[4:], "little")
        return service, Part(f"abort code of {object_key(index, subindex)}", "", code, abort_words(code))
    payload = expedited(data) if specifier == (WRITE if is_request else VALUE) else None
    if payload is not None:
        return service, object_part(dictionary, index, subindex, payload)
    key = object_key(index, subindex)
    return service, Part("object", "", key, key), raw_part(data[4:])


def abort_words(code: int) -> str:
    """Return `0602 0000h no object`."""
    words = NAMES.get(code, "unknown code").lower().replace("_", " ")
    return f"{code >> 16:04X} {code & 0xFFFF:04X}h {words}"


def raw_part(data: bytes) -> Part:
    """Return all bytes as one value, for a message whose content is not known."""
    return Part("data", "", data.hex(), data.hex(" ").upper() or "none")


def frame_parts(frame: CanFrame) -> Sequence[Part]:
    """Return the content of a frame that no object describes."""
    if frame.is_remote:
        return (Part("length", "", frame.remote_length, f"{frame.remote_length} bytes requested"),)
    return (raw_part(frame.data),)
