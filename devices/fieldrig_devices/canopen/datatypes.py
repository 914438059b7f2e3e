"""Data types of object dictionary variables: the encoding and the range of their values.

Source: CiA 301 table 44 and chapter 7.1.  Times (000Ch, 000Dh) are plain numbers of 48 bits.
"""

import math
import struct
from abc import ABC, abstractmethod

Value = bool | int | float | str
LAST_OF_LATIN_1 = 0xFF


class DataType(ABC):
    """One row of the table.  `size` is in bytes, None for any length; `bits` is the length in a PDO."""

    size: int | None = None
    bits: int | None = None
    low: float | None = None
    high: float | None = None

    def __init__(self, name: str) -> None:
        self.name = name

    @abstractmethod
    def encode(self, value: Value) -> bytes:
        """Return `value` in little-endian order.  Raises ValueError, with what was expected, if it doesn't fit."""

    @abstractmethod
    def decode(self, data: bytes) -> Value:
        """Return the value in `data`, which must have the right size."""


class Integer(DataType):
    size: int
    bits: int
    low: int
    high: int

    def __init__(self, name: str, bits: int, is_signed: bool) -> None:
        super().__init__(name)
        self.bits, self.size, self.is_signed = bits, bits // 8, is_signed
        self.low = -(1 << (bits - 1)) if is_signed else 0
        self.high = (1 << (bits - is_signed)) - 1

    def encode(self, value: Value) -> bytes:
        if isinstance(value, bool) or not isinstance(value, int) or not self.low <= value <= self.high:
            raise ValueError(f"{value!r} is not {self.name}: expected a whole number from {self.low} to {self.high}")
        return value.to_bytes(self.size, "little", signed=self.is_signed)

    def decode(self, data: bytes) -> int:
        return int.from_bytes(data, "little", signed=self.is_signed)


class Boolean(DataType):
    """A truth value: one byte by SDO, one bit in a PDO."""

    size, bits, low, high = 1, 1, 0, 1

    def encode(self, value: Value) -> bytes:
        if not isinstance(value, int) or value not in (0, 1):
            raise ValueError(f"{value!r} is not {self.name}: expected true or false")
        return b"\x01" if value else b"\x00"

    def decode(self, data: bytes) -> bool:
        return data != b"\x00"


class Real(DataType):
    size: int
    bits: int

    def __init__(self, name: str, wire: str) -> None:
        super().__init__(name)
        self._wire = struct.Struct(wire)
        self.size, self.bits = self._wire.size, self._wire.size * 8

    def encode(self, value: Value) -> bytes:
        if isinstance(value, bool | str):
            raise ValueError(f"{value!r} is not {self.name}: expected a number")
        try:
            return self._wire.pack(value)
        except OverflowError as cause:
            raise ValueError(f"{value!r} is too large for {self.name}") from cause

    def decode(self, data: bytes) -> float:
        value: float = self._wire.unpack(data)[0]
        return value


class Text(DataType):
    def __init__(self, name: str, encoding: str) -> None:
        super().__init__(name)
        self._encoding = encoding

    def encode(self, value: Value) -> bytes:
        if not isinstance(value, str):
            raise ValueError(f"{value!r} is not {self.name}: expected a text")
        try:
            return value.encode(self._encoding)
        except UnicodeEncodeError as cause:
            raise ValueError(f"{value!r} has characters that {self.name} cannot encode") from cause

    def decode(self, data: bytes) -> str:
        return data.decode(self._encoding, "replace")


class VisibleString(Text):
    """A text in Latin-1, or in UTF-8 if it has other characters: many makers store whatever their editor wrote.

    CiA 301 allows ASCII only.  Bytes that are UTF-8 with such a character are decoded as UTF-8, and all others as
    Latin-1, so that every sequence of bytes survives decoding and encoding.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name, "utf-8")

    def encode(self, value: Value) -> bytes:
        try:
            return value.encode("latin-1") if isinstance(value, str) else super().encode(value)
        except UnicodeEncodeError:
            return super().encode(value)

    def decode(self, data: bytes) -> str:
        try:
            text = data.decode("utf-8")
        except UnicodeDecodeError:
            return data.decode("latin-1")
        return text if any(ord(character) > LAST_OF_LATIN_1 for character in text) else data.decode("latin-1")


class Octets(DataType):
    """Bytes without a meaning of their own; as a value they are hex digits."""

    def encode(self, value: Value) -> bytes:
        if not isinstance(value, str):
            raise ValueError(f"{value!r} is not {self.name}: expected bytes in hex, such as '01 af'")
        try:
            return bytes.fromhex(value)
        except ValueError as cause:
            raise ValueError(f"{value!r} is not {self.name}: expected bytes in hex, such as '01 af'") from cause

    def decode(self, data: bytes) -> str:
        return data.hex(" ")


DATA_TYPES: dict[int, DataType] = {
    0x01: Boolean("BOOLEAN"),
    0x02: Integer("INTEGER8", 8, True),
    0x03: Integer("INTEGER16", 16, True),
    0x04: Integer("INTEGER32", 32, True),
    0x05: Integer("UNSIGNED8", 8, False),
    0x06: Integer("UNSIGNED16", 16, False),
    0x07: Integer("UNSIGNED32", 32, False),
    0x08: Real("REAL32", "<f"),
    0x09: VisibleString("VISIBLE_STRING"),
    0x0A: Octets("OCTET_STRING"),
    0x0B: Text("UNICODE_STRING", "utf-16-le"),
    0x0C: Integer("TIME_OF_DAY", 48, False),
    0x0D: Integer("TIME_DIFFERENCE", 48, False),
    0x0F: Octets("DOMAIN"),
    0x10: Integer("INTEGER24", 24, True),
    0x11: Real("REAL64", "<d"),
    0x12: Integer("INTEGER40", 40, True),
    0x13: Integer("INTEGER48", 48, True),
    0x14: Integer("INTEGER56", 56, True),
    0x15: Integer("INTEGER64", 64, True),
    0x16: Integer("UNSIGNED24", 24, False),
    0x18: Integer("UNSIGNED40", 40, False),
    0x19: Integer("UNSIGNED48", 48, False),
    0x1A: Integer("UNSIGNED56", 56, False),
    0x1B: Integer("UNSIGNED64", 64, False),
}
INTEGER16 = DATA_TYPES[0x03]
UNSIGNED8 = DATA_TYPES[0x05]
DOMAIN = DATA_TYPES[0x0F]


def clamp(value: float, low: float | None, high: float | None) -> float:
    """Return `value` limited to `low` and `high`.  A limit of None doesn't apply; not-a-number becomes `low`, or 0."""
    if low is not None and not value >= low:
        return low
    if high is not None and value > high:
        return high
    return low or 0.0 if math.isnan(value) else value
