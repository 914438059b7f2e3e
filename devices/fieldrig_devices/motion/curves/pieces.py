"""Pieces of which every motion law is made: a polynomial, plus a sine if it has one.

    y(t) = p0 + p1 t + p2 t^2 + ... + amplitude sin(rate t + phase),    0 <= t <= length

Scaling, reflection and shifting of a piece give a piece again.  So a cam is computed once for its axis, its master and
its units, and a cycle evaluates one closed form.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import comb, cos, sin


@dataclass(frozen=True, slots=True)
class Piece:
    length: float
    powers: tuple[float, ...]
    """Coefficients of the polynomial, the constant one first; at least two, and at most two beside a sine."""
    amplitude: float = 0.0
    rate: float = 0.0
    phase: float = 0.0

    def at(self, t: float) -> float:
        return evaluator(self)(t)

    def slope(self, t: float) -> float:
        """The first derivative at `t`."""
        slope = 0.0
        for power in range(len(self.powers) - 1, 0, -1):
            slope = slope * t + power * self.powers[power]
        return slope + self.amplitude * self.rate * cos(self.rate * t + self.phase)

    def scaled(self, x: float, y: float) -> "Piece":
        """The piece stretched by `x` along t and by `y` along y; a negative `x` makes t run downwards."""
        powers = tuple(value * y / x**power for power, value in enumerate(self.powers))
        return Piece(self.length * x, powers, self.amplitude * y, self.rate / x, self.phase)

    def raised(self, y: float) -> "Piece":
        return replace(self, powers=(self.powers[0] + y, *self.powers[1:]))

    def reflected(self) -> "Piece":
        """The piece turned by half a turn: its value at t is -y(length - t)."""
        length, powers = self.length, self.powers
        turned = tuple(
            -((-1) ** k) * sum(powers[n] * comb(n, k) * length ** (n - k) for n in range(k, len(powers)))
            for k in range(len(powers))
        )
        return Piece(length, turned, -self.amplitude, -self.rate, self.rate * length + self.phase)


def evaluator(piece: Piece) -> Callable[[float], float]:
    """A function of t: one multiply-add for a straight, Horner's scheme for a polynomial."""
    if piece.amplitude:
        return _sine(piece)
    match _without_zeros(piece.powers):
        case (p0, p1):
            return lambda t: p0 + p1 * t
        case (p0, p1, p2):
            return lambda t: p0 + t * (p1 + t * p2)
        case (p0, p1, p2, p3):
            return lambda t: p0 + t * (p1 + t * (p2 + t * p3))
        case (p0, p1, p2, p3, p4, p5):
            return lambda t: p0 + t * (p1 + t * (p2 + t * (p3 + t * (p4 + t * p5))))
        case powers:
            return lambda t: _horner(powers, t)


def _sine(piece: Piece) -> Callable[[float], float]:
    (p0, p1), amplitude, rate, phase = piece.powers, piece.amplitude, piece.rate, piece.phase
    return lambda t: p0 + p1 * t + amplitude * sin(rate * t + phase)


def _without_zeros(powers: tuple[float, ...]) -> tuple[float, ...]:
    while len(powers) > 2 and not powers[-1]:
        powers = powers[:-1]
    return powers


def _horner(powers: Sequence[float], t: float) -> float:
    value = 0.0
    for power in reversed(powers):
        value = value * t + power
    return value
