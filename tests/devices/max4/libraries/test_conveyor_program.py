"""The conveyor program of the manual, compiled, on simulated axes: its states, its axes, and a stopped program."""

from itertools import pairwise
from pathlib import Path

import pytest
from plc_bench import PlcBench

PROGRAM = Path(__file__).parents[4] / "configs" / "programs" / "conveyor.st"
AXES = ("ConveyerBelt", "Infeed", "Cutter", "Outfeed")
FEED_MM = 100.0
CYCLE_S = 0.004
INCREMENT = FEED_MM / 1_000_000


class Belt(PlcBench):
    def __init__(self, folder: Path) -> None:
        super().__init__(
            folder,
            PROGRAM.read_text(encoding="ascii"),
            simulated=AXES,
            logic_encoders=["MasterEncoder"],
            inputs={"I_bStartS1": "panel.s1"},
            outputs={"O_bEquipmentOnIndicatorH1": "panel.h1"},
            parameters={f"{axis}.FeedConst": FEED_MM for axis in AXES},
        )
        self.boot().run(100)

    def cycles(self, count: int) -> list[tuple[float, ...]]:
        """Run the ring, and return the set positions of all axes in mm after each cycle."""
        found = []
        for _ in range(count):
            self.run(CYCLE_S * 1000)
            found.append(tuple(float(self.axis(axis).set_value) * INCREMENT for axis in AXES))
        return found


@pytest.fixture
def belt(tmp_path: Path) -> Belt:
    return Belt(tmp_path)


def speeds_of(places: list[tuple[float, ...]], axis: int) -> list[float]:
    return [(later[axis] - earlier[axis]) / CYCLE_S for earlier, later in pairwise(places)]


@pytest.mark.long
@pytest.mark.manual("PD-191", "PD-192")
def test_the_states_follow_the_switch(belt: Belt) -> None:
    seen = [belt.value("g_lState_1")]

    def watch(cycles: int) -> None:
        for _ in range(cycles):
            belt.run(4)
            if (state := belt.value("g_lState_1")) != seen[-1]:
                seen.append(state)

    watch(100)
    belt.signal("panel.s1", True)
    watch(500)
    belt.signal("panel.s1", False)
    watch(1000)
    assert seen == [2, 3, 4, 5, 6, 7, 8, 9, 2]


@pytest.mark.long
@pytest.mark.manual("PD-188", "PD-189", "PD-192", "PD-193")
def test_no_axis_jumps_from_start_to_stop(belt: Belt) -> None:
    belt.run(100).signal("panel.s1", True)
    places = belt.cycles(700)
    belt.signal("panel.s1", False)
    places += belt.cycles(900)
    for axis, ratio in enumerate((1.0, 1.0, 1.0, 1.2)):
        speeds = speeds_of(places, axis)
        steps = [abs(later - earlier) for earlier, later in pairwise(speeds)]
        assert max(speeds) == pytest.approx(250 * ratio, abs=0.06)
        assert max(steps) < 2.1 * ratio + 0.1  # 490 mm/s2 of the modified sine, in 4 ms
        assert (speeds[0], speeds[-1]) == (0.0, 0.0)
    assert places[-1][0] - places[0][0] == pytest.approx(places[-1][1] - places[0][1])


@pytest.mark.manual("PD-084", "PD-182", "PD-193")
def test_an_axis_stays_on_its_cam_when_the_program_stops(belt: Belt) -> None:
    """The real-time process moves it on to the limit of the last cam that the program has given."""
    belt.run(100).signal("panel.s1", True)
    belt.cycles(500)
    belt.do("stop")
    cam = belt.cycles(600)
    speeds = speeds_of(cam, 0)
    assert speeds[0] == pytest.approx(250, abs=0.06)
    first_rest = next(n for n, speed in enumerate(speeds) if speed == 0.0)
    assert all(speed == pytest.approx(250, abs=0.06) for speed in speeds[: first_rest - 1])
    assert 200 / 250 / CYCLE_S - 5 <= first_rest <= 2 * 200 / 250 / CYCLE_S + 5  # the present part and the waiting one
    assert not any(speeds[first_rest:])
