"""Inclined sine line of Bestehorn: f(z) = z - sin(2 pi z) / (2 pi); Cv = 2, Ca = 2 pi."""

from math import tau
from typing import Final

from fieldrig_devices.motion.curves.laws.law import Law
from fieldrig_devices.motion.curves.pieces import Piece

LAW: Final = Law((Piece(0.5, (0.0, 1.0), amplitude=-1 / tau, rate=tau),), cv=2.0, ca=tau, constant="IS")
