"""Profiles through support points: a cubic spline, twice continuously differentiable (PD-185, CSpline).

The curve is natural (no second derivative at its ends), or has given slopes there.  Its x axis is normalised: the first
support point is at z = 0 and the last one at z = 1.  Its y values remain as they are.

A file of support points has one point in each line, x and y separated by blanks, tabs or a semicolon.  A line "slopes A
B" gives the slopes dy/dz at both ends; what follows a # is a comment.  The format is ours, as the manual gives none.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import isfinite
from typing import Final

from fieldrig_devices.motion.curves.pieces import Piece
from fieldrig_devices.motion.curves.profile import Profile

MOST_POINTS: Final = 4096

Point = tuple[float, float]


def spline(points: Sequence[Point], slopes: tuple[float, float] | None = None) -> Profile:
    """The profile through `points`.  ValueError for fewer than two, and for x values that do not rise."""
    if not 2 <= len(points) <= MOST_POINTS:
        raise ValueError(f"expected 2 to {MOST_POINTS} support points, got {len(points)}")
    if not all(isfinite(value) for point in (*points, slopes or (0.0, 0.0)) for value in point):
        raise ValueError("expected finite numbers")
    first, last = points[0][0], points[-1][0]
    places = [(x - first) / (last - first) if last > first else 0.0 for x, _ in points]
    values = [y for _, y in points]
    widths = [right - left for left, right in pairwise(places)]
    for number, width in enumerate(widths, start=1):
        if width <= 0:
            raise ValueError(f"expected rising x values, got {points[number][0]:g} behind {points[number - 1][0]:g}")
    bends = _second_derivatives(widths, values, slopes)
    pieces = []
    for k, width in enumerate(widths):
        rise, left, right = values[k + 1] - values[k], bends[k], bends[k + 1]
        slope = rise / width - width * (2 * left + right) / 6
        pieces.append(Piece(width, (values[k], slope, left / 2, (right - left) / (6 * width))))
    found = Profile(pieces)
    if not all(isfinite(power) for piece in pieces for power in piece.powers):
        raise ValueError("expected support points that a curve can pass through, got points that are too close")
    return found


def _second_derivatives(
    widths: Sequence[float], values: Sequence[float], slopes: tuple[float, float] | None
) -> list[float]:
    """Solve the tridiagonal equations of the second derivatives at the support points."""
    gradients = [(values[k + 1] - values[k]) / width for k, width in enumerate(widths)]
    below, middle, above, right = [0.0], [1.0], [0.0], [0.0]
    if slopes is not None:
        middle, above, right = [2 * widths[0]], [widths[0]], [6 * (gradients[0] - slopes[0])]
    for k in range(1, len(widths)):
        below.append(widths[k - 1])
        middle.append(2 * (widths[k - 1] + widths[k]))
        above.append(widths[k])
        right.append(6 * (gradients[k] - gradients[k - 1]))
    if slopes is None:
        below.append(0.0)
        middle.append(1.0)
        right.append(0.0)
    else:
        below.append(widths[-1])
        middle.append(2 * widths[-1])
        right.append(6 * (slopes[1] - gradients[-1]))
    for k in range(1, len(middle)):
        share = below[k] / middle[k - 1]
        middle[k] -= share * above[k - 1]
        right[k] -= share * right[k - 1]
    found = [right[-1] / middle[-1]]
    for k in range(len(middle) - 2, -1, -1):
        found.append((right[k] - above[k] * found[-1]) / middle[k])
    return found[::-1]


def profile_of_file(data: bytes) -> Profile:
    """The profile in a file of support points.  ValueError, with the line, for anything else."""
    return spline(*support_points(data))


def support_points(data: bytes) -> tuple[list[Point], tuple[float, float] | None]:
    """The points in a file, and the slopes at its ends if it gives them.  ValueError, with the line, for all else."""
    points: list[Point] = []
    slopes: tuple[float, float] | None = None
    text = data.partition(b"\x1a")[0].rstrip(b"\0")  # as DOS ends a text
    for number, line in enumerate(text.decode("latin-1").splitlines(), start=1):
        words = line.partition("#")[0].replace(";", " ").split()
        is_slopes = bool(words) and words[0].casefold() == "slopes"
        if not words:
            continue
        try:
            first, second = map(float, words[1:] if is_slopes else words)
        except ValueError:
            raise ValueError(f"line {number}: expected two numbers, got {line[:40]!r}") from None
        if is_slopes:
            slopes = first, second
        elif len(points) == MOST_POINTS:
            raise ValueError(f"line {number}: expected at most {MOST_POINTS} support points")
        else:
            points.append((first, second))
    return points, slopes
