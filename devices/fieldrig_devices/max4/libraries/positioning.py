"""Positioning functions (Basic.lib, PD-203): an axis moves to a position, at a speed, or to rest.

The manual names the library and none of its functions, so these are ours.  Positions are in the units of the axis, and
the motion is that of `axes/positioning.py`: speed, acceleration and deceleration are limited, jerk is not.  A function
takes effect at once, also while the axis is on a cam; lResult is that of `results.py`.
"""

from collections.abc import Callable, Mapping
from typing import Final

from fieldrig_devices.iec.host import NativeFunction, Results
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.axes.positioning import Positioner
from fieldrig_devices.max4.libraries.cam import axis_of
from fieldrig_devices.max4.libraries.motion import Motion, is_usable
from fieldrig_devices.max4.libraries.results import Result
from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.motion.travel import Travel

_LIMITS: Final = """
    lrVelocity : LREAL;         (* units/s *)
    lrAcceleration : LREAL;     (* units/s2 *)
    lrDeceleration : LREAL;
"""

TEXT: Final = f"""
(* To an absolute position of the axis; lResult as of CAM. *)
FUNCTION PosAbsolute : DINT
VAR_INPUT
    lAxisId : DINT;
    lrPosition : LREAL;
    {_LIMITS.strip()}
END_VAR
{{native}}
END_FUNCTION

(* By a distance from the present set position. *)
FUNCTION PosRelative : DINT
VAR_INPUT
    lAxisId : DINT;
    lrDistance : LREAL;
    {_LIMITS.strip()}
END_VAR
{{native}}
END_FUNCTION

(* At a speed, whose sign is the direction. *)
FUNCTION PosVelocity : DINT
VAR_INPUT
    lAxisId : DINT;
    {_LIMITS.strip()}
END_VAR
{{native}}
END_FUNCTION

(* To rest. *)
FUNCTION PosStop : DINT
VAR_INPUT
    lAxisId : DINT;
    lrDeceleration : LREAL;
END_VAR
{{native}}
END_FUNCTION

(* TRUE once the last of these functions has reached its position or its speed. *)
FUNCTION PosDone : BOOL
VAR_INPUT
    lAxisId : DINT;
END_VAR
{{native}}
END_FUNCTION
"""
SMALLEST: Final = 1e-3
"""Smallest speed and acceleration, in increments per second and second squared."""


class _NoSwitches:
    """An axis of the program has no limit switches of its own; the program looks at its inputs."""

    inputs = 0


def functions(motion: Motion) -> Mapping[str, NativeFunction]:
    positioners: dict[int, Positioner] = {}

    def positioner(axis: Axis) -> Positioner:
        if axis.log_adr not in positioners:
            positioners[axis.log_adr] = Positioner(axis, motion.controller.cycle_ns, Travel(_NoSwitches()))
        return positioners[axis.log_adr]

    def begin(address: int, way: float, limits: Limits, start: Callable[[Positioner, float, Limits], None]) -> Results:
        """Scale the command to increments and start it."""
        scaled_axis = axis_of(motion, address)
        if isinstance(scaled_axis, Result):
            return (int(scaled_axis),)
        axis, scale = scaled_axis
        scaled = Limits(*(value * abs(scale) for value in limits[:3]))
        if not is_usable(way * scale, *scaled[:3]) or min(scaled) < SMALLEST:
            return (int(Result.WRONG_VALUE),)
        start(positioner(axis), way * scale, scaled)
        return (int(Result.TAKEN),)

    def absolute(address: int, position: float, *limits: float) -> Results:
        return begin(address, position, Limits(*limits), Positioner.move_to)

    def relative(address: int, distance: float, *limits: float) -> Results:
        return begin(address, distance, Limits(*limits), Positioner.move_by)

    def velocity(address: int, speed: float, *ramps: float) -> Results:
        return begin(address, speed, Limits(abs(speed) or 1.0, *ramps), Positioner.run)

    def stop(address: int, deceleration: float) -> Results:
        limits = Limits(deceleration, deceleration, deceleration)
        return begin(address, 0.0, limits, lambda positioner, _, scaled: positioner.stop(scaled))

    def done(address: int) -> Results:
        axis = motion.controller.axis(address)
        moving = None if axis is None else positioners.get(address)
        return (moving is not None and moving.has_arrived,)

    return {
        "posabsolute": NativeFunction(absolute, cost_ns=10_000),
        "posrelative": NativeFunction(relative, cost_ns=10_000),
        "posvelocity": NativeFunction(velocity, cost_ns=10_000),
        "posstop": NativeFunction(stop, cost_ns=10_000),
        "posdone": NativeFunction(done),
    }
