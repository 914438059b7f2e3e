"""Many axes that follow their set positions, one cycle of all at once: arrays of numpy, a column an axis.

Each axis has constants of its own.  Every number comes out as it does alone (`folded.following`), bit by bit: the same
operations in the same order, so that what a drive sends doesn't depend on who shares its process.  A cycle costs some
50 calls, which take as long for four axes as for forty.
"""

from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from fieldrig.clock import S
from fieldrig_devices.mc4.axis import INCREMENTS, RAD, Axis
from fieldrig_devices.mc4.folded import Arrangement, E, T, V, error_of_speed, fold, most_way_of, speed_of_way
from fieldrig_devices.mc4.seat import Course
from fieldrig_devices.mc4.values import SPEED_UNIT

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Integers = npt.NDArray[Any]

MOST_PLACE: Final = 1 << 51
"""Increments that a float holds with room to spare."""
_INT32: Final = (-(1 << 31), (1 << 31) - 1)
_INT16: Final = (-(1 << 15), (1 << 15) - 1)
_FACTORS: Final = {40: (V, 1.0, SPEED_UNIT, _INT32), 84: (T, 1000.0, 1.0, _INT16), 189: (E, INCREMENTS, 1.0, _INT32)}
"""By IDN: the state, what it is multiplied with, what it is divided by (84: besides), and the limits of the value."""


class _State:
    """What a cycle changes, a row each."""

    def __init__(self, size: int) -> None:
        self.all = np.zeros((10, size))
        self.states = self.all[:4]
        """e, v, i, T, as `folded` has them; an axis with a coupling goes alone."""
        self.e, self.v, _, self.t = self.states
        self.way, self.moved, self.place, self.lead = self.all[4:8]
        """The third is the set position, in increments."""
        self.sums = self.all[8:]
        """Heats and works."""


class _Constants:
    def __init__(self, size: int) -> None:
        self.all = np.zeros((34, size))
        self.map = self.all[:16].reshape(4, 4, size)
        self.weights = self.all[16:20]
        """What part of a limit each state's distance from the steady one can take up."""
        self.limits = self.all[20:22]
        self.speed_limit = self.all[21]
        (
            self.viscous, self.dry, self.left, self.speed_of_way, self.lead_gain, self.load, self.most_error,
            self.told, self.told_speed, self.tolerance, self.gear_ratio, self.offset,
        ) = self.all[22:]  # fmt: skip


