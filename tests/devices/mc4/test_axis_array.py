"""Axes as arrays against axes alone: bit by bit the same."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import MS
from fieldrig_bus.wires import Motion
from fieldrig_devices.mc4.axis import RAD, Axis, Mode
from fieldrig_devices.mc4.axis_array import AxisArray
from fieldrig_devices.mc4.folded import Gains, Limits, Numbers, Plant
from fieldrig_devices.mc4.seat import Course
from fieldrig_devices.mc4.values import MOVING

quick = settings(max_examples=60, deadline=None)
MOST_ERROR = 0.05
STANDSTILL_NM = 2.5
CHANGING = ("e", "v", "i", "t", "way", "moved", "set_increments", "lead", "heats", "works")
IDNS = (51, 53, 40, 84, 189)
NAMES = {
    "place": "place", "e": "new_e", "v": "new_v", "t": "new_t", "twist": "axis.twist",
    "standstill_nm": repr(STANDSTILL_NM),
}  # fmt: skip
NUMBERS = Numbers(tuple(MOVING[idn].format_map(NAMES) for idn in IDNS), "iiihi")


def everything(one: Axis) -> list[Any]:
    return [getattr(one, name) for name in CHANGING]


@dataclass(frozen=True)
class Make:
    """What an axis is made of."""

    inertia: float
    viscous: float
    kv: float
    ff: float
    dry: float
    lead_inertia: float
    load: float
    start: int

    def axis(self) -> Axis:
        kp = self.inertia * 400
        plant, gains = Plant(self.inertia, self.viscous), Gains(self.kv, kp, kp / 0.02, self.ff)
        one = Axis(plant, gains, Limits(20.0, 300.0), dry_nm=self.dry, increments=self.start)
        one.arrange(plant, gains, Limits(20.0, 300.0), 16, self.lead_inertia)
        one.control(Mode.POSITION)
        one.load(self.load)
        return one


makes = st.builds(
    Make, st.floats(1e-4, 1e-2), st.floats(0, 1e-2), st.floats(10, 100), st.sampled_from([0.0, 0.7, 1.0]),
    st.sampled_from([0.0, 0.2]), st.sampled_from([0.0, 1e-3]), st.floats(-3, 3), st.integers(-(2**40), 2**40),
)  # fmt: skip
ways = st.integers(-8_000, 8_000) | st.integers(-(2**31), 2**31 - 1)


@quick
@given(st.lists(makes, min_size=1, max_size=5), st.data())
def test_arrays_go_as_each_axis_goes_alone(kinds: list[Make], data: st.DataObject) -> None:
    alone, together = [make.axis() for make in kinds], [make.axis() for make in kinds]
    go = [one.following(NUMBERS) for one in alone]
    axes = AxisArray(len(kinds), IDNS)
    for column, one in enumerate(together):
        axes.put(column, one, STANDSTILL_NM, MOST_ERROR, None)
    riding = set(range(len(kinds)))
    for _ in range(data.draw(st.integers(1, 12))):
        steps = data.draw(st.lists(ways, min_size=len(kinds), max_size=len(kinds)))
        wanted = [((one.set_increments + step + 2**31) % 2**32) - 2**31 for one, step in zip(alone, steps, strict=True)]
        refused = axes.go(np.array(wanted, np.int32)).tolist()
        feedback = [values.astype(int).tolist() for values in axes.feedback()]
        for column in sorted(riding):
            follow = go[column]
            assert follow is not None
            packed = follow(alone[column], wanted[column], MOST_ERROR)
            axes.give(column, together[column], before=packed is None)
            assert refused[column] == (packed is None)
            assert everything(together[column]) == everything(alone[column])
            if packed is None:
                riding.discard(column)
                axes.clear(column)
            else:
                assert packed == b"".join(
                    value[column].to_bytes(2 if idn == 84 else 4, "little", signed=True)
                    for idn, value in zip(IDNS, feedback, strict=True)
                )


def course(value: float, speed: float = 0.0) -> Course:
    return Course(Motion("load", value, "rad", 0, speed), tolerance=1e-3, gear_ratio=2.0, offset=500.0)


@pytest.mark.parametrize(
    ("told", "is_astray"),
    [
        (course(0.0), False),
        (course(0.0009), False),
        (course(0.0011), True),
        (course(-0.1, 10.0), True),  # there now, and going on; but the axis stands
        (None, False),
    ],
)
def test_course_that_is_wrong_has_to_be_told_anew(told: Course | None, is_astray: bool) -> None:
    one = Make(1e-3, 0.0, 60.0, 1.0, 0.0, 0.0, 0.0, -500).axis()
    axes = AxisArray(2, (40, 189))
    axes.put(1, one, STANDSTILL_NM, MOST_ERROR, told)
    axes.go(np.array([0, -500], np.int32))
    assert axes.astray(10 * MS) == ([1] if is_astray else [])


def test_course_that_is_right_again_once_told_is_left_alone() -> None:
    one = Make(1e-3, 0.0, 60.0, 1.0, 0.0, 0.0, 0.0, 0).axis()
    axes = AxisArray(1, ())
    axes.put(0, one, STANDSTILL_NM, MOST_ERROR, course(1.0))
    axes.go(np.array([0], np.int32))
    assert axes.astray(0) == [0]
    axes.tell(0, course(500 * RAD / 2))
    assert axes.astray(0) == []


def test_sums_that_were_taken_begin_with_the_last_cycle() -> None:
    one = Make(1e-3, 0.0, 60.0, 0.0, 0.0, 0.0, 1.5, 0).axis()
    axes = AxisArray(1, ())
    axes.put(0, one, STANDSTILL_NM, MOST_ERROR, None)
    for _ in range(3):
        axes.go(np.array([400], np.int32))
    axes.take_sums(0)
    axes.give(0, one, before=True)
    assert (one.heats, one.works) == (0.0, 0.0)
    before = one.v
    axes.give(0, one)
    assert (one.heats, one.works) == (one.t * one.t, one.t * before)


def test_column_that_was_cleared_stays_still() -> None:
    axes = AxisArray(2, (40, 189))
    axes.put(0, Make(1e-3, 0.0, 60.0, 1.0, 0.2, 0.0, 1.5, 77).axis(), STANDSTILL_NM, MOST_ERROR, course(3.0))
    axes.clear(0)
    for _ in range(3):
        assert not axes.go(np.array([2**31 - 1, -(2**31)], np.int32)).any()
    assert axes.astray(0) == []
    assert [values.tolist() for values in axes.feedback()] == [[0, 0], [0, 0]]
