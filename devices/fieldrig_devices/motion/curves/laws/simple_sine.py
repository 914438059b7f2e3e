"""Simple sine line: f(z) = (1 - cos(pi z)) / 2; Cv = pi / 2, Ca = pi^2 / 2."""

from math import pi
from typing import Final

from fieldrig_devices.motion.curves.laws.law import Law
from fieldrig_devices.motion.curves.pieces import Piece

LAW: Final = Law(
    (Piece(0.5, (0.5, 0.0), amplitude=0.5, rate=pi, phase=-pi / 2),), cv=pi / 2, ca=pi * pi / 2, constant="SS"
)
