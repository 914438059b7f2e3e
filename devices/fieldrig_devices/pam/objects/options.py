"""Passages of the manual that can be read in two ways, and facts of a machine that it does not state."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Options:
    """The defaults are the readings of the manual's digest."""

    takes_shorter_way: bool = False
    """True if an absolute move of a periodic axis or generator takes the shorter way round (G-14)."""
    amplifier_unwraps: bool = True
    """True if an amplifier counts the periods of its input, so that its output has no step there (G-29)."""
    corrector_input_sign_reversed: bool = False
    """True if CORRECTION_REFERENCE = INPUT corrects by "must be" minus "is", as OUTPUT does (G-33)."""
    keeps_written_parameters: bool = True
    """True if a block begins its life with the values last written, False if with those declared (PAML-409)."""
    set_point_delay_periods: float = 1.0
    """Periods of a pipe until a node is at a set-point, to which it moves steadily; ANTI_DELAY makes up for it."""
    report_delay_cycles: float = 2.0
    """Time from the end of an age until the PAM has the report: a cycle in the node, and one on the ring (PAML-513)."""
    read_cycles: int = 6
    """Basic cycles that a read over the ring takes at least (PAML-144)."""
    read_timeout_cycles: int = 100
    """Basic cycles after which a read without an answer is given up, with 07..E021."""
    largest_torque_nm: float = 10.0
    """Torque of a motor that the converter's mode TORQUE counts from (G-37)."""
    motor_turn: int = 1 << 32
    """Resolver units in a turn of the motor (PAML-045)."""
    deviating_axes: frozenset[int] = frozenset()
    """Addresses of ST1 nodes that join no group, though CKV, CKA, CKR, CKH and EQUIP may be equal (PAML-163)."""
