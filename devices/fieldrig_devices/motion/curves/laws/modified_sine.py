"""Modified sine line: Cv = 4 pi / (4 + pi) = 1.76, Ca = 4 pi^2 / (4 + pi) = 5.53.

f(z) = (pi z - sin(4 pi z) / 4) / (4 + pi)                          z <= 1/8
f(z) = (2 + pi z - 9/4 sin(pi/3 + 4 pi z / 3)) / (4 + pi)           1/8 <= z <= 7/8
"""

from math import pi
from typing import Final

from fieldrig_devices.motion.curves.laws.law import Law
from fieldrig_devices.motion.curves.pieces import Piece

_Q: Final = 1 / (4 + pi)

LAW: Final = Law(
    (
        Piece(1 / 8, (0.0, pi * _Q), amplitude=-_Q / 4, rate=4 * pi),
        Piece(3 / 8, ((2 + pi / 8) * _Q, pi * _Q), amplitude=-9 / 4 * _Q, rate=4 * pi / 3, phase=pi / 2),
    ),
    cv=4 * pi * _Q,
    ca=4 * pi * pi * _Q,
    constant="MS",
)
