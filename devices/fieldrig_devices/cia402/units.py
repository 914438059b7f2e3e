"""User units and increments: 608Fh, 6091h, 6092h, 607Eh, and where the origin lies.

Source: CiA 402-2, chapter 'factor group'; 607Bh and 60F2h of 'profile position mode'.  A position in user units is
increments x feed constant / (encoder resolution x gear ratio); speeds and accelerations are the same per second and per
second squared.  Positions count on over the ends of 32 bits, or of the range of 607Bh.  Ours: both ends belong to it.
"""

from dataclasses import dataclass
from enum import IntEnum
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

    def length(self, way: float) -> int:
        """In user units, of a way in increments."""
        return round(self.sign * way / self.per_unit)

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


class Direction(IntEnum):
    """In which one a position on a turn is reached: 60F2h, bits 6 and 7."""

    AS_LINEAR = 0
    """On the turn on which the axis is."""
    NEGATIVE = 1
    POSITIVE = 2
    SHORTEST = 3


@dataclass(frozen=True, slots=True)
class Turn:
    """The range in which positions are shown; beyond it they begin again at its other end."""

    low: int = -_HALF
    span: int = _WHOLE

    def shown(self, position: int) -> int:
        return (position - self.low) % self.span + self.low

    def meant(self, shown: int, near: int, direction: Direction = Direction.AS_LINEAR) -> int:
        """The position that is shown so, seen from `near`."""
        way = self.shown(shown) - self.shown(near)
        match direction:
            case Direction.NEGATIVE:
                way = -(-way % self.span)
            case Direction.POSITIVE:
                way %= self.span
            case Direction.SHORTEST:
                half = self.span // 2
                way = half - (half - way) % self.span
        return near + way


def turn_of(low: int, high: int) -> Turn:
    """607Bh; without a range there are 32 bits."""
    return Turn(low, high - low + 1) if low < high else BITS_32


BITS_32: Final = Turn()
