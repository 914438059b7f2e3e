"""Sequence numbers, which wrap around at 2 ** 32 on the wire (RFC 9293, 3.4).

Within the stack a sequence number is a *position*: an integer that never wraps, equal to the number on the wire modulo
2 ** 32.  So positions are compared like other integers.
"""

from typing import Final

MODULUS: Final = 1 << 32
_HALF: Final = 1 << 31


def position(number: int, near: int) -> int:
    """Return the position of a number on the wire that is nearest to the position `near`."""
    return near + (number - near + _HALF) % MODULUS - _HALF


def on_wire(where: int) -> int:
    """Return the number on the wire of a position."""
    return where % MODULUS
