"""Motion profiles with a limited jerk where the limits have one, and trapezoids otherwise.

`acceleration` is the present one, which only a limited jerk takes into account: a trapezoid changes it at once.
"""

import math

from fieldrig_devices.motion import jerk, profile
from fieldrig_devices.motion.profile import Limits, Profile


def change_speed(speed: float, wanted: float, limits: Limits, acceleration: float) -> Profile:
    """Return the profile from one speed to another."""
    if limits.jerk == math.inf:
        return profile.change_speed(speed, wanted, limits)
    return jerk.change_speed(speed, wanted, limits, acceleration)


def brake(speed: float, limits: Limits, acceleration: float) -> Profile:
    return change_speed(speed, 0.0, limits, acceleration)


def move(distance: float, speed: float, limits: Limits, acceleration: float) -> Profile:
    """Return the profile that ends at rest at `distance`."""
    if limits.jerk == math.inf:
        return profile.move(distance, speed, limits)
    return jerk.move(distance, speed, limits, acceleration)


def pass_through(distance: float, speed: float, limits: Limits, acceleration: float) -> Profile:
    """Return the profile over `distance` that keeps its speed at the end.  `distance` must lie ahead of the axis."""
    if limits.jerk == math.inf:
        return profile.pass_through(distance, speed, limits)
    return jerk.pass_through(distance, speed, limits, acceleration)
