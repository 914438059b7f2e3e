"""Plans of moves and stops: which formulas apply to a command, and the frequency at which it begins and ends."""

from collections.abc import Iterator
from fractions import Fraction
from itertools import chain
from typing import Final, NamedTuple

from fieldrig_devices.hmiscu.pto import periods, smooth
from fieldrig_devices.hmiscu.pto.command import Order
from fieldrig_devices.hmiscu.pto.exact import ATTOSECONDS, root
from fieldrig_devices.hmiscu.pto.periods import Staircase
from fieldrig_devices.hmiscu.pto.piece import Piece, Plan, limited
from fieldrig_devices.hmiscu.pto.ramp import Ramp, peak_square
from fieldrig_devices.hmiscu.pto.rates import end_frequency, rate
from fieldrig_devices.hmiscu.pto.settings import PtoSettings

JOG: Final = 3
"""Moves of at most this many pulses have no profile (SCU-036)."""
FAST_STOP_LIMIT_S: Final = 6
"""Manual 505."""


class Ends(NamedTuple):
    """The configured frequencies, in Hz; 0 is calculated from the rate."""

    start_hz: int
    stop_hz: int


class Planner:
    def __init__(self, settings: PtoSettings) -> None:
        self._settings = settings
        self._is_smooth = settings.ramps == "smooth"

    def move_relative(self, order: Order, ends: Ends) -> Plan | None:
        """Return the plan of a move; None if it cannot have a profile (SCU-045)."""
        top, distance = order.velocity, order.distance
        up = rate(self._settings.ramp_unit, order.acceleration, ends.start_hz, top)
        down = rate(self._settings.ramp_unit, order.deceleration, ends.stop_hz, top)
        if distance <= JOG:
            return iter((Piece.constant(end_frequency(ends.stop_hz, down), distance),))
        if _is_flat(ends.start_hz, top, up) or _is_flat(ends.stop_hz, top, down):
            return iter((Piece.constant(top, distance),))
        start, stop, square = Fraction(ends.start_hz), Fraction(ends.stop_hz), Fraction(top * top)
        climb, fall = Ramp(start, square, up), Ramp(stop, square, down)
        if climb.pulses + fall.pulses > distance:
            square = peak_square(start, stop, up, down, distance)
            if square <= max(start, stop) ** 2:
                return None
            climb, fall = Ramp(start, square, up), Ramp(stop, square, down)
        if self._is_smooth:
            return smooth.move(climb, fall, distance)
        return periods.move(Staircase(ends.start_hz, up), Staircase(ends.stop_hz, down), top, distance)

    def from_rest(self, order: Order, ends: Ends) -> Plan:
        """Return the ramp of a PTOMoveVelocity from standstill."""
        up = rate(self._settings.ramp_unit, order.acceleration, ends.start_hz, order.velocity)
        if _is_flat(ends.start_hz, order.velocity, up):
            return iter((Piece.constant(order.velocity, None),))
        if self._is_smooth:
            return smooth.approach(Fraction(ends.start_hz), order.velocity, up)
        return periods.approach(ends.start_hz, order.velocity, up, is_from_rest=True)

    def to_velocity(self, order: Order, from_hz: int) -> Plan:
        """Return the ramp of a PTOMoveVelocity from another constant velocity."""
        pin = order.acceleration if order.velocity > from_hz else order.deceleration
        change = rate(self._settings.ramp_unit, pin, from_hz, order.velocity)
        if self._is_smooth:
            return smooth.approach(Fraction(from_hz), order.velocity, change)
        return periods.approach(from_hz, order.velocity, change, is_from_rest=False)

    def stop(self, deceleration: int, square: Fraction, target_hz: int, stop_hz: int) -> Plan:
        """Return the ramp of PTOStop, from the square of the present frequency.

        The rate follows from the last target velocity, not from the present frequency (SCU-087, SCU-090).
        """
        return self._fall(square, stop_hz, rate(self._settings.ramp_unit, deceleration, stop_hz, target_hz))

    def fast_stop(self, square: Fraction, stop_hz: int, is_shutdown: bool) -> Plan:
        """Return the ramp of a fast stop, with the rate that the configuration gives (SCU-017, SCU-088)."""
        settings = self._settings
        down = rate(settings.ramp_unit, settings.limits[2], stop_hz, settings.maximum_frequency_hz)
        plan = self._fall(square, stop_hz, down)
        if is_shutdown or settings.fast_stop_cap == "all":
            return limited(plan, FAST_STOP_LIMIT_S * ATTOSECONDS)
        return plan

    def _fall(self, square: Fraction, stop_hz: int, down: Fraction) -> Iterator[Piece]:
        ramp = Ramp(Fraction(stop_hz), square, down)
        if ramp.whole <= 0:
            return iter(())
        if self._is_smooth:
            return iter((smooth.fall(ramp, ramp.whole),))
        return periods.pieces(Staircase(stop_hz, down).falling(ramp.whole))


def _is_flat(configured_hz: int, top: int, change: Fraction) -> bool:
    """Return whether a velocity is not above a start or stop frequency that is calculated (SCU-034)."""
    return not configured_hz and top <= end_frequency(0, change)


def handed_over(plan: Plan, square: Fraction, hand_over_ns: int) -> Plan:
    """Return a plan after the pulses at the present frequency that a hand-over between commands takes (SCU-055)."""
    frequency = root(square)
    count = -(-frequency * hand_over_ns // 10**9)
    return chain((Piece.constant(frequency, count),), plan) if count else plan
