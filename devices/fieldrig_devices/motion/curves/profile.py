"""A profile: a normalised curve of pieces over z from 0 to 1, which continues along its tangent at both ends.

A profile of a motion law has a lambda, the position of its turning point.  The law's accelerating half is stretched to
0..lambda and its decelerating half to lambda..1, both along z and along y.  The slope at the turning point remains Cv
for every lambda, so 1.0 leads from dwell to velocity, 0.0 from velocity to dwell, and 0.5 from dwell to dwell (PD-188).
"""

from bisect import bisect_right
from collections.abc import Sequence
from itertools import accumulate
from typing import Final

from fieldrig_devices.motion.curves.laws.law import Law
from fieldrig_devices.motion.curves.pieces import Piece

SHORTEST: Final = 1e-6


class Profile:
    __slots__ = ("pieces", "starts")

    def __init__(self, pieces: Sequence[Piece]) -> None:
        """`pieces` follow one another from z = 0 to z = 1; before and behind them their tangents are added."""
        first, last = pieces[0], pieces[-1]
        before = Piece(0.0, (first.at(0.0), first.slope(0.0)))
        behind = Piece(0.0, (last.at(last.length), last.slope(last.length)))
        self.starts = (0.0, *accumulate(piece.length for piece in pieces[:-1]), 1.0)
        """The z at which the pieces behind the first one begin."""
        self.pieces = (before, *pieces, behind)

    def index(self, z: float) -> int:
        """The number of the piece at `z`."""
        return bisect_right(self.starts, z)

    def origin(self, index: int) -> float:
        """The z at which t of this piece is 0."""
        return self.starts[max(index - 1, 0)]

    def at(self, z: float) -> float:
        index = self.index(z)
        return self.pieces[index].at(z - self.origin(index))

    def slope(self, z: float) -> float:
        index = self.index(z)
        return self.pieces[index].slope(z - self.origin(index))


def shaped(law: Law, turning_point: float = 0.5) -> Profile:
    """The profile of a law with this lambda, from 0 to 1; a half that is shorter than `SHORTEST` is left out."""
    turning_point = 0.0 if turning_point < SHORTEST else 1.0 if turning_point > 1 - SHORTEST else turning_point
    up, down = 2 * turning_point, 2 * (1 - turning_point)
    rising = [piece.scaled(up, up) for piece in law.half] if up else []
    falling = [piece.reflected().scaled(down, down).raised(1.0) for piece in reversed(law.half)] if down else []
    return Profile([*rising, *falling])
