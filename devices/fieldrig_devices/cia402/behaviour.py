"""How a drive behaves where CiA 402 leaves the choice to its maker, as one object that all parts of an axis read.

The defaults are the baseline: everything by the book.  A drive that differs gets another
`Behaviour`, and no part of the engine asks which drive it is.
"""

from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from fieldrig_devices.cia402.homing_methods import STANDARD_METHODS


class FaultReset(StrEnum):
    """How bit 7 of the control word resets a fault."""

    EDGE = "edge"
    LEVEL = "level"


class VoltageBit(StrEnum):
    """The meaning of bit 4 of the status word."""

    READY = "ready"
    """The drive can be enabled: it has power, and STO permits a torque."""
    DC_LINK = "dc_link"
    ENABLED = "enabled"
    """The drive function is enabled."""


class FreeBit(StrEnum):
    """The meaning of bit 14 or 15 of the status word, which the standard leaves to the makers."""

    NONE = "none"
    HOMED = "homed"
    BACKWARDS = "backwards"
    STANDSTILL = "standstill"
    WARNING = "warning"


class ModeDisplay(StrEnum):
    """When 6061h shows another mode."""

    AT_ONCE = "at_once"
    ENABLED = "enabled"
    """Not before 'operation enabled'; until then it shows the mode before."""


class ModeZero(StrEnum):
    """The meaning of mode 0 in 6060h."""

    NO_CHANGE = "no_change"
    REFUSED = "refused"
    NOT_ENABLED = "not_enabled"
    """It changes nothing, and the drive is not enabled before a mode has been chosen."""


class HomingBit(StrEnum):
    """When bit 10 of the status word is set in homing mode."""

    STANDING = "standing"
    """At standstill, also before homing has begun."""
    AFTER = "after"
    """Only after a method has ended."""
    NEVER = "never"


class LimitSwitch(StrEnum):
    """The effect of a limit switch outside of homing."""

    BLOCKS = "blocks"
    """The axis is stopped, its direction is barred, and bit 11 is set."""
    QUICK_STOP = "quick_stop"
    FAULT = "fault"
    SHOWN = "shown"
    """Bit 11 only."""
    IGNORED = "ignored"


class EmptyBuffer(StrEnum):
    """The end of a motion in interpolated position that has no further set-points."""

    STANDS = "stands"
    QUICK_STOP = "quick_stop"


@dataclass(frozen=True, slots=True)
class Behaviour:
    """The choices of one kind of drive."""

    modes: frozenset[int] | None = None
    """Numbers of the modes of operation that the drive has (6060h); None for all that its motor can follow.

    A number that the standard does not know is a mode of the maker, in which the axis stands.
    """
    homing_methods: frozenset[int] = STANDARD_METHODS
    """Numbers of the homing methods that the drive has (6098h)."""
    accepts_no_homing: bool = True
    """True if 6098h accepts 0, which is no homing."""
    homing_torque: int = 500
    """Torque that tells a mechanical stop from a free way in the homing methods -1 to -4, in 0.1 % of the rated one."""
    passes_switched_on: bool = True
    """True if 'enable operation' (0Fh) in 'ready to switch on' takes transitions 3 and 4; otherwise it takes 3 only."""
    has_ramp_bits: bool = True
    """True if bits 4 to 6 of the control word act in velocity mode (vl); otherwise its ramp always follows 6042h."""
    velocity_unit: float | None = None
    """Unit of velocities, in turns of the motor per second; None for that of 60A9h."""
    has_feed_constant: bool = True
    """False if a feed constant (6092h) of one unit for a turn counts as not set, so that user units are increments."""
    following_error_code: int = 0x8611
    """Error code in 603Fh of a following error that is too large."""
    control_cycle_ms: float = 0.0
    """The drive looks at the control word once in this time, in ms; 0: at once, with each word that arrives."""
    fault_reset: FaultReset = FaultReset.EDGE
    resets: int = 1
    """Number of fault resets until a fault is gone."""
    reset_lock_ms: float = 0.0
    """Time after a fault in which no reset is accepted, in ms."""
    quick_stop_resumes: bool = False
    """True if 0Fh enables the drive again while a quick stop that would end in 'switch on disabled' still brakes."""
    voltage_bit: VoltageBit = VoltageBit.READY
    remote_bit: bool = True
    """Bit 9 of the status word."""
    bit_14: FreeBit = FreeBit.NONE
    bit_15: FreeBit = FreeBit.NONE
    changes_mode_in_halt: bool = True
    """False if a mode that is written while halt (bit 8) is set takes effect only when halt is gone."""
    mode_display: ModeDisplay = ModeDisplay.AT_ONCE
    mode_display_ms: float = 0.0
    """Time until 6061h shows another mode, in ms."""
    mode_zero: ModeZero = ModeZero.NO_CHANGE
    set_points: int = 2
    """Set-points of profile position that the drive holds at once, with the active one."""
    acknowledges_at_start: bool = False
    """True if bit 12 of profile position is set after enabling, until the first handshake has ended."""
    acknowledge_ms: float = 0.0
    """Time from a new set-point until bit 12 is set, in ms."""
    homing_bit: HomingBit = HomingBit.STANDING
    home_offset_sign: int = -1
    """Sign of the home offset (607Ch) in the position at home."""
    empty_limits_count: bool = False
    """True if 607Dh with both limits 0 allows position 0 only; otherwise an empty range limits nothing."""
    limit_switch: LimitSwitch = LimitSwitch.BLOCKS
    empty_buffer: EmptyBuffer = EmptyBuffer.STANDS
    leaving_counts: bool = False
    """True if 6007h applies whenever the node leaves NMT operational; otherwise only when it is stopped or reset."""


BASELINE: Final = Behaviour()
"""The behaviour of an axis of which nothing else is known."""
