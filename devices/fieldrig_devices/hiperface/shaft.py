"""The shaft as the encoder measures it: types, absolute position in steps, two signals shifted by 90 degrees.

Source: manual 6448 (at most 4096 revolutions), 6756 (two signals shifted by 90 degrees), 6933 (1 000 000 increments a
turn), 7149 (zero pulse once a turn).  Types as in the drives named in `telegram`: SRS (22h) and SRM (27h) report 32
steps in each of the 1024 periods of a turn.  A drive gets the rest of its 1 000 000 increments from the analog signals.
Our choice: above 6000 1/min the encoder gives no position.
"""

from dataclasses import dataclass
from math import cos, floor, sin, tau
from typing import Final, Literal, NamedTuple

INCREMENTS: Final = 1_000_000
"""Increments per turn of drive and controller."""
PERIODS: Final = 1024
"""Periods of sine and cosine per turn."""
STEPS: Final = 32 * PERIODS
"""Steps per turn of the position that the encoder reports."""
FASTEST: Final = 100.0
"""Highest speed at which the encoder reports a position, in turns per second."""
AMPLITUDE: Final = 0x4000
"""Amplitude of sine and cosine in the answer to 44h (our scale)."""


@dataclass(frozen=True, slots=True)
class EncoderType:
    code: int
    turns: int
    """Number of turns that it distinguishes."""

    @property
    def range(self) -> int:
        """Number of steps after which the position repeats."""
        return self.turns * STEPS


TypeName = Literal["single_turn", "multi_turn"]
TYPES: Final[dict[TypeName, EncoderType]] = {
    "single_turn": EncoderType(0x22, 1),  # SRS
    "multi_turn": EncoderType(0x27, 4096),  # SRM
}
BY_CODE: Final = {kind.code: kind for kind in TYPES.values()}


class Turning(NamedTuple):
    turns: float
    speed: float = 0.0
    """Speed in turns per second."""


class Signals(NamedTuple):
    """Sine and cosine from -1 to 1, and the zero pulse."""

    sine: float
    cosine: float
    zero: bool


def steps_of(turns: float) -> int:
    return floor(turns * STEPS)


def increments_of(steps: int) -> int:
    """Return the first increment of a step."""
    return -(-steps * INCREMENTS // STEPS)


def signals(turns: float) -> Signals:
    """Return the signals; the zero pulse is the first quarter of the first period (our choice)."""
    phase = turns % 1.0 * PERIODS
    return Signals(sin(tau * phase), cos(tau * phase), phase < 0.25)
