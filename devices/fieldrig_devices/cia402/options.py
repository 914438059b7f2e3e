"""Option codes 605Ah to 605Eh: how an axis is brought to rest, and the state it is left in.

Source: CiA 402-2, chapter 'device control'.  Our choice: stops at the current or voltage limit (3, 4, 7, 8) are ramps
with the maximum deceleration (60C6h).
"""

from enum import Enum, auto
from typing import Final, NamedTuple


class Ramp(Enum):
    """Ramps that bring an axis to rest."""

    SLOW_DOWN = auto()
    QUICK_STOP = auto()
    LIMIT = auto()


# 605Ah: the ramp, and whether the axis stays in 'quick stop active'.  0 disables the drive function.
QUICK_STOP_OPTIONS: Final = {
    1: (Ramp.SLOW_DOWN, False),
    2: (Ramp.QUICK_STOP, False),
    3: (Ramp.LIMIT, False),
    4: (Ramp.LIMIT, False),
    5: (Ramp.SLOW_DOWN, True),
    6: (Ramp.QUICK_STOP, True),
    7: (Ramp.LIMIT, True),
    8: (Ramp.LIMIT, True),
}
SHUTDOWN_OPTIONS: Final = {1: Ramp.SLOW_DOWN}
"""Ramps by shutdown option code (605Bh); 0 disables the drive function."""
DISABLE_OPTIONS: Final = {1: Ramp.SLOW_DOWN}
"""Ramps by disable operation option code (605Ch); 0 disables the drive function."""
HALT_OPTIONS: Final = {1: Ramp.SLOW_DOWN, 2: Ramp.QUICK_STOP, 3: Ramp.LIMIT, 4: Ramp.LIMIT}
"""Ramps by halt option code (605Dh)."""
FAULT_OPTIONS: Final = {1: Ramp.SLOW_DOWN, 2: Ramp.QUICK_STOP, 3: Ramp.LIMIT, 4: Ramp.LIMIT}
"""Ramps by fault reaction option code (605Eh); 0 disables the drive function."""


class Options(NamedTuple):
    """The present option codes; a code that is in none of the tables counts as 0."""

    quick_stop: int = 2
    shutdown: int = 0
    disable: int = 1
    fault: int = 2
