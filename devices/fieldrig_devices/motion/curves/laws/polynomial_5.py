"""Polynomial of the fifth degree: f(z) = 10 z^3 - 15 z^4 + 6 z^5; Cv = 15/8, Ca = 10 / sqrt(3).

`between` is its general form for a motion from velocity to velocity: f(0) = 0, f(1) = 1, with the given slopes and
second derivatives at both ends.
"""

from math import sqrt
from typing import Final

from fieldrig_devices.motion.curves.laws.law import Law
from fieldrig_devices.motion.curves.pieces import Piece

LAW: Final = Law((Piece(0.5, (0.0, 0.0, 0.0, 10.0, -15.0, 6.0)),), cv=15 / 8, ca=10 / sqrt(3), constant="P5")


def between(v0: float, v1: float, a0: float = 0.0, a1: float = 0.0) -> Piece:
    c2 = a0 / 2
    rest, slope, bend = 1 - v0 - c2, v1 - v0 - a0, a1 - a0
    c3 = 10 * rest - 4 * slope + bend / 2
    c4 = -15 * rest + 7 * slope - bend
    c5 = 6 * rest - 3 * slope + bend / 2
    return Piece(1.0, (0.0, v0, c2, c3, c4, c5))
