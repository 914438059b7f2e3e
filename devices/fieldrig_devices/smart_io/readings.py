"""Passages of the manual about the node that can be read in two ways, and facts of a machine that it leaves out."""

from typing import Annotated, Literal

from pydantic import Field

from fieldrig.settings import Settings


class NodeReadings(Settings):
    """The defaults are the likelier readings."""

    autorepeat: Literal["gaps", "pulses"] = Field(
        default="gaps",
        description="value of a pressed AUTOREPEAT key: true with a gap of one PERIOD before each repetition, or a "
        "pulse of one PERIOD for the press and for each repetition",
    )
    time_stamps: bool = Field(
        default=True, description="whether reports of binary inputs say how long ago the level changed"
    )
    counts: Literal["direction", "up"] = Field(
        default="direction", description="pulses of a DC motor in its COUNTER_INPUT: down with DEC, or always up"
    )
    zero_at: Literal["edge", "rest"] = Field(
        default="edge", description="place of position 0 after zero_position: at the edge of ZERO, or at rest behind it"
    )
    stray_pulses: int | None = Field(
        default=None,
        ge=0,
        le=1_000_000,
        description="pulses of a DC motor at rest with which its position is not lost yet; by default BRAKING",
    )
    font: dict[
        Annotated[str, Field(min_length=1, max_length=1)],
        Annotated[str, Field(pattern="^[a-gp]*$", examples=["abdeg"])],
    ] = Field(default_factory=dict, description="segments of characters that differ from the font, such as {z: abdeg}")
