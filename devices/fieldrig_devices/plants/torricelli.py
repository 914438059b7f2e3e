"""Exact solutions for the level of an upright tank that is filled at a constant rate and drained through a hole.

Torricelli's law: the outflow is c * a * sqrt(2 * g * h) = k * sqrt(h), with the hole's area a, its discharge
coefficient c and the level h above it.  SI units throughout.
"""

import math
from typing import NamedTuple

GRAVITY = 9.80665  # m/s2, ISO 80000-3


def root_coefficient(effective_area_m2: float) -> float:
    """Return k of a hole with c * a = `effective_area_m2`, the outflow in m3/s at a level of 1 m."""
    return effective_area_m2 * math.sqrt(2 * GRAVITY)


class Moved(NamedTuple):
    """The change of a tank over some time."""

    level_m: float
    out_m3: float
    over_m3: float


def moved(level_m: float, inflow: float, k: float, area_m2: float, height_m: float, seconds: float) -> Moved:
    """Return the exact change under a constant `inflow` in m3/s and an outflow of `k * sqrt(level)`."""
    root = root_after(math.sqrt(level_m), inflow, k, area_m2, seconds)
    after_m = level_m + inflow * seconds / area_m2 if k == 0 else root * root
    if after_m <= height_m:
        return Moved(after_m, max(0.0, inflow * seconds - area_m2 * (after_m - level_m)), 0.0)
    rising = seconds_to(math.sqrt(height_m), math.sqrt(level_m), inflow, k, area_m2)
    full = max(0.0, seconds - rising)
    drained = k * math.sqrt(height_m) * full
    out_m3 = max(0.0, inflow * rising - area_m2 * (height_m - level_m)) + drained
    return Moved(height_m, out_m3, max(0.0, inflow * full - drained))


def root_after(root: float, inflow: float, k: float, area_m2: float, seconds: float) -> float:
    """Return u = sqrt(h) after some time, from 2 * A * u * du/dt = q - k * u.

    Without inflow u falls linearly.  With it, towards ue = q / k, put ue - u = (ue - u0) * exp(-w): then
    u0 * w + (ue - u0) * (w + exp(-w) - 1) = k * t / (2 * A), which rises with w and is solved by Newton's method.
    """
    reach = k * seconds / (2 * area_m2)
    if inflow == 0:
        return max(0.0, root - reach)
    if k == 0 or reach == 0:
        return root
    rest = inflow / k
    apart = rest - root
    if apart == 0:
        return root
    # a start from which Newton's method does not overshoot: the solution for a small reach
    w = reach / root if apart < 0 else 2 * reach / (root + math.sqrt(root * root + 2 * apart * reach))
    for _ in range(60):
        change = (_reach_at(w, root, apart, rest) - reach) / _root_at(w, root, apart, rest)
        w = max(0.0, w - change)
        if abs(change) <= 1e-15 * w:
            break
    return _root_at(w, root, apart, rest)


def _root_at(w: float, root: float, apart: float, rest: float) -> float:
    """Return ue - (ue - u0) * exp(-w), in a form without cancellation."""
    return root - apart * math.expm1(-w) if w < 1 else rest - apart * math.exp(-w)


def _reach_at(w: float, root: float, apart: float, rest: float) -> float:
    """Return u0 * w + (ue - u0) * (w + exp(-w) - 1), in a form without cancellation."""
    return root * w + apart * _second_order(w) if w < 1 else rest * w + apart * math.expm1(-w)


def _second_order(w: float) -> float:
    """Return w + exp(-w) - 1, also for small w, where the terms cancel."""
    if w > 0.1:
        return w + math.expm1(-w)
    total = term = w * w / 2
    for n in range(3, 12):
        term *= -w / n
        total += term
    return total


def seconds_to(target: float, root: float, inflow: float, k: float, area_m2: float) -> float:
    """Return when u = sqrt(h) has risen from `root` to `target`, which it has to reach."""
    if k == 0:
        return area_m2 * (target * target - root * root) / inflow
    rest = inflow / k
    apart = rest - root
    w = -math.log1p((root - target) / apart)
    return 2 * area_m2 / k * _reach_at(w, root, apart, rest)
