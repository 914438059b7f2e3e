"""The units that an axis says it has: 60A8h for positions, 60A9h for velocities, 60AAh for accelerations.

Source: CiA 402-2; CiA 303-2 for the codes.  The highest byte is a power of ten, the next two are the codes of numerator
and denominator.  Positions follow the factors (608Fh, 6091h, 6092h), and 60A8h is the name of what results; where a
drive has no feed constant, its user unit is the angle of 60A8h.  A velocity whose numerator is that of 60A8h follows
from the user unit of positions.  Turns and other angles are those of the shaft behind the gear if positions are angles
or lengths, otherwise those of the motor.  608Bh to 608Eh are the same of the older edition, as far as their unit is
min-1.  Where no unit is known, a velocity is user units of positions per second times 6096h, and an acceleration is
them per second squared times 6097h.  Left out: the unit of the jerk, which is that of accelerations per second.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import pi
from typing import Final, NamedTuple, Self

from fieldrig_devices.cia402.units import Units

POSITION, VELOCITY, ACCELERATION = 0x60A8, 0x60A9, 0x60AA
VELOCITY_NOTATION, VELOCITY_DIMENSION = 0x608B, 0x608C
ACCELERATION_NOTATION, ACCELERATION_DIMENSION = 0x608D, 0x608E
VELOCITY_FACTOR, ACCELERATION_FACTOR = 0x6096, 0x6097
OBJECTS: Final = (
    (POSITION, 0), (VELOCITY, 0), (ACCELERATION, 0), (VELOCITY_NOTATION, 0), (VELOCITY_DIMENSION, 0),
    (ACCELERATION_NOTATION, 0), (ACCELERATION_DIMENSION, 0), (VELOCITY_FACTOR, 1), (VELOCITY_FACTOR, 2),
    (ACCELERATION_FACTOR, 1), (ACCELERATION_FACTOR, 2),
)  # fmt: skip
INCREMENT_POSITIONS, INCREMENT_VELOCITIES, INCREMENT_ACCELERATIONS = 0x00B5_0000, 0x00B5_0300, 0x00B5_5700
RPM: Final = 0x00B4_4700

METRE: Final = 0x01
INCREMENTS: Final = frozenset({0xB5, 0xAC})
TURNS_OF: Final = {0xB4: 1.0, 0x10: 1 / (2 * pi), 0x40: 1 / 400, 0x41: 1 / 360, 0x42: 1 / 21_600, 0x43: 1 / 1_296_000}
"""Turns of the revolution, radian, gon, degree, and of the minute and second of arc."""
RPM_NUMERATOR: Final = 0xC0
"""Numerator of accelerations in min-1 per second."""
SECONDS: Final = {0x03: 1.0, 0x47: 60.0, 0x48: 3_600.0}
PER_S2: Final = 0x57
"""Denominator s2."""
RPM_DIMENSION: Final = 0xA4


class Unit(NamedTuple):
    exponent: int
    numerator: int
    denominator: int

    @classmethod
    def read(cls, number: int) -> Self:
        return cls(_signed(number >> 24 & 0xFF), number >> 16 & 0xFF, number >> 8 & 0xFF)

    @property
    def is_angle_or_length(self) -> bool:
        return self.numerator in TURNS_OF or self.numerator == METRE


NONE: Final = Unit(0, 0, 0)
"""User units, without a name."""


@dataclass(frozen=True, slots=True)
class SiUnits:
    position: Unit = NONE
    velocity: Unit = NONE
    acceleration: Unit | None = None
    """None for the unit of velocities per second."""
    velocity_factor: float = 1.0
    """Units of velocities that are one user unit of positions per second, where no unit of them is known."""
    acceleration_factor: float | None = None
    """The same of accelerations; None for the unit of velocities per second."""

    @property
    def per_turn(self) -> float | None:
        """The units of an angle in a turn; None if positions are no angles."""
        turns = TURNS_OF.get(self.position.numerator)
        return None if turns is None else 10.0**-self.position.exponent / turns

    def scaled(self, units: Units, turn: float, shaft_turn: float) -> Units:
        """`units` with those of velocities and accelerations; `turn` and `shaft_turn` are the increments of one."""
        base = shaft_turn if self.position.is_angle_or_length else turn
        known = self._speed(self.velocity, units.per_unit, base)
        speed = units.per_unit / self.velocity_factor if known is None else known
        rate = None if self.acceleration is None else self._rate(self.acceleration, units.per_unit, base)
        if rate is None and self.acceleration_factor is not None:
            rate = (units.per_unit if known is None else known) / self.acceleration_factor
        elif rate is None:
            rate = speed if self.acceleration is None else units.per_unit
        return replace(units, per_speed_unit=speed, per_rate_unit=rate)

    def _speed(self, unit: Unit, per_unit: float, turn: float) -> float | None:
        """The increments per second of a unit; None if it says nothing that is known."""
        way, seconds = self._way(unit, per_unit, turn), SECONDS.get(unit.denominator)
        return None if way is None or seconds is None else way / seconds

    def _rate(self, unit: Unit, per_unit: float, turn: float) -> float | None:
        if unit.numerator == RPM_NUMERATOR:
            rpm = Unit(unit.exponent, 0xB4, 0x47)
            speed, seconds = self._speed(rpm, per_unit, turn), SECONDS.get(unit.denominator)
            return None if speed is None or seconds is None else speed / seconds
        return self._way(unit, per_unit, turn) if unit.denominator == PER_S2 else None

    def _way(self, unit: Unit, per_unit: float, turn: float) -> float | None:
        if unit.numerator == self.position.numerator and unit.numerator:
            return float(per_unit * 10.0 ** (unit.exponent - self.position.exponent))
        if unit.numerator in TURNS_OF:
            return float(turn * TURNS_OF[unit.numerator] * 10.0**unit.exponent)
        return float(10.0**unit.exponent) if unit.numerator in INCREMENTS else None


def si_units(number: Callable[[int, int], int | None]) -> SiUnits:
    """Return the units that objects say; `number` returns the value of an index and sub-index, or None without it."""
    position, velocity, acceleration = (number(index, 0) for index in (POSITION, VELOCITY, ACCELERATION))
    return SiUnits(
        NONE if position is None else Unit.read(position),
        _older(number, VELOCITY_NOTATION, 0xB4, 0x47) or NONE if velocity is None else Unit.read(velocity),
        _older(number, ACCELERATION_NOTATION, RPM_NUMERATOR, 0x03) if acceleration is None else Unit.read(acceleration),
        _factor(number, VELOCITY_FACTOR) or 1.0,
        _factor(number, ACCELERATION_FACTOR),
    )


def _factor(number: Callable[[int, int], int | None], index: int) -> float | None:
    """Return a factor by its numerator and divisor, of which 0 is taken as 1; None where the drive has none."""
    numerator, divisor = number(index, 1), number(index, 2)
    return None if numerator is None else max(numerator, 1) / max(divisor or 1, 1)


def _older(number: Callable[[int, int], int | None], notation: int, numerator: int, denominator: int) -> Unit | None:
    """The unit of a notation index and of the dimension index behind it; None unless the latter is min-1."""
    if number(notation + 1, 0) != RPM_DIMENSION:
        return None
    return Unit(_signed((number(notation, 0) or 0) & 0xFF), numerator, denominator)


def is_known(index: int, number: int) -> bool:
    """True for a unit that `index` can have, also if it is none."""
    unit = Unit.read(number)
    is_way = unit.is_angle_or_length or unit.numerator in INCREMENTS
    if not number:
        return True
    if number & 0xFF or abs(unit.exponent) > 12:
        return False
    if index == POSITION:
        return is_way and unit.denominator == 0
    if index == VELOCITY:
        return is_way and unit.denominator in SECONDS
    is_rpm_rate = unit.numerator == RPM_NUMERATOR and unit.denominator in SECONDS
    return is_rpm_rate or (is_way and unit.denominator == PER_S2)


def _signed(byte: int) -> int:
    return byte - 0x100 if byte & 0x80 else byte
