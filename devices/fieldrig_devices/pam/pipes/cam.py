"""The cam: y = Oout + fct((x - Oin) / Ain) Aout, where fct is a normalised profile (PAML-440 to PAML-449)."""

from collections.abc import Callable
from dataclasses import dataclass

from fieldrig_devices.pam.pipes.block import Block, wrapped

Shape = Callable[[float], float]
"""A normalised curve over 0.0 to 1.0."""


@dataclass(frozen=True, slots=True)
class Profile:
    """A shape with its amplitudes and offsets, in the units of the flow before and behind the cam."""

    shape: Shape
    input_amplitude: float
    output_amplitude: float
    input_offset: float
    output_offset: float

    def at(self, value: float) -> float:
        """Return the output; below and above the range the ends of the shape hold."""
        share = (value - self.input_offset) / self.input_amplitude if self.input_amplitude else 0.0
        return self.output_offset + self.shape(min(max(share, 0.0), 1.0)) * self.output_amplitude


class Cam(Block):
    """A cam, whose new profile takes effect with the next value; give a changed one again (PAML-444)."""

    def __init__(self, profile: Profile, value_period: float | None) -> None:
        super().__init__()
        self.profile, self.value_period = profile, value_period

    @property
    def is_at_rest(self) -> bool:
        return True

    @property
    def outgoing_period(self) -> float | None:
        return self.value_period

    def transform(self, value: float) -> float:
        return wrapped(self.profile.at(value), self.value_period)
