"""ProfilLoad and ProfilSetLambda (PD-187, PD-188), and the functions of CSpline for support points (PD-185).

The functions for support points, and ProfilSetSlopes for a motion from velocity to velocity, are ours.
"""

from collections.abc import Mapping
from typing import Final

from fieldrig_devices.iec.host import NativeFunction, Results
from fieldrig_devices.max4.libraries.motion import Motion, is_usable
from fieldrig_devices.motion.curves.laws.polynomial_5 import between
from fieldrig_devices.motion.curves.profile import Profile
from fieldrig_devices.motion.curves.spline import MOST_POINTS, Point, spline

PROFILES_TEXT: Final = """
(* The number of a new profile: a motion law such as 'modisin', or support points of a file; 0 if there is none. *)
FUNCTION ProfilLoad : DINT
VAR_INPUT
    sName : STRING;
END_VAR
{native}
END_FUNCTION

(* The turning point, from 0 to 1: 1.0 dwell to velocity, 0.5 dwell to dwell, 0.0 velocity to dwell. *)
FUNCTION ProfilSetLambda : BOOL
VAR_INPUT
    lProfilId : DINT;
    lrLambda : LREAL;
END_VAR
{native}
END_FUNCTION

(* The polynomial of the fifth degree with these slopes at its ends: velocity to velocity. *)
FUNCTION ProfilSetSlopes : BOOL
VAR_INPUT
    lProfilId : DINT;
    lrSlope0 : LREAL;
    lrSlope1 : LREAL;
END_VAR
{native}
END_FUNCTION
"""

SPLINE_TEXT: Final = """
(* A new list of support points. *)
FUNCTION CSplineBegin : DINT
{native}
END_FUNCTION

(* Adds a support point, in the order of rising x. *)
FUNCTION CSplinePoint : BOOL
VAR_INPUT
    lSplineId : DINT;
    lrX : LREAL;
    lrY : LREAL;
END_VAR
{native}
END_FUNCTION

(* The number of the profile through the support points, for CAM; 0 if there is none. *)
FUNCTION CSplineProfil : DINT
VAR_INPUT
    lSplineId : DINT;
END_VAR
{native}
END_FUNCTION
"""
MOST_LISTS: Final = 256


def profile_functions(motion: Motion) -> Mapping[str, NativeFunction]:
    profiles = motion.profiles

    def load(name: str) -> Results:
        return (profiles.load(name),)

    def set_lambda(number: int, turning_point: float) -> Results:
        return (profiles.set_lambda(number, turning_point),)

    def set_slopes(number: int, slope_0: float, slope_1: float) -> Results:
        is_valid = is_usable(slope_0, slope_1)
        return (is_valid and profiles.replace(number, Profile([between(slope_0, slope_1)])),)

    return {
        "profilload": NativeFunction(load, cost_ns=100_000),
        "profilsetlambda": NativeFunction(set_lambda, cost_ns=20_000),
        "profilsetslopes": NativeFunction(set_slopes, cost_ns=20_000),
    }


def spline_functions(motion: Motion) -> Mapping[str, NativeFunction]:
    lists: list[list[Point]] = []
    motion.on_clear(lists.clear)

    def begin() -> Results:
        if len(lists) == MOST_LISTS:
            return (0,)
        lists.append([])
        return (len(lists),)

    def add(number: int, x: float, y: float) -> Results:
        if not 1 <= number <= len(lists) or len(lists[number - 1]) == MOST_POINTS or not is_usable(x, y):
            return (False,)
        lists[number - 1].append((x, y))
        return (True,)

    def profile(number: int) -> Results:
        if not 1 <= number <= len(lists):
            return (0,)
        try:
            return (motion.profiles.add(spline(lists[number - 1])),)
        except ValueError:
            return (0,)

    return {
        "csplinebegin": NativeFunction(begin),
        "csplinepoint": NativeFunction(add),
        "csplineprofil": NativeFunction(profile, cost_ns=200_000),
    }
