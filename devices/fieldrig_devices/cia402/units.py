"""Conversion between user units and increments: 608Fh, 6091h, 6092h, 607Eh, and the origin.

Source: CiA 402-2, chapter 'factor group'; 607Bh and 60F2h of 'profile position mode'.  A position in user units is
increments x feed constant / (encoder resolution x gear ratio); speeds and accelerations are the same per second and per
second squared.  Positions wrap around at the ends of 32 bits, or of the range of 607Bh.  Our choice: both ends belong
to the range.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Final

POSITION_IS_TURNED, VELOCITY_IS_TURNED = 0x80, 0x40
"""Bits of the polarity (607Eh)."""
_HALF: Final = 1 << 31
_WHOLE: Final = 1 << 32


@dataclass(frozen=True, slots=True)
class Units:
    per_unit: float = 1.0
    """Increments per user unit."""
    per_speed_unit: float = 1.0
    """Increments per second of the user's unit of velocities."""
    per_rate_unit: float = 1.0
    """Increments per second squared of the user's unit of accelerations."""
    sign: int = 1
    velocity_sign: int = 1
    origin: float = 0.0
    """Position of the user's zero, in increments."""

    def increments(self, position: float) -> float:
        return self.origin + self.sign * position * self.per_unit

    def distance(self, length: float) -> float:
        """A length in user units as increments, which do not depend on the origin."""
        return self.sign * length * self.per_unit

    def position(self, increments: float) -> int:
        """The position in user units, not wrapped to 32 bits."""
        return round(self.sign * (increments - self.origin) / self.per_unit)

    def length(self, distance: float) -> int:
        """A distance in increments as user units."""
        return round(self.sign * distance / self.per_unit)

    def velocity(self, increments_per_s: float) -> int:
        return round(self.velocity_sign * increments_per_s / self.per_speed_unit)

    def speed(self, velocity: float) -> float:
        """The signed speed in increments per second."""
        return self.velocity_sign * velocity * self.per_speed_unit


def units_of(
    encoder: tuple[int, int],
    gear: tuple[int, int],
    feed: tuple[float, int],
    polarity: int,
    origin: float,
) -> Units:
    """The units from three ratios.  A 0 counts as 1, because division by it is not possible.

    `encoder`: increments to motor revolutions; `gear`: motor to shaft revolutions; `feed`: user units to shaft
    revolutions.  Speeds and accelerations are in user units per second and per second squared.
    """
    (increments, turns), (motor, shaft), (length, shaft_turns) = (
        (max(a, 1), max(b, 1)) for a, b in (encoder, gear, feed)
    )
    per_unit = increments * motor * shaft_turns / (turns * shaft * length)
    sign = -1 if polarity & POSITION_IS_TURNED else 1
    return Units(
        per_unit,
        per_unit,
        per_unit,
        sign,
        -1 if polarity & VELOCITY_IS_TURNED else 1,
        origin,
    )


class Direction(IntEnum):
    """Direction in which a position within a revolution is approached (60F2h, bits 6 and 7)."""

    AS_LINEAR = 0
    """Within the present revolution of the axis."""
    NEGATIVE = 1
    POSITIVE = 2
    SHORTEST = 3


@dataclass(frozen=True, slots=True)
class Turn:
    """The range in which positions are shown; they wrap around at its ends."""

    low: int = -_HALF
    span: int = _WHOLE

    def shown(self, position: int) -> int:
        return (position - self.low) % self.span + self.low

    def meant(self, shown: int, near: int, direction: Direction = Direction.AS_LINEAR) -> int:
        """The position that is shown as `shown` and is reached from `near` in this direction."""
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
    """The range of 607Bh, or 32 bits if it is empty."""
    return Turn(low, high - low + 1) if low < high else BITS_32


BITS_32: Final = Turn()
