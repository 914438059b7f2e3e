"""An axis that follows cams: the source of its set values, once in every ring cycle (PD-180, PD-182).

One cam moves the axis, and one more can wait.  A waiting cam begins exactly where the present one reaches its limit:
the way that the master has gone beyond the limit within the cycle already belongs to it, so neither position nor speed
jumps whatever the cycle.  If no cam waits at the limit, the axis stops, and the next cam begins at its call
(PD-193).  A cam without a limit on the master's way is replaced at once.

A slave cam adds its way to the cams of the axis; it can only begin while one of them is active (PD-186).  What it has
added remains when it ends.
"""

from collections.abc import Callable, Iterator
from math import inf
from typing import Final

from fieldrig_devices.max4.axes.axis import Axis, Mode
from fieldrig_devices.max4.libraries.controller import Encoder
from fieldrig_devices.max4.libraries.results import Result
from fieldrig_devices.max4.libraries.track import Cam, Stage, Track, shifted


class _Nothing:
    """The master of an axis that stands."""

    position = 0.0


_NOTHING: Final = _Nothing()


class CamFollower:
    """The `SetValues` of one axis on cams."""

    __slots__ = (
        "_at",
        "_high",
        "_low",
        "_master",
        "_origin",
        "_position",
        "_slave",
        "_track",
        "_waiting",
        "axis",
        "mode",
    )

    def __init__(self, axis: Axis) -> None:
        self.axis = axis
        self.mode = Mode.POSITION
        self._position = 0
        """The last set value."""
        self._track: Track | None = None
        self._waiting: tuple[Cam, float] | None = None
        self._slave: Track | None = None
        self._master: Encoder = _NOTHING
        self._at: Callable[[float], float] = self._stay
        self._stand()

    # ---- for the blocks

    @property
    def is_active(self) -> bool:
        """True while a cam moves the axis."""
        return self._track is not None and self._track.cam.stage is Stage.ACTIVE

    @property
    def has_room(self) -> bool:
        """True if `take` would take a cam."""
        return self._waiting is None or self.axis.set_values is not self

    def take(self, cam: Cam, scale: float) -> Result:
        """Begin a cam, or keep it until the present one ends.  `scale` is in increments per unit."""
        axis = self.axis
        if axis.set_values is not self:
            self._take_over()
        elif self._is_bounded:
            if self._waiting is not None:
                return Result.WAITING
            self._waiting = cam, scale
            return Result.TAKEN
        track, master = self._track, cam.master.position
        position = float(self._position) if track is None else track.at(track.cam.master.position - track.origin)
        self._begin_cam(cam, scale, master, position)
        self._enter(master)
        return Result.TAKEN

    def overlay(self, cam: Cam, scale: float) -> Result:
        """Begin a slave cam instead of the one before it."""
        if not self.is_active or self.axis.set_values is not self:
            return Result.NO_MASTER_CAM
        master, added = cam.master.position, 0.0
        slave = self._slave
        if slave is not None:
            slave.cam.stage = Stage.ENDED if slave.is_over else Stage.DROPPED
            added = self._added(slave)
        x_shift = shifted(cam.x_mode, cam.x_setpos, master, 0.0)
        self._slave = Track(cam, scale, x_shift, added - scale * cam.at(master - x_shift), master)
        cam.stage = Stage.ACTIVE
        return Result.TAKEN

    # ---- for the axis (`SetValues`)

    def begin(self, axis: Axis) -> None:
        self._clear()
        self._position = axis.position

    def next(self) -> float:
        master = self._master.position
        try:
            if not self._low <= master < self._high:
                self._turn(master)
                master = self._master.position
            position = self._at(master - self._origin)
            if self._slave is not None:
                position += self._added(self._slave)
            self._position = round(position)
        except (ArithmeticError, ValueError):  # a position that no drive has: the axis stays where it is
            pass
        return self._position

    def end(self) -> None:
        self._clear()

    # ---- cams one after the other

    @property
    def _is_bounded(self) -> bool:
        """True while the present cam moves the axis and has a limit, so that the next one waits."""
        track = self._track
        if track is None or track.is_over:
            return False
        cam = track.cam
        return cam.x_low > -inf or cam.x_high < inf

    def _turn(self, master: float) -> None:
        """Go on to the piece for this position of the master, or to the waiting cam."""
        track = self._track
        assert track is not None
        self._enter(master)
        if track.is_over:
            track.cam.stage = Stage.ENDED
            if self._waiting is not None:
                self._chain(track)

    def _chain(self, track: Track) -> None:
        assert self._waiting is not None
        cam, scale = self._waiting
        self._waiting = None
        is_same_master = cam.master is track.cam.master
        joint = track.end if is_same_master else cam.master.position
        self._begin_cam(cam, scale, joint, track.at(0.0))
        self._enter(cam.master.position)

    def _begin_cam(self, cam: Cam, scale: float, master: float, position: float) -> None:
        """Begin a cam at this point of master and axis."""
        before = self._track
        x_shift = y_shift = 0.0
        if before is not None:
            y_shift = before.y_shift
            if before.cam.master is cam.master:
                x_shift = before.x_shift
            before.cam.stage = Stage.ENDED
        x_shift = shifted(cam.x_mode, cam.x_setpos, master, x_shift)
        y_shift = shifted(cam.y_mode, cam.y_setpos * scale, position, y_shift)
        cam.stage = Stage.ACTIVE
        self._track, self._master = Track(cam, scale, x_shift, y_shift, master), cam.master

    def _enter(self, master: float) -> None:
        track = self._track
        assert track is not None
        track.enter(master)
        self._low, self._high, self._origin, self._at = track.low, track.high, track.origin, track.at

    def _added(self, slave: Track) -> float:
        """The way that a slave cam has added, in increments."""
        master = slave.cam.master.position
        if not slave.low <= master < slave.high:
            slave.enter(master)
            if slave.is_over:
                slave.cam.stage = Stage.ENDED
        return slave.at(master - slave.origin)

    # ---- taking over and standing

    def _take_over(self) -> None:
        """Become the source of the axis, at its present set position."""
        axis = self.axis
        position = axis.set_value if axis.mode is Mode.POSITION else axis.position
        axis.follow(self)
        self._position = round(position)
        axis.set_value = self._position

    def _clear(self) -> None:
        """Drop all cams and stand."""
        for cam in self._cams:
            if cam.stage in (Stage.ACTIVE, Stage.WAITING):
                cam.stage = Stage.DROPPED
        self._stand()

    @property
    def _cams(self) -> Iterator[Cam]:
        for track in (self._track, self._slave):
            if track is not None:
                yield track.cam
        if self._waiting is not None:
            yield self._waiting[0]

    def _stand(self) -> None:
        self._track = self._waiting = self._slave = None
        self._master, self._at = _NOTHING, self._stay
        self._low, self._high, self._origin = -inf, inf, 0.0

    def _stay(self, _: float) -> float:
        return self._position
