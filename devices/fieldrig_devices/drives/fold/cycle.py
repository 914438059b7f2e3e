"""The compiled cycles of the fold, cached: drives with the same motor and load share them."""

from collections.abc import Callable
from functools import lru_cache
from typing import cast

from fieldrig_devices.drives.fold.text import Numbers, PublishedMotion, compiled, cycle_text, following_text
from fieldrig_devices.drives.loops import Arrangement, Gains, Limits, MovingAxis, Plant

Cycle = Callable[[MovingAxis], bool]
"""Move the axis by one cycle; False, with nothing changed, if a limit may be met on the way."""
FollowingCycle = Callable[[MovingAxis, int, float, int, PublishedMotion | None], bytes | None]
"""Move the axis by one cycle, then set its next set position.

The arguments are the axis, the set position modulo 2^32, the largest following error in rad, the present instant in
nanoseconds, and the motion of the load as last published.  The result is the packed numbers.  It is None, with nothing
changed, if the axis is at rest, if a limit may be met, if the following error reaches its limit, or if the load has to
be published again.
"""


@lru_cache(maxsize=256)
def folded(plant: Plant, gains: Gains, limits: Limits, steps: int, dry_nm: float = 0.0) -> Cycle:
    """Return the folded cycle; compiling it takes some milliseconds.

    With dry friction it also refuses a cycle in which the direction may change.
    """
    return cast(Cycle, compiled(cycle_text(plant, gains, limits, steps, dry_nm), "cycle"))


@lru_cache(maxsize=256)
def following(arrangement: Arrangement, numbers: Numbers, *, is_published: bool) -> FollowingCycle:
    """Return the folded cycle that also takes the next set position and packs its feedback.

    With `is_published`, it refuses a cycle after which the published motion of the load no longer holds.
    """
    text = following_text(arrangement, numbers, is_published=is_published)
    return cast(FollowingCycle, compiled(text, "following", pack=numbers.pack))
