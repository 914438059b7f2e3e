"""Plans whose pulses are the whole numbers under the curve of frequency, so counts and times equal the formulas.

A ramp is one piece.  The period in which the curve reaches or leaves a plateau is a piece of its own, with the exact
time under the curve.  So a move takes at most five pieces, however many pulses it has.
"""

from collections.abc import Iterator
from fractions import Fraction

from fieldrig_devices.hmiscu.pto.exact import root
from fieldrig_devices.hmiscu.pto.piece import Piece
from fieldrig_devices.hmiscu.pto.ramp import Ramp


def move(up: Ramp, down: Ramp, distance: int) -> Iterator[Piece]:
    """Yield a move of `distance` pulses over two ramps with the same high end; both have at most these pulses."""
    if up.whole:
        yield _climb(up)
    yield from _top(up, down, distance)
    if down.whole:
        yield fall(down, down.whole)


def _top(up: Ramp, down: Ramp, distance: int) -> Iterator[Piece]:
    """Yield the pulses between the whole ones of the ramps: at the high frequency, and the two around it."""
    plateau = distance - up.whole - down.whole - bool(up.part) - bool(down.part)
    if plateau < 0:  # the end of one ramp and the beginning of the other are in the same period
        level_s = (distance - up.pulses - down.pulses) / up.high
        yield Piece.period(up.part_s + level_s + down.part_s)
        return
    if up.part:
        yield _shoulder(up)
    if plateau:
        yield Piece.constant(up.high, plateau)
    if down.part:
        yield _shoulder(down)


def approach(from_hz: Fraction, to_hz: int, rate: Fraction) -> Iterator[Piece]:
    """Yield a ramp in either direction, then the new frequency until something else happens."""
    if from_hz < to_hz:
        ramp = Ramp(from_hz, Fraction(to_hz * to_hz), rate)
        if ramp.whole:
            yield _climb(ramp)
        if ramp.part:
            yield _shoulder(ramp)
    elif from_hz > to_hz:
        yield from _descend(Ramp(Fraction(to_hz), from_hz * from_hz, rate))
    yield Piece.constant(to_hz, None)


def _descend(ramp: Ramp) -> Iterator[Piece]:
    """Yield a ramp from its high end, so the part of a pulse is under its low end."""
    after = root(ramp.high_square - 2 * ramp.rate * ramp.whole)
    if ramp.whole:
        yield Piece.changing(ramp.high, -ramp.rate, ramp.whole, (ramp.high - after) / ramp.rate)
    if ramp.part:
        yield Piece.period((after - ramp.low) / ramp.rate + (1 - ramp.part) / ramp.low)


def fall(ramp: Ramp, count: int) -> Piece:
    """Return the last `count` pulses of a ramp down to its low end."""
    return Piece.changing(ramp.after(count), -ramp.rate, count, ramp.seconds_of(count))


def _climb(ramp: Ramp) -> Piece:
    return Piece.changing(ramp.low, ramp.rate, ramp.whole, ramp.seconds_of(ramp.whole))


def _shoulder(ramp: Ramp) -> Piece:
    """Return the period that is partly under a ramp and partly at its high frequency."""
    return Piece.period(ramp.part_s + (1 - ramp.part) / ramp.high)
