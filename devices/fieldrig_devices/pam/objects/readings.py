"""Passages of the manual about objects that can be read in two ways, and facts of a machine that it leaves out."""

from pydantic import Field

from fieldrig.settings import Settings


class ObjectReadings(Settings):
    """The defaults are the readings of the manual's digest, whose rows are in the comments."""

    # G-14
    takes_shorter_way: bool = Field(
        default=False,
        description="whether an absolute move of a periodic axis or generator takes the shorter way round",
    )
    # G-29
    amplifier_unwraps: bool = Field(
        default=True,
        description="whether an amplifier counts the periods of its input, so that its output has no step there",
    )
    # G-33
    corrector_input_sign_reversed: bool = Field(
        default=False,
        description='whether CORRECTION_REFERENCE = INPUT corrects by "must be" minus "is", as OUTPUT does',
    )
    # G-33
    corrector_takes_both_edges: bool = Field(
        default=False,
        description="whether both edges of TRIGGER_INPUT are events of a corrector, or only that to true",
    )
    # G-33
    trigger_off_ends_correction: bool = Field(
        default=False,
        description="whether trigger_off brakes a running correction, or lets it complete",
    )
    # G-38
    run_is_ready_at_speed: bool = Field(
        default=True,
        description="whether axes and generators are ready when a run has reached its speed, or only when it has ended",
    )
    # E-18
    pmp_supersedes: bool = Field(
        default=False,
        description="whether a command to a moving PMP generator replaces the motion, which stops first, or is ignored",
    )
    # section 17 of the system's digest
    power_on_sets_initial_position: bool = Field(
        default=False,
        description="whether power_on sets the position to INITIAL_POSITION, or to 0",
    )
    # E-03
    st1_nodes_have_errors: bool = Field(
        default=False,
        description="whether error and error_code of an ST1 node are those of its axis, or always false and 0",
    )
    # E-05
    profiles_act_at_once: bool = Field(
        default=False,
        description="whether a written parameter of a PROFILE acts at once, or when PROFILE of the cam is written",
    )
    # G-07
    lowest_address_is_highest_bit: bool = Field(
        default=False,
        description="whether the lowest address of a digital input or output is its highest bit, or its lowest",
    )
    set_point_delay_periods: float = Field(
        default=1.0,
        ge=0,
        description="periods of a pipe until a node is at a set-point, which ANTI_DELAY makes up for",
    )
    # PAML-513
    report_delay_cycles: float = Field(default=2.0, ge=0, description="cycles until the PAM has the report of an input")
    # PAML-412
    blocks_per_ms: int = Field(
        default=1_000,
        ge=1,
        description="blocks of pipes for which a millisecond of the cycle has time; more stop the PAM with 02..F060",
    )
    # PAML-144
    read_cycles: int = Field(default=6, ge=1, description="cycles that a read over the ring takes at least")
    read_timeout_cycles: int = Field(
        default=100, ge=1, description="cycles after which a read is given up with 07..E021"
    )
    # G-37
    largest_torque_nm: float = Field(
        default=10.0, gt=0, description="torque of a motor at the largest torque limit, in Nm"
    )
