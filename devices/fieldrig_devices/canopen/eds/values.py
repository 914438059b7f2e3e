"""Values in EDS and DCF files: converts their text to bytes.

Source: CiA 306-1 4.2 and 4.6.3.  Known notations of other tools beyond the standard are understood, but reported.
"""

import re
import struct

from fieldrig_devices.canopen.datatypes import Boolean, DataType, Integer, Octets, Real, VisibleString
from fieldrig_devices.canopen.eds.source import evaluate, parse_number

HEX_BY_H = re.compile(r"[0-9a-f]+h", re.IGNORECASE)
WHOLE = re.compile(r"([+-]?\d+)\.0*")
HEX = re.compile(r"0x([0-9a-f]+)", re.IGNORECASE)
SIGNED_HEX = re.compile(r"-0x[0-9a-f]+", re.IGNORECASE)
BETWEEN_OCTETS = re.compile(r"[\s,:{}\-]+|0x", re.IGNORECASE)
TRUTHS = {"true": 1, "false": 0, "yes": 1, "no": 0}

Reading = tuple[bytes, str]
"""The bytes of a value, and the remedy for its notation, or "" if it is right."""


def read_value(data_type: DataType, text: str, node_id: int) -> Reading:
    """Convert a text.  Raises ValueError, with what was expected, if it isn't a value of the data type."""
    if isinstance(data_type, Integer | Boolean):
        return _integer(data_type, text, node_id)
    if isinstance(data_type, Real):
        return _real(data_type, text)
    if isinstance(data_type, Octets):
        return _octets(text)
    strange = (
        [character for character in text if not character.isascii()] if isinstance(data_type, VisibleString) else []
    )
    return data_type.encode(
        text
    ), f"expected ASCII characters only, as CiA 301 defines {data_type.name}" if strange else ""


def _integer(data_type: Integer | Boolean, text: str, node_id: int) -> Reading:
    number, remedy = _number(text, node_id)
    low, high, bits = data_type.low, data_type.high, data_type.bits
    is_pattern = HEX.fullmatch(text) is not None
    if isinstance(data_type, Integer) and data_type.is_signed and is_pattern and high < number < 1 << bits:
        number -= 1 << bits  # two's complement
    elif isinstance(data_type, Integer) and not low <= number <= high:
        same = number & (1 << bits) - 1
        is_longer = (
            is_pattern and data_type.is_signed and same >> bits - 1 == 1 and number | _ones(same) == _ones(number)
        )
        if is_longer or (not data_type.is_signed and -(1 << bits - 1) <= number < 0):
            number = same - (1 << bits if data_type.is_signed else 0)
            remedy = f"expected 0x{same:0{bits // 4}X}, the same value in {bits} bits"
    if not low <= number <= high:
        raise ValueError(f"expected {low} to {high}, the range of {data_type.name}")
    return data_type.encode(number), remedy


def _ones(number: int) -> int:
    """Return a mask of all bits in the bytes that a number occupies."""
    return (1 << (number.bit_length() + 7) // 8 * 8) - 1


def _number(text: str, node_id: int) -> tuple[int, str]:
    try:
        number = evaluate(text, node_id)
        return number, f"expected {number}: hexadecimal numbers have no sign" if SIGNED_HEX.fullmatch(text) else ""
    except ValueError as cause:
        if HEX_BY_H.fullmatch(text):
            digits = text[:-1].upper()
            return int(digits, 16), f"expected 0x{digits}: hexadecimal numbers start with 0x"
        if text.lstrip("+-").isdigit() and text.isascii():
            return int(text), f"expected {int(text)}: a leading 0 makes a number octal"
        if match := WHOLE.fullmatch(text):
            return int(match[1]), f"expected {match[1]}, a whole number"
        if text.lower() in TRUTHS:
            return TRUTHS[text.lower()], f"expected {TRUTHS[text.lower()]}"
        raise ValueError("expected a number, such as 10 or 0x0A, or one with $NODEID, such as $NODEID+0x180") from cause


def _real(data_type: Real, text: str) -> Reading:
    """Convert a decimal number, or the bit pattern of IEEE 754 in hex."""
    expected = f"expected a decimal number for {data_type.name}, such as 0.5, or its bit pattern in hex, such as 0x"
    expected += "3F000000" if data_type.bits == 32 else "3FE0000000000000"
    if match := HEX.fullmatch(text):
        if len(match[1]) > data_type.size * 2:
            raise ValueError(expected)
        return int(match[1], 16).to_bytes(data_type.size, "little"), ""
    dotted = text.replace(",", ".") if text.count(",") == 1 and "." not in text else ""
    try:
        if "_" in text:
            raise ValueError(text)
        return data_type.encode(float(dotted or text)), f"expected {dotted}" if dotted else ""
    except (ValueError, struct.error) as cause:
        raise ValueError(expected) from cause


def _octets(text: str) -> Reading:
    """Convert hex digits, with or without separators between the octets."""
    digits = BETWEEN_OCTETS.sub("", text)
    try:
        return bytes.fromhex(digits), ""
    except ValueError as cause:
        if len(digits) % 2 == 1:
            try:
                return bytes.fromhex(f"0{digits}"), f"expected two hex digits for each octet, 0{digits}"
            except ValueError:
                pass
        raise ValueError("expected two hex digits for each octet, such as 01AF") from cause


def is_one(text: str) -> bool:
    """True if a flag is set, in any notation."""
    try:
        return parse_number(text) != 0
    except ValueError:
        return text.lower() in ("true", "yes")
