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


def multi_cam_block(motion: Motion) -> NativeBlock:
    taken: dict[int, list[Cam]] = {}
    waiting: dict[int, tuple[tuple[int, int, int], list[CamFollower]]] = {}
    """The logical addresses of the axes that a job waits for, and the axes."""

    def jobs_of(encoder: int, length: float, slaves: list[tuple[int, int, float]]) -> list[Job] | Result:
        jobs: list[Job] = []
        for address, profile, height in slaves:
            if not address:
                continue
            mode = Setpos.ABSOLUTE
            pins = Pins(
                address, encoder, profile, 0.0, 0.0, length, height,
                min(length, 0.0), max(length, 0.0), True, True, mode, 0.0, mode, 0.0, False,
            )  # fmt: skip
            axis = axis_of(motion, address)
            if isinstance(axis, Result):
                return axis
            cam = cam_of(motion, pins)
            if isinstance(cam, Result):
                return cam
            jobs.append((axis[0], cam, axis[1]))
        return jobs or Result.NO_AXIS

    def has_to_wait(address: int, axes: tuple[int, int, int]) -> bool:
        wanted, followers = waiting.get(address, ((0, 0, 0), []))
        return wanted == axes and not all(follower.has_room for follower in followers)

    def begin(address: int, axes: tuple[int, int, int], jobs: list[Job]) -> Result:
        followers = [motion.follower(axis) for axis, _, _ in jobs]
        if len(set(map(id, followers))) < len(followers):
            return Result.NO_AXIS
        if not all(follower.has_room for follower in followers):
            waiting[address] = axes, followers
            return Result.WAITING
        for follower, (_, cam, scale) in zip(followers, jobs, strict=True):
            follower.take(cam, scale)
        taken[address] = [cam for _, cam, _ in jobs]
        return Result.TAKEN

    def run(
        address: int,
        encoder: int, length: float,
        axis_1: int, profile_1: int, height_1: float,
        axis_2: int, profile_2: int, height_2: float,
        axis_3: int, profile_3: int, height_3: float,
        is_reset: bool,
    ) -> Results:  # fmt: skip
        if is_reset:
            taken.pop(address, None)
            waiting.pop(address, None)
        axes = axis_1, axis_2, axis_3
        if address not in taken:
            if has_to_wait(address, axes):
                return int(Result.WAITING), False, False
            slaves = [(axis_1, profile_1, height_1), (axis_2, profile_2, height_2), (axis_3, profile_3, height_3)]
            jobs = jobs_of(encoder, length, slaves)
            result = jobs if isinstance(jobs, Result) else begin(address, axes, jobs)
            if result is not Result.TAKEN:
                return int(result), False, False
            waiting.pop(address, None)
        stages = [cam.stage for cam in taken[address]]
        is_over = all(stage in (Stage.ENDED, Stage.DROPPED) for stage in stages)
        return int(Result.TAKEN), Stage.ACTIVE in stages, is_over

    def forget() -> None:
        taken.clear()
        waiting.clear()

    return NativeBlock(run, cost_ns=12_000, forget=forget)
