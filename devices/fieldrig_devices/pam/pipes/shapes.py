"""The shape of a cam: a cubic spline through the points of a file (PAML-441, PAML-442, G-28).

The file has a line for each point, x and y from 0.0 to 1.0, separated by blanks, tabs or a semicolon; # begins a
comment.  A shape that ends one period above its beginning is periodic, so its slope is the same at both ends.  Every
other shape is natural: it has no second derivative at its ends.  A line "slopes A B" gives the slopes instead.
"""

from bisect import bisect_right
from collections.abc import Sequence

from fieldrig_devices.motion.curves.pieces import evaluator
from fieldrig_devices.motion.curves.profile import Profile
from fieldrig_devices.motion.curves.spline import Point, spline, support_points
from fieldrig_devices.pam.pipes.cam import Shape


def shape_of(data: bytes) -> Shape:
    """Return the curve in a file.  ValueError, with the line, for anything else."""
    points, slopes = support_points(data)
    if slopes is None and len(points) > 2 and abs(points[-1][1] - points[0][1] - 1.0) < 1e-9:
        slopes = periodic_slopes(points)
    return _compiled(spline(points, slopes))


def periodic_slopes(points: Sequence[Point]) -> tuple[float, float]:
    """Return the slope at both ends with which the second derivatives there are equal as well.

    Their difference is linear in the slope, so two curves give it.
    """
    flat, steep = (_bend_difference(spline(points, (slope, slope))) for slope in (0.0, 1.0))
    slope = flat / (flat - steep)
    return slope, slope


def _bend_difference(profile: Profile) -> float:
    """Return the second derivative at the end without that at the beginning."""
    first, last = profile.pieces[1], profile.pieces[-2]
    return 2 * last.powers[2] + 6 * last.powers[3] * last.length - 2 * first.powers[2]


def _compiled(profile: Profile) -> Shape:
    starts = profile.starts[1:-1]
    pieces = [(profile.origin(index), evaluator(profile.pieces[index])) for index in range(1, len(profile.pieces) - 1)]

    def at(x: float) -> float:
        begin, value = pieces[bisect_right(starts, x)]
        return value(x - begin)

    return at
