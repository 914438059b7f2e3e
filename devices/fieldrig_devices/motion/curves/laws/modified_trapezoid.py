"""Modified acceleration trapezoid: Cv = 2, Ca = 8 pi / (2 + pi) = 4.89.

The acceleration rises as a quarter of a sine up to z = 1/8, is constant up to 3/8, and falls as a quarter of a cosine
up to the turning point.

    f''(z) = Ca sin(4 pi z),    Ca,    Ca cos(4 pi (z - 3/8))
"""

from math import pi
from typing import Final

from fieldrig_devices.motion.curves.laws.law import Law
from fieldrig_devices.motion.curves.pieces import Piece

_CA: Final = 8 * pi / (2 + pi)
_V: Final = _CA / (4 * pi)
"""The slope that a quarter of a sine adds."""
_S: Final = _V / (4 * pi)
_Y1: Final = _V / 8 - _S
_Y2: Final = _Y1 + _V / 4 + _CA / 32
_V2: Final = _V + _CA / 4

LAW: Final = Law(
    (
        Piece(1 / 8, (0.0, _V), amplitude=-_S, rate=4 * pi),
        Piece(1 / 4, (_Y1, _V, _CA / 2)),
        Piece(1 / 8, (_Y2 + _S, _V2), amplitude=-_S, rate=4 * pi, phase=pi / 2),
    ),
    cv=2.0,
    ca=_CA,
    constant="MT",
)
