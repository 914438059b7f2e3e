"""The instant at which something that a drive moves has gone a way: a belt, a web, or a cam disc."""

from collections.abc import Callable
from math import ceil, inf
from typing import Final

from fieldrig.clock import NEVER_NS, S
from fieldrig_bus.wires import Signal

SHORTEST_WAY: Final = 1e-9
"""A way counts as at least this long, so that a slow drive does not keep the rig busy."""


def next_instant(drive: Signal, now_ns: int, way: Callable[[int], float], scale: float = 1.0) -> int | None:
    """Return when the drive reaches the next place, or None if it does not as it moves now.

    `way(1)` and `way(-1)` are the ways to the next place in both directions; a unit of the drive moves by `scale`.
    """
    speed, later_ns = drive.speed_at(now_ns), now_ns + S
    acceleration = drive.speed_at(later_ns) - speed
    seconds = min(
        seconds_to(max(way(side), SHORTEST_WAY), side * speed * scale, side * acceleration * scale) for side in (1, -1)
    )
    return now_ns + max(ceil(seconds * S), 1) if seconds * S < NEVER_NS else None


def seconds_to(way: float, speed: float, acceleration: float) -> float:
    """The time until a motion has gone this way, from 0 up, in its positive direction; infinite if it never does."""
    square = speed * speed + 2 * acceleration * way
    if square < 0:
        return inf
    root = square**0.5
    if speed < 0:  # it turns first
        return (root - speed) / acceleration if acceleration > 0 else inf
    return 2 * way / (speed + root) if speed + root > 0 else inf
