"""How much of a cycle an axis needs: all of it, the step of its mode, or only the motion.

This is the only fast form of a CiA 402 axis.  Most cycles at a steady speed change nothing but the position, so the
mode of operation names a band of actual velocities within which this holds, and the axis checks the band once per
cycle.  Any event that could end it (a written object, a control word, another mode, a probe, an error) empties the
band.
"""

import math
from collections.abc import Callable
from typing import Final

from fieldrig.shortcuts import Shortcut

PACE: Final = Shortcut("cia402.pace", "an axis without an event does the step of its mode, or only moves")
NO_BAND: Final = (math.inf, -math.inf)
"""The empty band, which contains no velocity."""


class Pace:
    __slots__ = ("high", "is_always_whole", "is_awake", "low", "on_wake")

    def __init__(self) -> None:
        self.is_always_whole = not PACE.is_taken
        self.is_awake = True
        """True if the next cycle has to be a whole one."""
        self.low, self.high = NO_BAND
        """The limits of the band, which do not belong to it."""
        self.on_wake: Callable[[], None] = lambda: None
        """Called with each `wake`, for an owner that runs no cycles while nothing can change."""

    def wake(self) -> None:
        """Make the next cycle a whole one, which leaves the band."""
        self.is_awake = True
        self.on_wake()

    def leave_band(self) -> None:
        """Let the mode take its whole step in the next cycle."""
        self.low, self.high = NO_BAND
