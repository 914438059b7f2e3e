"""What the encoder sees of the shaft: its types, the absolute position in steps, the two signals shifted by 90 degrees.

Source: manual 6448 (at most 4096 revolutions), 6756 (two signals shifted by 90 degrees), 6933 (1 000 000 increments a
turn), 7149 (zero pulse once a turn).  Types as in the drives named in `telegram`: SRS (22h) and SRM (27h) tell 32 steps
in each of the 1024 periods of a turn.  A drive gets the rest of its 1 000 000 increments from the analog signals.
Our choice: above 6000 1/min the encoder gives no position.
"""

from dataclasses import dataclass
from math import cos, floor, sin, tau
from typing import Final, Literal, NamedTuple

INCREMENTS: Final = 1_000_000
"""A turn, as drive and controller count."""
PERIODS: Final = 1024
"""Of sine and cosine in a turn."""
STEPS: Final = 32 * PERIODS
"""A turn, as the encoder tells its position."""
FASTEST: Final = 100.0
"""Turns a second at which there still is a position."""
AMPLITUDE: Final = 0x4000
"""Of sine and cosine in the answer to 44h (our scale)."""


@dataclass(frozen=True, slots=True)
class EncoderType:
    code: int
    turns: int
    """That it tells apart."""

    @property
    def range(self) -> int:
        """Steps until the position begins anew."""
        return self.turns * STEPS


TypeName = Literal["single_turn", "multi_turn"]
TYPES: Final[dict[TypeName, EncoderType]] = {
    "single_turn": EncoderType(0x22, 1),  # SRS
    "multi_turn": EncoderType(0x27, 4096),  # SRM
}
BY_CODE: Final = {one.code: one for one in TYPES.values()}


class Turning(NamedTuple):
    turns: float
    speed: float = 0.0
    """Turns a second."""


class Signals(NamedTuple):
    """Sine and cosine from -1 to 1, and the zero pulse."""

    sine: float
    cosine: float
    zero: bool


def steps_of(turns: float) -> int:
    return floor(turns * STEPS)


def increments_of(steps: int) -> int:
    """Where the step begins, on the drive's scale."""
    return -(-steps * INCREMENTS // STEPS)


def steps_of_increments(increments: int) -> int:
    return increments * STEPS // INCREMENTS


def signals(turns: float) -> Signals:
    """The zero pulse is the first quarter of the first period (our choice)."""
    phase = turns % 1.0 * PERIODS
    return Signals(sin(tau * phase), cos(tau * phase), phase < 0.25)
