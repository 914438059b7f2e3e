"""Settings for passages where the manual is silent or contradicts itself: how the card behaves there.

Source: digest chapters 2 to 18; each setting names its entry in the digest.  The defaults are the digest's
interpretations.
"""

from typing import Literal

from pydantic import Field

from fieldrig.settings import Settings


class Readings(Settings):
    """How to interpret passages in the manual that leave a choice."""

    zero_offset_step: Literal["jump", "ignore"] = Field(
        default="jump", description="whether a new offset applies at once or never if @ParX[20] or [23] is 0 (I-08)"
    )
    pst_join: Literal["round", "through"] = Field(
        default="round", description="whether joins of PST round off the table's points or pass through them (I-35)"
    )
    cam_wrap: Literal["travel", "jump"] = Field(
        default="travel",
        description="CAM where the counter wraps: a step over the wrap counts as travel, and cam switches may"
        " extend over it, or the plain numbers are compared (chapter 15)",
    )
    pid_ramp_start: Literal["zero", "sgloff"] = Field(
        default="zero", description="whether the reference of PID starts its ramp at 0 or at SGLOFF (chapter 14)"
    )
    lost_io: Literal["zero", "hold"] = Field(
        default="zero",
        description="whether the inputs of a lost remote I/O node are set to 0 or keep their last state (10.2)",
    )
    terminal_value: Literal["follows", "once"] = Field(
        default="follows",
        description="whether the terminal shows the present value of a variable or that at TERM (chapter 16)",
    )
