"""A motion law: the pieces of its accelerating half, and its coefficients."""

from dataclasses import dataclass

from fieldrig_devices.motion.curves.pieces import Piece


@dataclass(frozen=True, slots=True)
class Law:
    """A law with its coefficients."""

    half: tuple[Piece, ...]
    """The accelerating half, up to z = 1/2, where f is 1/2 as well."""
    cv: float
    """Largest slope, which is that at the turning point."""
    ca: float
    """Largest second derivative; infinite for the straight."""
    constant: str
    """The letters behind g_K_ of the constant for `ScalFollPos`."""
