"""User units and increments: 608Fh, 6091h, 6092h, 607Eh, and where the origin lies.

Source: CiA 402-2, chapter 'factor group'.  A position in user units is increments x feed constant / (encoder resolution
x gear ratio); speeds and accelerations are the same per second and per second squared.  Positions of 32 bits count on
over their ends: one that is given means the nearest turn of them.
"""

from dataclasses import dataclass
from typing import Final

POSITION_IS_TURNED, VELOCITY_IS_TURNED = 0x80, 0x40
"""Bits of 607Eh."""
_HALF: Final = 1 << 31
_WHOLE: Final = 1 << 32


@dataclass(frozen=True, slots=True)
class Units:
    per_unit: float = 1.0
    """Increments in a user unit."""
    sign: int = 1
    velocity_sign: int = 1
    origin: float = 0.0
    """Where in increments the user's zero is."""

    def increments(self, position: float) -> float:
        return self.origin + self.sign * position * self.per_unit

    def distance(self, length: float) -> float:
        """Without origin: of a way."""
        return self.sign * length * self.per_unit

    def position(self, increments: float) -> int:
        """In user units, over 32 bits and beyond."""
        return round(self.sign * (increments - self.origin) / self.per_unit)

    def velocity(self, increments_per_s: float) -> int:
        return round(self.velocity_sign * increments_per_s / self.per_unit)

    def speed(self, velocity: float) -> float:
        """With its sign, in increments per second."""
        return self.velocity_sign * velocity * self.per_unit


def units_of(
    encoder: tuple[int, int], gear: tuple[int, int], feed: tuple[int, int], polarity: int, origin: float
) -> Units:
    """`encoder`: increments in motor turns; `gear`: motor turns to turns of the shaft; `feed`: user units in turns of
    the shaft.  Zeros count as 1, as nothing can be divided by them."""
    (increments, turns), (motor, shaft), (length, shaft_turns) = (
        (max(a, 1), max(b, 1)) for a, b in (encoder, gear, feed)
    )
    per_unit = increments * motor * shaft_turns / (turns * shaft * length)
    sign = -1 if polarity & POSITION_IS_TURNED else 1
    return Units(per_unit, sign, -1 if polarity & VELOCITY_IS_TURNED else 1, origin)


def wrapped(position: int) -> int:
    """What 32 bits show of it."""
    return (position + _HALF) % _WHOLE - _HALF


def unwrapped(shown: int, near: int) -> int:
    """The position on the turn of 32 bits on which `near` is."""
    return shown + near - wrapped(near)
