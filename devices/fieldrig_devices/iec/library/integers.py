"""Integers of a limited number of bits: cutting, powers and BCD."""

from typing import Final

from fieldrig_devices.iec.elementary import Elementary


def wrapped(python: str, kind: Elementary) -> str:
    """A Python expression that cuts the integer `python` to the type, without saturation (PD-L39)."""
    if not kind.is_signed:
        return f"({python} & {2**kind.bits - 1})"
    return f"(({python} + {2 ** (kind.bits - 1)} & {2**kind.bits - 1}) - {2 ** (kind.bits - 1)})"


def cut(value: int, kind: Elementary) -> int:
    """The lowest bits of the value as a value of the type."""
    low = value & ((1 << kind.bits) - 1)
    return low - (1 << kind.bits) if kind.is_signed and low > kind.high else low


POWER_BITS: Final = 64


def integer_power(base: int, exponent: int) -> int:
    """EXPT of integers, cut to 64 bits.  A negative exponent gives the integer part of the result; 0 to it is 0."""
    if exponent >= 0:
        return pow(base, exponent, 1 << POWER_BITS)
    if base not in (1, -1):
        return 0
    return 1 if base == 1 or exponent % 2 == 0 else -1


def bcd_to_integer(value: int) -> int:
    """The number whose decimal digits are the nibbles of `value`; -1 if a nibble is no digit, as in CoDeSys V2.3."""
    digits = f"{value:x}"
    return int(digits) if digits.isdigit() else -1


def integer_to_bcd(value: int, digits: int) -> int:
    """The number with one decimal digit per nibble; all bits are set if it does not fit, as in CoDeSys V2.3."""
    return int(str(value), 16) if 0 <= value < 10**digits else (1 << 4 * digits) - 1


def is_bcd(value: int) -> bool:
    """True if every nibble is a decimal digit."""
    return bcd_to_integer(value) >= 0


def swapped(value: int, size: int) -> int:
    """The lowest `size` bytes of an integer in the opposite order."""
    return int.from_bytes((value & ((1 << 8 * size) - 1)).to_bytes(size, "little"), "big")


def multiplex(number: int, *values: object) -> object:
    """MUX: the value with this number, from 0; the last one if there is none, as in CoDeSys V2.3."""
    return values[number] if 0 <= number < len(values) else values[-1]
