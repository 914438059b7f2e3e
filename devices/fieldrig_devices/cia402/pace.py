"""How much of its cycle an axis needs: all of it, what its mode does, or only that the motion goes on.

This is the one fast form of a CiA 402 axis.  Most cycles of an axis at a steady speed change nothing but the place, so
the mode of operation names a band of actual velocities within which that is so, and the axis checks the band once in
each cycle.  Whatever could end it (a written object, a control word, another mode, a probe, an error) empties the band.
"""

import math
from typing import Final

NO_BAND: Final = (math.inf, -math.inf)
"""No velocity is in it."""


class Pace:
    __slots__ = ("high", "is_awake", "low")

    def __init__(self) -> None:
        self.is_awake = True
        """The next cycle has to look at more than where the axis moves."""
        self.low, self.high = NO_BAND
        """The band, without its ends."""

    def wake(self) -> None:
        self.is_awake = True
        self.low, self.high = NO_BAND

    def leave_band(self) -> None:
        """The mode has to look at what has changed."""
        self.low, self.high = NO_BAND
