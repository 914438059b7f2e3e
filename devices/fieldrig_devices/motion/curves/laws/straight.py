"""Straight line: f(z) = z; Cv = 1, and Ca is infinite at its ends.  Lambda has no effect."""

from math import inf
from typing import Final

from fieldrig_devices.motion.curves.laws.law import Law
from fieldrig_devices.motion.curves.pieces import Piece

LAW: Final = Law((Piece(0.5, (0.0, 1.0)),), cv=1.0, ca=inf, constant="ST")
