"""The motion laws of VDI 2143 sheet 1 (PD-183), by the names under which `ProfilLoad` knows them.

Each law is normalised, f(0) = 0 and f(1) = 1.  A symmetric law is given by its accelerating half, from z = 0 to its
turning point at z = 1/2, because lambda (PD-188) stretches both halves separately (`profile.shaped`).  The manual names
'modisin' and 'straight'; the other names are ours.  Cv is the largest slope, Ca the largest second derivative.
"""

from typing import Final

from fieldrig_devices.motion.curves.laws import (
    inclined_sine,
    modified_sine,
    modified_trapezoid,
    polynomial_5,
    quadratic_parabola,
    simple_sine,
    straight,
)
from fieldrig_devices.motion.curves.laws.law import Law

LAWS: Final[dict[str, Law]] = {
    "straight": straight.LAW,
    "quadpara": quadratic_parabola.LAW,
    "simpsin": simple_sine.LAW,
    "inclsin": inclined_sine.LAW,
    "modisin": modified_sine.LAW,
    "moditrap": modified_trapezoid.LAW,
    "poly5": polynomial_5.LAW,
}
"""The laws by their names for `ProfilLoad`, in small letters."""
