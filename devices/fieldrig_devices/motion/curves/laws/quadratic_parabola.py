"""Quadratic parabola: f(z) = 2 z^2 up to the turning point; Cv = 2, Ca = 4, the smallest Ca of all laws."""

from typing import Final

from fieldrig_devices.motion.curves.laws.law import Law
from fieldrig_devices.motion.curves.pieces import Piece

LAW: Final = Law((Piece(0.5, (0.0, 0.0, 2.0)),), cv=2.0, ca=4.0, constant="QP")
