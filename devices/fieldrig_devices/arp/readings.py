"""Where the manual is silent or contradicts itself: what the card does, as settings that its owner may flip.

Source: digest chapters 2 to 18; each setting names the entry it stands for.  The defaults are the digest's readings.
"""

from typing import Literal

from pydantic import Field

from fieldrig.settings import Settings


class Readings(Settings):
    """Of passages in the manual that leave a choice."""

    zero_offset_step: Literal["jump", "ignore"] = Field(
        default="jump", description="a new offset with @ParX[20] or [23] at 0: taken at once, or not at all (I-08)"
    )
    pst_join: Literal["round", "through"] = Field(
        default="round", description="joins of PST round the points of the table off, or pass through them (I-35)"
    )
    cam_wrap: Literal["travel", "jump"] = Field(
        default="travel",
        description="CAM where the counter wraps: a step over the wrap counts as the way the axis went, and cams may"
        " reach over it; or the plain numbers are compared (chapter 15)",
    )
    pid_ramp_start: Literal["zero", "sgloff"] = Field(
        default="zero", description="where the reference of PID starts its ramp: at 0, or at SGLOFF (chapter 14)"
    )
    lost_io: Literal["zero", "hold"] = Field(
        default="zero", description="inputs of a remote I/O node that is lost: to 0, or as they were last (10.2)"
    )
    terminal_value: Literal["follows", "once"] = Field(
        default="follows",
        description="a variable on the terminal: what it is now, or what it was when TERM was executed (chapter 16)",
    )
