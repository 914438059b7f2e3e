"""A cam on its way: what a job of `CAM` says, and the same as closed forms over the position of the master.

    y = YFactor * f((x - XOffset) / XFactor) + YOffset

x and y are the coordinates of the cam.  The manual names the pins and the mode ABSOLUTE only (PD-190, PD-191).  The
rest is our choice, after PLCopen MC_CamTableSelect and MC_CamIn, whose MasterAbsolute, SlaveAbsolute and StartMode say
what the coordinates are when a cam begins.  Here the set position mode of x or y says it:

    NO_SETPOS   they continue; at first they are those of encoder and axis
    ABSOLUTE    master or axis is at XSetposPos or YSetposPos at this point
    RELATIVE    they continue, with this value added

Setting a position never changes the encoder or the axis, only the coordinates of the cam.  Beyond an active limit a cam
stands still; beyond its profile, it goes on along the tangent.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, IntEnum
from math import inf
from typing import Final

from fieldrig_devices.max4.libraries.controller import Encoder
from fieldrig_devices.motion.curves.pieces import Piece, evaluator
from fieldrig_devices.motion.curves.profile import Profile


class Setpos(IntEnum):
    NO_SETPOS = 0
    ABSOLUTE = 1
    RELATIVE = 2


class Stage(Enum):
    """How far a cam is."""

    WAITING = "waits until the cam before it ends"
    ACTIVE = "moves the axis"
    ENDED = "has reached a limit, or another cam has followed"
    DROPPED = "was replaced before its end"


@dataclass(slots=True, eq=False)
class Cam:
    """One job.  All positions are in the units of encoder and axis."""

    master: Encoder
    profile: Profile
    x_offset: float = 0.0
    y_offset: float = 0.0
    x_factor: float = 1.0
    y_factor: float = 1.0
    x_low: float = -inf
    """Lower limit of x; -inf if it is off."""
    x_high: float = inf
    x_mode: Setpos = Setpos.NO_SETPOS
    x_setpos: float = 0.0
    y_mode: Setpos = Setpos.NO_SETPOS
    y_setpos: float = 0.0
    stage: Stage = Stage.WAITING

    def at(self, x: float) -> float:
        """y at this x, in units, without the limits."""
        return self.y_factor * self.profile.at((x - self.x_offset) / self.x_factor) + self.y_offset


def shifted(mode: Setpos, setpos: float, position: float, shift: float) -> float:
    """The shift of a coordinate (position minus coordinate) after a set position at `position`."""
    if mode is Setpos.ABSOLUTE:
        return position - setpos
    return shift - setpos if mode is Setpos.RELATIVE else shift


class Track:
    """An active cam.  Positions are in increments of the axis, and `master` is the position of the encoder.

    The cam is over at the limit that the master reaches.  At the limit at which it began it waits for the master, so a
    master that trembles there does not end it.
    """

    __slots__ = ("_ends", "at", "cam", "end", "high", "is_over", "low", "origin", "scale", "x_shift", "y_shift")

    def __init__(self, cam: Cam, scale: float, x_shift: float, y_shift: float, master: float) -> None:
        """`scale` is in increments per unit, `y_shift` in increments; the cam begins at this position of the master."""
        self.cam, self.scale, self.x_shift, self.y_shift = cam, scale, x_shift, y_shift
        self.low, self.high, self.origin = inf, -inf, 0.0
        """The range of the master for which `at(master - origin)` is the position of the axis."""
        self.at: Callable[[float], float] = _ZERO
        self.is_over = False
        self.end = 0.0
        """The position at which the master reached the limit, once the cam is over."""
        x = master - x_shift
        near = 1e-9 * (1 + abs(x))
        self._ends = x > cam.x_low + near, x < cam.x_high - near
        """True for the lower and the upper limit if it ends the cam."""

    def enter(self, master: float) -> None:
        """Prepare the closed form for this position of the master and its surroundings."""
        cam = self.cam
        x = master - self.x_shift
        if self.is_over:
            return
        if x < cam.x_low:
            self._stand(cam.x_low, -inf, cam.x_low, is_end=self._ends[0])
        elif x >= cam.x_high:
            self._stand(cam.x_high, cam.x_high, inf, is_end=self._ends[1])
        else:
            self._enter_piece(x)

    def _stand(self, limit: float, low: float, high: float, *, is_end: bool) -> None:
        position = self.y_shift + self.scale * self.cam.at(limit)
        self.origin = 0.0
        self.at = lambda _: position
        if is_end:
            self.is_over, self.end = True, limit + self.x_shift
            self.low, self.high = -inf, inf
        else:
            self.low, self.high = low + self.x_shift, high + self.x_shift

    def _enter_piece(self, x: float) -> None:
        cam, profile = self.cam, self.cam.profile
        factor, start = cam.x_factor, self.x_shift + cam.x_offset
        index = profile.index((x - cam.x_offset) / factor)
        piece = profile.pieces[index].scaled(factor, cam.y_factor * self.scale)
        self.at = evaluator(piece.raised(cam.y_offset * self.scale + self.y_shift))
        self.origin = start + factor * profile.origin(index)
        ends = [start + factor * z for z in _range(profile, index)]
        self.low = max(min(ends), cam.x_low + self.x_shift)
        self.high = min(max(ends), cam.x_high + self.x_shift)


def _range(profile: Profile, index: int) -> tuple[float, float]:
    """The z between which this piece applies; the tangents have no end."""
    low = profile.starts[index - 1] if index > 0 else -inf
    high = profile.starts[index] if index < len(profile.starts) else inf
    return low, high


_ZERO: Final = evaluator(Piece(0.0, (0.0, 0.0)))
