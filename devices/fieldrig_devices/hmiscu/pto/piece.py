"""A piece of a plan: pulses with one law, from the rise of the first one to the end of the last period."""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Self

from fieldrig_bus.signals.parabola import Exact
from fieldrig_devices.hmiscu.pto.exact import ATTOSECONDS, root, sendable


@dataclass(frozen=True, slots=True)
class Piece:
    frequency: Exact
    """At the beginning, in Hz."""
    rate: Exact
    """In Hz/s; 0 for a constant frequency."""
    count: int | None
    """Number of pulses, or None if the piece goes on until another plan replaces it."""
    duration_as: int
    """In attoseconds; 0 if it goes on."""

    @classmethod
    def constant(cls, frequency: int | Fraction, count: int | None) -> Self:
        lasts = 0 if count is None else round(count * ATTOSECONDS / Fraction(frequency))
        return cls(sendable(Fraction(frequency)), 0, count, lasts)

    @classmethod
    def period(cls, seconds: Fraction) -> Self:
        """Return a single pulse that takes this long."""
        lasts = round(seconds * ATTOSECONDS)
        return cls(Fraction(ATTOSECONDS, lasts), 0, 1, lasts)

    @classmethod
    def changing(cls, frequency: Fraction, rate: Fraction, count: int, seconds: Fraction) -> Self:
        return cls(sendable(frequency), sendable(rate), count, round(seconds * ATTOSECONDS))

    def within(self, limit_as: int) -> Self:
        """Return as many whole pulses of this piece as take at most this long.  It has an end."""
        if self.duration_as <= limit_as:
            return self
        limit, start = Fraction(limit_as, ATTOSECONDS), Fraction(self.frequency)
        count = int((start + Fraction(self.rate) / 2 * limit) * limit)
        if not self.rate:
            return type(self).constant(start, count)
        after = root(start * start + 2 * Fraction(self.rate) * count)
        return type(self).changing(start, Fraction(self.rate), count, (after - start) / Fraction(self.rate))


Plan = Iterator[Piece]
"""The pieces of a move, one after the other.  A plan may be long, so its pieces are made when they are due."""


def limited(plan: Plan, limit_as: int) -> Plan:
    """Yield the whole pulses of a plan that end within this time, in attoseconds."""
    for piece in plan:
        yield from (kept for kept in (piece.within(limit_as),) if kept.count)
        limit_as -= piece.duration_as
        if limit_as <= 0:
            return
