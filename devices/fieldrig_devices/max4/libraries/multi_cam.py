"""The block MultiCam3: three axes follow one encoder (PD-080, which gives its name and its typical time of 12 us).

The three cams begin at the same position of the master, or none of them does: at x = 0, over the length lrXFactor, with
the axes at y = 0 of their cams and the limits of the master on.  An axis that is not used has the address 0.  The pins
are our choice, as the manual gives none.
"""

from typing import Final

from fieldrig_devices.iec.host import NativeBlock, Results
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.libraries.cam import Pins, axis_of, cam_of
from fieldrig_devices.max4.libraries.follower import CamFollower
from fieldrig_devices.max4.libraries.motion import Motion
from fieldrig_devices.max4.libraries.results import Result
from fieldrig_devices.max4.libraries.track import Cam, Setpos, Stage

TEXT: Final = """
FUNCTION_BLOCK MultiCam3
VAR_INPUT
    lEncId : DINT;
    lrXFactor : LREAL := 1.0;
    lAxisId1 : DINT;
    lProfilId1 : DINT;
    lrYFactor1 : LREAL := 1.0;
    lAxisId2 : DINT;
    lProfilId2 : DINT;
    lrYFactor2 : LREAL := 1.0;
    lAxisId3 : DINT;
    lProfilId3 : DINT;
    lrYFactor3 : LREAL := 1.0;
    bReset : BOOL;
END_VAR
VAR_OUTPUT
    lResult : DINT;
    bActive : BOOL;     (* one of the cams moves its axis *)
    bDone : BOOL;       (* all of them are over *)
END_VAR
{native}
END_FUNCTION_BLOCK
"""
Job = tuple[Axis, Cam, float]
Slave = tuple[int, int, float]
"""The logical address of an axis, its profile, and the height of its cam."""


class _MultiCams:
    """All calls of MultiCam3 in a program, by the addresses of their instances."""

    def __init__(self, motion: Motion) -> None:
        self._motion = motion
        self._taken: dict[int, list[Cam]] = {}
        self._waiting: dict[int, tuple[tuple[int, ...], list[CamFollower]]] = {}
        """The logical addresses of the axes that a job waits for, and the axes."""

    def run(
        self,
        address: int,
        encoder: int, length: float,
        axis_1: int, profile_1: int, height_1: float,
        axis_2: int, profile_2: int, height_2: float,
        axis_3: int, profile_3: int, height_3: float,
        is_reset: bool,
    ) -> Results:  # fmt: skip
        if is_reset:
            self._taken.pop(address, None)
            self._waiting.pop(address, None)
        if address not in self._taken:
            slaves = [(axis_1, profile_1, height_1), (axis_2, profile_2, height_2), (axis_3, profile_3, height_3)]
            result = self._start(address, encoder, length, slaves)
            if result is not Result.TAKEN:
                return int(result), False, False
        stages = [cam.stage for cam in self._taken[address]]
        is_over = all(stage in (Stage.ENDED, Stage.DROPPED) for stage in stages)
        return int(Result.TAKEN), Stage.ACTIVE in stages, is_over

    def forget(self) -> None:
        self._taken.clear()
        self._waiting.clear()

    def _start(self, address: int, encoder: int, length: float, slaves: list[Slave]) -> Result:
        axes = tuple(axis for axis, _, _ in slaves)
        if self._has_to_wait(address, axes):
            return Result.WAITING
        jobs = self._jobs_of(encoder, length, slaves)
        result = jobs if isinstance(jobs, Result) else self._begin(address, axes, jobs)
        if result is Result.TAKEN:
            self._waiting.pop(address, None)
        return result

    def _jobs_of(self, encoder: int, length: float, slaves: list[Slave]) -> list[Job] | Result:
        jobs: list[Job] = []
        for address, profile, height in slaves:
            if not address:
                continue
            mode = Setpos.ABSOLUTE
            pins = Pins(
                address, encoder, profile, 0.0, 0.0, length, height,
                min(length, 0.0), max(length, 0.0), True, True, mode, 0.0, mode, 0.0, False,
            )  # fmt: skip
            axis = axis_of(self._motion, address)
            if isinstance(axis, Result):
                return axis
            cam = cam_of(self._motion, pins)
            if isinstance(cam, Result):
                return cam
            jobs.append((axis[0], cam, axis[1]))
        return jobs or Result.NO_AXIS

    def _has_to_wait(self, address: int, axes: tuple[int, ...]) -> bool:
        wanted, followers = self._waiting.get(address, ((), []))
        return wanted == axes and not all(follower.has_room for follower in followers)

    def _begin(self, address: int, axes: tuple[int, ...], jobs: list[Job]) -> Result:
        followers = [self._motion.follower(axis) for axis, _, _ in jobs]
        if len(set(map(id, followers))) < len(followers):
            return Result.NO_AXIS
        if not all(follower.has_room for follower in followers):
            self._waiting[address] = axes, followers
            return Result.WAITING
        for follower, (_, cam, scale) in zip(followers, jobs, strict=True):
            follower.take(cam, scale)
        self._taken[address] = [cam for _, cam, _ in jobs]
        return Result.TAKEN


def multi_cam_block(motion: Motion) -> NativeBlock:
    cams = _MultiCams(motion)
    return NativeBlock(cams.run, cost_ns=12_000, forget=cams.forget)