class AxisArray:
    def __init__(self, size: int, idns: Sequence[int]) -> None:
        """With room for so many axes; none is in it yet.  `idns` are of `values.MOVING`, and what is told of them."""
        self._now, self._before, self._constants = _State(size), _State(size), _Constants(size)
        self._most_way, self._least_way = np.zeros(size, np.int32), np.zeros(size, np.int32)
        self._told_ns = np.zeros(size, np.int64)
        self._is_dry, self._has_course = np.zeros(size, np.bool_), np.zeros(size, np.bool_)
        self._has_any_dry = self._has_any_course = False
        # rooms for what is reckoned in between
        self._steady, self._distance, self._share = (np.zeros((4, size)) for _ in range(3))
        self._steady_e, self._steady_v, self._steady_i, self._steady_t = self._steady
        self._products = np.zeros((4, 4, size))
        self._asked, self._left, self._sums = (np.zeros((2, size)) for _ in range(3))
        self._is_above = np.zeros((2, size), np.bool_)
        self._row, self._other_row = np.zeros(size), np.zeros(size)
        self._whole = np.zeros(size, np.int64)
        self._low = self._whole.view("<i4")[::2]
        self._follow = np.zeros(size, np.int32)
        self._idns = idns
        scaled = [idn for idn in idns if idn in _FACTORS]
        self._torques = [row for row, idn in enumerate(scaled) if idn == 84]
        self._sources = [_FACTORS[idn][0] for idn in scaled]
        self._factors = _column(_FACTORS[idn][1] for idn in scaled)
        self._divisors = np.repeat(_column(_FACTORS[idn][2] for idn in scaled), size, 1)
        self._least, self._most = (_column(_FACTORS[idn][3][end] for idn in scaled) for end in (0, 1))
        self._scaled = np.zeros((len(scaled), size))
        for column in range(size):
            self.clear(column)

    # ---- who is in it

    def put(self, column: int, axis: Axis, standstill_nm: float, most_error: float, course: Course | None) -> None:
        """It goes on from here.  `course` is what others were told of where its load is, if they were told anything."""
        constants, arrangement = self._constants, axis.arrangement
        states = axis.e, axis.v, axis.i, axis.t
        changing = *states, axis.way, axis.moved, axis.set_increments, axis.lead, axis.heats, axis.works
        self._now.all[:, column] = changing
        constants.all[:, column] = _constants_of(arrangement)
        constants.load[column], constants.most_error[column] = axis.load_nm, most_error
        self._divisors[self._torques, column] = standstill_nm
        most = most_way_of(arrangement.limits, arrangement.steps)
        self._least_way[column], self._most_way[column] = max(-most, _INT32[0]), min(most, _INT32[1])
        self._is_dry[column] = arrangement.dry_nm != 0
        self._has_any_dry = bool(self._is_dry.any())
        self._has_course[column] = course is not None
        self._has_any_course = bool(self._has_course.any())
        if course is not None:
            self.tell(column, course)

    def tell(self, column: int, course: Course) -> None:
        """Others were told this of where the load is."""
        constants, told = self._constants, course.told
        constants.told[column], constants.told_speed[column] = told.value, told.speed
        constants.tolerance[column], constants.gear_ratio[column] = course.tolerance, course.gear_ratio
        constants.offset[column] = course.offset
        self._told_ns[column] = told.time_ns

    def give(self, column: int, axis: Axis, *, before: bool = False) -> None:
        """Its state, or the one before the last cycle."""
        state = (self._before if before else self._now).all[:, column].tolist()
        axis.e, axis.v, axis.i, axis.t, way, moved, place, axis.lead, axis.heats, axis.works = state
        axis.way, axis.moved, axis.set_increments = int(way), int(moved), int(place)

    def take_sums(self, column: int) -> None:
        """They begin anew with the last cycle."""
        self._before.sums[:, column] = 0.0
        self._now.sums[:, column] = self._sums[:, column]

    def clear(self, column: int) -> None:
        """Nobody is there; it stays still, and is never refused."""
        self._now.all[:, column] = self._before.all[:, column] = 0.0
        constants = self._constants
        constants.all[:, column] = 0.0
        constants.limits[:, column] = constants.most_error[column] = constants.gear_ratio[column] = 1.0
        self._least_way[column] = self._most_way[column] = 0
        self._is_dry[column] = self._has_course[column] = False

    # ---- time

    def go(self, wanted: Integers) -> Bools:
        """One cycle of all, and then told to follow these set positions (int32).

        True for those which `folded` can't go or whose following error is too large; only `before` counts for them.
        """
        was, now, constants, steady, row = self._now, self._before, self._constants, self._steady, self._row
        speed, torque = self._steady_v, self._steady_t
        np.multiply(was.way, constants.speed_of_way, out=speed)
        np.multiply(constants.viscous, speed, out=torque)
        if self._has_any_dry:
            dry = np.where(was.v > 0.0, constants.dry, -constants.dry)
            torque += np.add(constants.load, dry, out=row)
        else:
            torque += constants.load
        np.subtract(torque, was.lead, out=self._steady_i)
        np.multiply(constants.left, speed, out=self._steady_e)
        distance, share = self._distance, self._share
        np.subtract(was.states, steady, out=distance)
        np.absolute(distance, out=share)
        share *= constants.weights
        reach = np.add.reduce(share, 0, out=row)
        np.subtract(1.0, reach, out=self._other_row)
        np.multiply(constants.limits, self._other_row, out=self._left)
        asked = np.absolute(steady[T : V - 1 : V - T], out=self._asked)
        above = np.greater(asked, self._left, out=self._is_above)
        refused: Bools = above[0] | above[1]
        if self._has_any_dry:
            reach *= constants.speed_limit
            refused |= (reach >= asked[1]) & self._is_dry
        np.multiply(constants.map, distance, out=self._products)
        np.add.reduce(self._products, 1, out=now.states)
        now.states += steady
        refused |= np.absolute(now.e, out=row) >= constants.most_error
        np.multiply(now.t, now.t, out=self._sums[0])
        np.multiply(now.t, was.v, out=self._sums[1])
        np.add(was.sums, self._sums, out=now.sums)
        np.add(was.place, was.way, out=now.place)
        now.moved[:] = was.way
        self._whole[:] = now.place
        follow = np.subtract(wanted, self._low, out=self._follow)
        now.way[:] = np.clip(follow, self._least_way, self._most_way, out=follow)
        np.subtract(now.way, was.way, out=now.lead)
        now.lead *= constants.lead_gain
        self._now, self._before = now, was
        return refused

    # ---- what is told of it

    def feedback(self) -> list[npt.NDArray[Any]]:
        """Whole numbers, in the order of the IDNs; they count until the next call of anything here."""
        scaled = self._scaled
        if self._sources:
            np.take(self._now.states, self._sources, 0, scaled, "clip")
            scaled *= self._factors
            scaled /= self._divisors
            np.clip(np.rint(scaled, out=scaled), self._least, self._most, out=scaled)
        if len(self._sources) < len(self._idns):
            self._whole[:] = np.rint(self._position(), out=self._row)
        rows = iter(scaled)
        return [next(rows) if idn in _FACTORS else self._low for idn in self._idns]

    def _position(self) -> Floats:
        """In increments."""
        position = self._row
        np.multiply(self._now.e, INCREMENTS, out=position)
        np.subtract(self._now.place, position, out=position)
        return position

    def astray(self, now_ns: int) -> list[int]:
        """The columns where the course that was told has led astray."""
        if not self._has_any_course:
            return []
        constants = self._constants
        position = self._position()
        position += constants.offset
        position *= RAD
        position /= constants.gear_ratio
        course = np.divide(now_ns - self._told_ns, S, out=self._other_row)
        course *= constants.told_speed
        course += constants.told
        course -= position
        is_off = np.absolute(course, out=course) > constants.tolerance
        is_off |= (self._now.v == 0.0) & (constants.told_speed != 0.0)
        is_off &= self._has_course
        columns: list[int] = np.flatnonzero(is_off).tolist() if is_off.any() else []
        return columns


def _column(numbers: Iterable[float]) -> Floats:
    return np.array(list(numbers), np.float64).reshape(-1, 1)


@lru_cache(maxsize=256)
def _constants_of(arrangement: Arrangement) -> Floats:
    plant, gains, limits, steps, dry_nm, lead_gain = arrangement
    rows, weights = fold(plant, gains, limits, steps)
    constants = _Constants(1)
    constants.map[:, :, 0], constants.weights[:, 0] = rows, weights
    constants.limits[:, 0] = limits.torque, limits.speed
    constants.viscous[0], constants.dry[0] = plant.viscous, dry_nm
    constants.left[0], constants.speed_of_way[0] = error_of_speed(gains), speed_of_way(steps)
    constants.lead_gain[0], constants.gear_ratio[0] = lead_gain, 1.0
    return constants.all[:, 0]
