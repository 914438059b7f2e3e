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
    corrector_takes_both_edges: bool = False
    """True if both edges of TRIGGER_INPUT are events of a corrector (G-33)."""
    trigger_off_ends_correction: bool = False
    """True if `trigger_off` brakes a running correction (G-33)."""
    run_is_ready_at_speed: bool = True
    """True if a `run` is complete when its speed is reached, False if it is as long as it lasts (G-38)."""
    pmp_supersedes: bool = False
    """True if a command to a PMP generator replaces its running motion, False if it is ignored (E-18)."""
    power_on_sets_initial_position: bool = False
    """True if `power_on` sets INITIAL_POSITION, False if it sets 0 (section 17 of the system's digest)."""
    st1_nodes_have_errors: bool = False
    """True if `error` and `error_code` of an ST1 node answer as those of its axis, False if there are none (E-03)."""
    profiles_act_at_once: bool = False
    """True if a written parameter of a PROFILE acts at once in the cams that use it (E-05)."""
    lowest_address_is_highest_bit: bool = False
    """True if the first of the channels of a digital input or output is the highest bit, not the lowest (G-07)."""
    set_point_delay_periods: float = 1.0
    """Periods of a pipe until a node is at a set-point, to which it moves steadily; ANTI_DELAY makes up for it."""
    report_delay_cycles: float = 2.0
    """Time from the end of an age until the PAM has the report: a cycle in the node, and one on the ring (PAML-513)."""
    blocks_per_ms: int = 1_000
    """Blocks of pipes for which a millisecond of the basic cycle has time; more stop the PAM by 02..F060 (PAML-412)."""
    read_cycles: int = 6
    """Basic cycles that a read over the ring takes at least (PAML-144)."""
    read_timeout_cycles: int = 100
    """Basic cycles after which a read without an answer is given up, with 07..E021."""
    largest_torque_nm: float = 10.0
    """Torque of a motor that the converter's mode TORQUE counts from (G-37)."""
    motor_turn: int = 1 << 32
    """Resolver units in a turn of the motor (PAML-045)."""
