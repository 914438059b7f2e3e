"""The blocks CAM and SLAVECAM: one axis follows one encoder through one cam (PD-186, PD-190, PD-191).

A call with bReset begins a new job, which an axis takes at once or after its present cam (lResult 0), or cannot take
yet (1).  Calls without bReset then try the job again, with the present inputs, until it is taken; after that they only
show how far it is.  While the axis has no room, such a call answers 1 without a look at its other inputs.  So the first
call may have bReset TRUE and all others FALSE, as in the manual's program.

Besides lResult the outputs are ours: bActive is TRUE while this cam moves the axis, and bDone once it is over.

SLAVECAM is a cam that is added to the cams of an axis; its name and details are ours.  It can only begin while a cam of
CAM or MultiCam3 moves the axis; otherwise lResult is -7.  What counts is its way from its begin, so iYSetposMode and
lrYSetposPos have no effect.  A new slave cam replaces the one before it at once, and what has been added remains.
"""

from collections.abc import Callable
from math import inf
from typing import Final, NamedTuple

from fieldrig_devices.iec.host import NativeBlock, Results
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.libraries.follower import CamFollower
from fieldrig_devices.max4.libraries.motion import LARGEST, SMALLEST_FACTOR, Motion, is_usable
from fieldrig_devices.max4.libraries.results import Result
from fieldrig_devices.max4.libraries.track import Cam, Setpos, Stage

PINS: Final = """
VAR_INPUT
    lAxisId : DINT;                 (* logical address of the axis, such as _ConveyerBelt *)
    lEncId : DINT;                  (* logical address of the encoder that it follows *)
    lProfilId : DINT;               (* from ProfilLoad *)
    lrXOffset : LREAL;
    lrYOffset : LREAL;
    lrXFactor : LREAL := 1.0;       (* length of the cam on the side of the master *)
    lrYFactor : LREAL := 1.0;       (* height of the cam on the side of the axis *)
    lrXLimMin : LREAL;
    lrXLimMax : LREAL;
    bXLimMinOn : BOOL;
    bXLimMaxOn : BOOL;
    iXSetposMode : INT;             (* NO_SETPOS, ABSOLUTE, RELATIVE *)
    lrXSetposPos : LREAL;
    iYSetposMode : INT;
    lrYSetposPos : LREAL;
    bReset : BOOL;                  (* TRUE begins a new job *)
END_VAR
VAR_OUTPUT
    lResult : DINT;                 (* 0 taken, 1 call again, below 0 an error *)
    bActive : BOOL;                 (* this cam moves the axis *)
    bDone : BOOL;                   (* this cam is over *)
END_VAR
{native}
END_FUNCTION_BLOCK
"""
TEXT: Final = f"FUNCTION_BLOCK CAM{PINS}FUNCTION_BLOCK SLAVECAM{PINS}"


class Pins(NamedTuple):
    """The inputs, in the order of their declaration."""

    axis: int
    encoder: int
    profile: int
    x_offset: float
    y_offset: float
    x_factor: float
    y_factor: float
    x_low: float
    x_high: float
    is_low_on: bool
    is_high_on: bool
    x_mode: int
    x_setpos: float
    y_mode: int
    y_setpos: float
    is_reset: bool


def cam_of(motion: Motion, pins: Pins) -> Cam | Result:
    """The job that the inputs describe, or what is wrong with them."""
    master = motion.controller.encoder(pins.encoder)
    if master is None:
        return Result.NO_ENCODER
    try:
        profile = motion.profiles[pins.profile]
    except KeyError:
        return Result.NO_PROFILE
    if not is_usable(pins.x_offset, pins.y_offset, pins.x_factor, pins.y_factor, pins.x_setpos, pins.y_setpos):
        return Result.WRONG_VALUE
    low, high = pins.x_low if pins.is_low_on else -inf, pins.x_high if pins.is_high_on else inf
    if abs(pins.x_factor) < SMALLEST_FACTOR or not low < high or not is_limit(low) or not is_limit(high):
        return Result.WRONG_VALUE
    try:
        x_mode, y_mode = Setpos(pins.x_mode), Setpos(pins.y_mode)
    except ValueError:
        return Result.WRONG_MODE
    return Cam(
        master, profile, pins.x_offset, pins.y_offset, pins.x_factor, pins.y_factor, low, high,
        x_mode, pins.x_setpos, y_mode, pins.y_setpos,
    )  # fmt: skip


def is_limit(limit: float) -> bool:
    """True for a limit that is off, and for one that a master can reach."""
    return limit in (-inf, inf) or abs(limit) <= LARGEST


class Jobs:
    """The last job of each instance of a block, by its address."""

    def __init__(self) -> None:
        self._taken: dict[int, Cam] = {}
        self._waiting: dict[int, tuple[int, CamFollower]] = {}
        """The logical address of the axis that a job waits for, and the axis."""

    def of(self, address: int, *, is_reset: bool) -> Cam | None:
        """The job that was taken, if this call only looks at it."""
        if is_reset:
            self._taken.pop(address, None)
            self._waiting.pop(address, None)
        return self._taken.get(address)

    def has_to_wait(self, address: int, axis: int) -> bool:
        """True while the axis still has no room for a job that waits for it."""
        waits_for, follower = self._waiting.get(address, (0, None))
        return follower is not None and waits_for == axis and not follower.has_room

    def wait(self, address: int, axis: int, follower: CamFollower) -> None:
        self._waiting[address] = axis, follower

    def keep(self, address: int, cam: Cam) -> None:
        self._taken[address] = cam
        self._waiting.pop(address, None)

    def clear(self) -> None:
        self._taken.clear()
        self._waiting.clear()


def shown(result: Result, cam: Cam | None = None) -> Results:
    """The outputs lResult, bActive and bDone."""
    stage = Stage.WAITING if cam is None else cam.stage
    return int(result), stage is Stage.ACTIVE, stage in (Stage.ENDED, Stage.DROPPED)


def axis_of(motion: Motion, address: int) -> tuple[Axis, float] | Result:
    """The axis under control with its increments per unit, or what is wrong with it."""
    axis = motion.controller.axis(address)
    if axis is None:
        return Result.NO_AXIS
    if not axis.is_controlled:
        return Result.NOT_CONTROLLED
    scale = motion.controller.increments_per_unit(axis)
    return (axis, scale) if scale and is_usable(scale) else Result.WRONG_VALUE


def cam_block(motion: Motion, give: Callable[[CamFollower, Cam, float], Result] = CamFollower.take) -> NativeBlock:
    """A block with the pins of CAM; `give` hands the job to the axis."""
    jobs = Jobs()

    def run(address: int, *inputs: bool | int | float) -> Results:
        pins = Pins(*inputs)  # type: ignore[arg-type]  # in the order of the declaration
        taken = jobs.of(address, is_reset=pins.is_reset)
        if taken is not None:
            return shown(Result.TAKEN, taken)
        if jobs.has_to_wait(address, pins.axis):
            return shown(Result.WAITING)
        axis = axis_of(motion, pins.axis)
        if isinstance(axis, Result):
            return shown(axis)
        cam = cam_of(motion, pins)
        if isinstance(cam, Result):
            return shown(cam)
        follower = motion.follower(axis[0])
        result = give(follower, cam, axis[1])
        if result is Result.TAKEN:
            jobs.keep(address, cam)
        elif result is Result.WAITING:
            jobs.wait(address, pins.axis, follower)
        return shown(result, cam)

    return NativeBlock(run, cost_ns=8_000, forget=jobs.clear)


def slave_cam_block(motion: Motion) -> NativeBlock:
    return cam_block(motion, CamFollower.overlay)
