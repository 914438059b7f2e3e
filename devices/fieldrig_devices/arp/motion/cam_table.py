"""The table of PST as a curve: straight pieces between the points, and parabolas at the joins.

Source: manual 5.9.4.1; digest chapters 13.1 to 13.3 and 13.6.  Each join is wide enough for the slave's acceleration at
the master's maximum speed.  It rounds off the corner; with the interpretation `through`, the corners are moved until
the curve passes through the points of the table.  A table that spans the master's counter is repetitive if the slave
ends where it began or has travelled once around its own counter; the ends are then joined too.
"""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import copysign
from typing import Final, Literal, NamedTuple

from fieldrig_devices.arp.fixed import SCALE, whole
from fieldrig_devices.arp.motion.counter import Span

FEWEST_PAIRS: Final = 2
MOST_PAIRS: Final = 22
_LAST_VARIABLE: Final = 1_000
_ROUNDINGS: Final = 1e-12  # relative tolerance of a limit
_ITERATIONS: Final = 200
_CLOSE: Final = 1e-9  # units; programs resolve 0.001


class TableError(Exception):
    """A table that causes E13; the message gives the reason."""


class Point(NamedTuple):
    master: float
    slave: float


@dataclass(frozen=True, slots=True)
class Demand:
    """Limits that the curve must respect: maximum speeds and the slave's acceleration."""

    master_speed: float
    slave_speed: float
    slave_acceleration: float


class Piece(NamedTuple):
    """A piece of the curve: slave = position + slope * u + bend * u^2, with u = master - begin."""

    begin: float
    position: float
    slope: float
    bend: float


class CurveValue(NamedTuple):
    slave: float
    slope: float
    curvature: float


def read_points(variables: Sequence[int], first: int) -> list[Point]:
    """Read the pairs of the table at V`first`.  Raises TableError for an invalid count or order."""
    pairs = whole(variables[first]) if 1 <= first <= _LAST_VARIABLE else 0
    if not FEWEST_PAIRS <= pairs <= MOST_PAIRS:
        raise TableError(f"{pairs} pairs; expected 2 to 22")
    if first + 2 * pairs > _LAST_VARIABLE:
        raise TableError(f"the table ends after V{_LAST_VARIABLE}")
    raw = variables[first + 1 : first + 1 + 2 * pairs]
    points = [Point(master / SCALE, slave / SCALE) for master, slave in zip(raw[::2], raw[1::2], strict=True)]
    if any(left.master >= right.master for left, right in pairwise(points)):
        raise TableError("the master's positions do not increase from each point to the next")
    return points


class CamTable:
    def __init__(
        self,
        points: Sequence[Point],
        master: Span,
        slave: Span,
        demand: Demand,
        join: Literal["round", "through"] = "round",
    ) -> None:
        """Raises TableError if the slave cannot follow, or if a join does not fit between its points."""
        first, last = points[0], points[-1]
        spans_master = (first.master, last.master) == (master.low, master.high)
        goes_round = {first.slave, last.slave} == {slave.low, slave.high}
        self.is_repetitive = spans_master and (goes_round or first.slave == last.slave)
        self.lap = last.slave - first.slave if self.is_repetitive else 0.0
        """Distance that the slave advances while the master goes round once."""
        self.low, self.high = first.master, last.master
        within = all(slave.low <= point.slave <= slave.high for point in points)
        self.leaves_slave_span = not within and not self.is_repetitive
        self._demand = demand
        self._masters = [point.master for point in points]
        corners = [point.slave for point in points]
        self._check(corners)
        if join == "through":
            corners = self._moved(corners)
            self._check(corners)
        self._pieces = self._built(corners)
        self._begins = [piece.begin for piece in self._pieces]

    def at(self, master: float) -> CurveValue:
        """The curve at a master position from `low` to `high`; beyond `high`, the last piece continues."""
        begin, position, slope, bend = self._pieces[max(bisect_right(self._begins, master) - 1, 0)]
        u = master - begin
        return CurveValue(position + (slope + bend * u) * u, slope + 2 * bend * u, 2 * bend)

    @property
    def joins(self) -> list[float]:
        """Width of each point's join, in master units; 0 without a join."""
        return self._widths(self._slopes(self._corners))

    def _slopes(self, corners: Sequence[float]) -> list[float]:
        """Slopes of the segments, preceded and followed by the slopes that the end points join to."""
        inner = [
            (right - left) / (after - before)
            for (left, right), (before, after) in zip(pairwise(corners), pairwise(self._masters), strict=True)
        ]
        return [inner[-1], *inner, inner[0]] if self.is_repetitive else [inner[0], *inner, inner[-1]]

    def _widths(self, slopes: Sequence[float]) -> list[float]:
        factor = self._demand.master_speed**2 / self._demand.slave_acceleration
        return [abs(after - before) * factor for before, after in pairwise(slopes)]

    def _check(self, corners: Sequence[float]) -> None:
        slopes = self._slopes(corners)
        demand = self._demand
        if max(map(abs, slopes)) * demand.master_speed > demand.slave_speed * (1 + _ROUNDINGS):
            raise TableError("the slave would exceed its maximum speed")
        for (left, right), (before, after) in zip(pairwise(self._widths(slopes)), pairwise(self._masters), strict=True):
            if (left + right) / 2 > (after - before) * (1 + _ROUNDINGS):
                raise TableError("a join is wider than the distance between its points")

    def _moved(self, points: Sequence[float]) -> list[float]:
        """Corners whose joins pass through the points: each is off its point by what its join cuts off."""
        corners = list(points)
        for _ in range(_ITERATIONS):
            slopes = self._slopes(corners)
            cuts = [
                (after - before) * width / 8
                for (before, after), width in zip(pairwise(slopes), self._widths(slopes), strict=True)
            ]
            before_this, corners = corners, [point - cut for point, cut in zip(points, cuts, strict=True)]
            if max(abs(new - old) for new, old in zip(corners, before_this, strict=True)) < _CLOSE:
                return corners
        raise TableError("no curve with these joins passes through the points")

    def _built(self, corners: Sequence[float]) -> list[Piece]:
        self._corners = corners
        slopes = self._slopes(corners)
        bend = self._demand.slave_acceleration / (2 * self._demand.master_speed**2)
        pieces: list[Piece] = []
        for number, (master, slave, width) in enumerate(zip(self._masters, corners, self._widths(slopes), strict=True)):
            before, after = slopes[number], slopes[number + 1]
            half = width / 2
            if width > 0:
                pieces.append(Piece(master - half, slave - before * half, before, copysign(bend, after - before)))
            pieces.append(Piece(master + half, slave + after * half, after, 0.0))
        return pieces
