"""An ST1 that takes steady set-points as no event says the same, to the last bit, as one that looks at everything."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from st1_device_bench import DeviceBench

from fieldrig.testing import plain_forms
from fieldrig_devices.pamring.frames import AxisOrder, EndOfPipe, Move, SetPoint, SetPointMode
from fieldrig_devices.st1.servo import STEADY
from fieldrig_devices.st1.shaft import TURN

POINTS = ("position", "speed", "set_position", "lag")
MOVES = (Move.RELATIVE_MOVE, Move.STOP, Move.POWER_ON, Move.POWER_OFF, Move.POSITION)
ways = st.tuples(
    st.just("way"),
    st.sampled_from([0, 1, 1000, TURN // 1000, TURN // 100, -TURN // 100, TURN // 30]),
    st.integers(1, 40),
)
commands = st.one_of(
    ways,
    ways,
    ways,
    st.tuples(st.just("pause"), st.just(0), st.integers(1, 30)),
    st.tuples(st.sampled_from(["load_torque", "supply"]), st.sampled_from([0, 1, 10, 24]), st.integers(1, 5)),
    st.tuples(st.just("move"), st.integers(0, len(MOVES) - 1), st.integers(1, 30)),
    st.tuples(st.just("torque"), st.sampled_from([0, 10, 1000]), st.integers(1, 20)),
    st.tuples(st.just("end"), st.just(0), st.integers(1, 20)),
)
scripts = st.lists(commands, min_size=1, max_size=12)


class Playing:
    """An ST1 with power that a pipe drives."""

    def __init__(self) -> None:
        self.bench = DeviceBench()
        self.bench.send(AxisOrder(1, Move.POWER_ON)).run(100)
        self.number, self.value = 1, 0

    def play(self, what: str, value: int, cycles: int) -> None:
        bench = self.bench
        if what == "move":
            self.number += 1
            bench.send(AxisOrder(self.number, MOVES[value], TURN // 4, TURN, 10 * TURN, 10 * TURN))
        elif what == "torque":
            bench.send(SetPoint(SetPointMode.TORQUE, value))
        elif what == "end":
            bench.send(EndOfPipe(SetPointMode.POSITION))
        elif what in ("load_torque", "supply"):
            bench.drive(what, value, "N m" if what == "load_torque" else "V")
        for _ in range(cycles):
            if what == "way":
                self.value += value
                bench.send(SetPoint(SetPointMode.POSITION, self.value))
            bench.run(1)


def trace(script: list[tuple[str, int, int]]) -> list[str]:
    """Return the wires, the reports and the points after each part of a script."""
    playing, shown = Playing(), []
    for part in script:
        playing.play(*part)
        bench = playing.bench
        shown.append(repr((part, bench.wires, bench.pam.reports, [bench.get(point) for point in POINTS])))
        bench.wires.clear()
        bench.pam.reports.clear()
    return shown


@pytest.mark.long
@settings(max_examples=20, deadline=None)
@given(scripts)
def test_an_axis_that_follows_steadily_says_the_same_in_both_forms(script: list[tuple[str, int, int]]) -> None:
    with plain_forms(STEADY.name):
        plain = trace(script)
    assert trace(script) == plain
