"""How a drive behaves where CiA 402 leaves the choice to its maker, as one object that all parts of an axis read.

The defaults are the baseline: everything by the book.  A drive that differs gets another
`Behaviour`, and no part of the engine asks which drive it is.
"""

from dataclasses import dataclass
from typing import Final

from fieldrig_devices.cia402.homing_methods import STANDARD_METHODS


@dataclass(frozen=True, slots=True)
class Behaviour:
    """The choices of one kind of drive."""

    modes: frozenset[int] | None = None
    """Numbers of the modes of operation that the drive has (6060h); None for all that its motor can follow.

    A number that the standard does not know is a mode of the maker, in which the axis stands.
    """
    homing_methods: frozenset[int] = STANDARD_METHODS
    """Numbers of the homing methods that the drive has (6098h), besides 0, which is always accepted."""
    homing_torque: int = 500
    """Torque that tells a mechanical stop from a free way in the homing methods -1 to -4, in 0.1 % of the rated one."""
    passes_switched_on: bool = True
    """True if 'enable operation' (0Fh) in 'ready to switch on' takes transitions 3 and 4; otherwise it takes 3 only."""
    has_ramp_bits: bool = True
    """True if bits 4 to 6 of the control word act in velocity mode (vl); otherwise its ramp always follows 6042h."""
    velocity_unit: float | None = None
    """Unit of velocities, in turns of the motor per second; None for user units of positions per second."""
    acceleration_unit: float | None = None
    """Unit of accelerations, in turns of the motor per second squared; None for user units per second squared."""
    has_feed_constant: bool = True
    """False if a feed constant (6092h) of one unit for a turn counts as not set, so that user units are increments."""
    following_error_code: int = 0x8611
    """Error code in 603Fh of a following error that is too large."""


BASELINE: Final = Behaviour()
"""The behaviour of an axis of which nothing else is known."""
