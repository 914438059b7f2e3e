"""Bytes in the settings of a fault, as hex digits."""

from typing import Annotated

from pydantic import AfterValidator


def _hex(text: str) -> str:
    try:
        bytes.fromhex(text)
    except ValueError as cause:
        raise ValueError(f"{text!r} are not bytes: expected hex digits, such as '01 A0'") from cause
    return text


Hex = Annotated[str, AfterValidator(_hex)]
"""Hex digits, with or without spaces between the bytes."""


def flipped(data: bytes, xor: str) -> bytes:
    """Return the bytes with the bits of `xor` flipped, from the first byte on."""
    bits = bytes.fromhex(xor)[: len(data)]
    return bytes(byte ^ flips for byte, flips in zip(data, bits.ljust(len(data), b"\0"), strict=True))


def replaced(data: bytes, by: str) -> bytes:
    """Return the bytes with those of `by` instead of the first ones; the length stays."""
    given = bytes.fromhex(by)
    return given[: len(data)] + data[len(given) :]
