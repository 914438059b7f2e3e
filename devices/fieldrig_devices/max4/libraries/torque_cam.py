"""The block TORQUECAM: the torque of an axis follows a master through a cam (PD-195).

y is the torque in percent of the rated torque of the motor.  The manual only names the library; pins and reactions are
ours.  A torque cam begins at once; at its limit the last torque stays until another job or the end of control.
"""

from typing import Final

from fieldrig_devices.iec.host import NativeBlock
from fieldrig_devices.max4.axes.axis import Axis, Mode
from fieldrig_devices.max4.libraries.cam import PINS, cam_block
from fieldrig_devices.max4.libraries.follower import CamFollower
from fieldrig_devices.max4.libraries.motion import Motion
from fieldrig_devices.max4.libraries.results import Result
from fieldrig_devices.max4.libraries.track import Cam, Stage, Track, shifted

TEXT: Final = "FUNCTION_BLOCK TORQUECAM" + PINS
PER_PERCENT: Final = 10.0
"""Set values of a torque are in 0.1 %."""
MOST: Final = 32_767


class TorqueFollower:
    """The `SetValues` of one axis on a torque cam."""

    def __init__(self, axis: Axis) -> None:
        self._axis = axis
        self.mode = Mode.TORQUE
        self._track: Track | None = None

    def take(self, cam: Cam) -> Result:
        if self._axis.set_values is not self:
            self._axis.follow(self)
        self.end()
        master = cam.master.position
        x_shift = shifted(cam.x_mode, cam.x_setpos, master, 0.0)
        self._track = Track(cam, PER_PERCENT, x_shift, 0.0, master)
        cam.stage = Stage.ACTIVE
        return Result.TAKEN

    def begin(self, axis: Axis) -> None:
        self.end()

    def next(self) -> float:
        track = self._track
        if track is None:
            return 0
        master = track.cam.master.position
        if not track.low <= master < track.high:
            track.enter(master)
            if track.is_over:
                track.cam.stage = Stage.ENDED
        try:
            return round(min(max(track.at(master - track.origin), -MOST), MOST))
        except (ArithmeticError, ValueError):
            return 0

    def end(self) -> None:
        """Drop the cam; without one there is no torque."""
        track, self._track = self._track, None
        if track is not None and track.cam.stage is Stage.ACTIVE:
            track.cam.stage = Stage.DROPPED


def torque_cam_block(motion: Motion) -> NativeBlock:
    followers: dict[int, TorqueFollower] = {}

    def give(follower: CamFollower, cam: Cam, scale: float) -> Result:
        axis = follower.axis
        return followers.setdefault(axis.log_adr, TorqueFollower(axis)).take(cam)

    return cam_block(motion, give)
