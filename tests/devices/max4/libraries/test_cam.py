"""The block CAM: pins, results, set position modes, limits, and cams that join without a jump."""

from itertools import pairwise
from math import cos, inf, nan, pi
from typing import Any

import pytest
from cam_bench import ABSOLUTE, CYCLE_NS, NO_SETPOS, RELATIVE, CamBench
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import S
from fieldrig_devices.max4.axes.axis import AxisState
from fieldrig_devices.max4.axes.positioning import Positioner

CV = 4 * pi / (4 + pi)


@pytest.fixture
def bench() -> CamBench:
    return CamBench()


@pytest.mark.manual("PD-187")
def test_profiles_have_numbers_and_unknown_names_have_none(bench: CamBench) -> None:
    assert [bench.call("ProfilLoad", name) for name in ("modisin", "Straight", "modisin", "bogus", "")] == [
        1,
        2,
        3,
        0,
        0,
    ]


@pytest.mark.manual("PD-189")
def test_scal_foll_pos_is_the_product_by_k(bench: CamBench) -> None:
    assert bench.call("ScalFollPos", 1.0, 400.0, 1.0) == 400.0
    assert bench.call("ScalFollPos", 2.0, 400.0, CV) == pytest.approx(800 / 1.7596, rel=1e-4)
    assert bench.call("ScalFollPos", 2.0, 400.0, 0.0) == inf
    assert bench.call("ScalFollPos", -2.0, 400.0, 0.0) == -inf


@pytest.mark.manual("PD-189")
def test_the_constants_are_the_end_slopes_of_the_laws(bench: CamBench) -> None:
    text = next(library.text for library in bench.libraries if library.name == "VarioCam.lib")
    constants = dict(
        line.strip(" ;").split(" : LREAL := ") for line in text.splitlines() if "g_K_" in line and ":=" in line
    )
    for constant, name in {"g_K_MS": "modisin", "g_K_ST": "straight", "g_K_P5": "poly5"}.items():
        profile = bench.call("ProfilLoad", name)
        bench.call("ProfilSetLambda", profile, 1.0)
        bench.cam(profile, lrXFactor=1.0, instance=profile)
        begin = bench.place()
        bench.master.position += 2.0  # one length behind the end of the profile, on its tangent
        bench.run(1)
        assert bench.place() - begin == pytest.approx(1 + float(constants[constant]), abs=1e-3)


@pytest.mark.manual("PD-180", "PD-190")
def test_an_axis_follows_its_master_through_the_profile(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "simpsin")
    assert bench.cam(profile, lrXFactor=200.0, lrYFactor=50.0)[0] == 0
    begin = bench.place()
    for x in (0.0, 10.0, 77.7, 100.0, 150.0, 33.3, 200.0):
        bench.master.position = x
        bench.run(1)
        assert bench.place() - begin == pytest.approx(25 * (1 - cos(pi * x / 200)), abs=1e-3)


@pytest.mark.manual("PD-190")
def test_offsets_move_the_cam_along_both_axes(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "quadpara")
    bench.cam(profile, lrXFactor=100.0, lrYFactor=10.0, lrXOffset=20.0, lrYOffset=3.0)
    begin = bench.place()
    for x, y in (
        (0.0, 3.0),
        (20.0, 3.0),
        (70.0, 8.0),
        (95.0, 3 + 10 * (1 - 2 * 0.25**2)),
        (120.0, 13.0),
        (500.0, 13.0),
    ):
        bench.master.position = x
        bench.run(1)
        assert bench.place() - begin == pytest.approx(y, abs=1e-3)


@pytest.mark.manual("PD-190")
@pytest.mark.parametrize(
    ("low_on", "high_on", "places"),
    [
        (True, True, {80.0: 9.8, 200.0: 9.8}),
        (True, True, {30.0: 3.2, 25.0: 3.2}),
        (True, False, {25.0: 3.2, 0.0: 3.2}),
        (True, False, {100.0: 12.2, 120.0: 13.0}),
        (False, True, {25.0: 3.05, 20.0: 3.0}),
        (False, True, {79.0: 10 * (1 - 2 * 0.41**2) + 3, 90.0: 9.8}),
        (False, False, {25.0: 3.05, 100.0: 12.2}),
    ],
)
def test_each_limit_holds_only_if_it_is_on(
    bench: CamBench, low_on: bool, high_on: bool, places: dict[float, float]
) -> None:
    """y = 10 f((x - 20) / 100) + 3 for the quadratic parabola, f(z) = 2 z^2 or 1 - 2 (1 - z)^2, from x = 50 on."""
    profile = bench.call("ProfilLoad", "quadpara")
    begin, bench.master.position = bench.place(), 50.0
    bench.cam(
        profile, lrXOffset=20.0, lrYOffset=3.0, lrXFactor=100.0, lrYFactor=10.0, lrXSetposPos=50.0,
        lrXLimMin=30.0, lrXLimMax=80.0, bXLimMinOn=low_on, bXLimMaxOn=high_on,
    )  # fmt: skip
    bench.run(1)
    assert bench.place() - begin == pytest.approx(10 * 2 * 0.3**2 + 3, abs=1e-3)
    for x, y in places.items():
        bench.master.position = x
        bench.run(1)
        assert bench.place() - begin == pytest.approx(y, abs=1e-3)


@pytest.mark.manual("PD-190", "PD-191")
@pytest.mark.parametrize("origin", [-5_000.0, -1.0, 0.0, 7_000.0])
def test_limits_are_in_the_coordinates_of_the_cam_wherever_the_master_is(bench: CamBench, origin: float) -> None:
    profile = bench.call("ProfilLoad", "straight")
    begin, bench.master.position = bench.place(), origin
    bench.cam(profile, lrXFactor=100.0, lrYFactor=100.0, lrXLimMin=-50.0, lrXLimMax=80.0, bXLimMinOn=True,
              bXLimMaxOn=True)  # fmt: skip
    for x in (-49.0, 20.0, 79.0):
        bench.master.position = origin + x
        bench.run(1)
        assert bench.place() - begin == pytest.approx(x, abs=1e-3)
    bench.master.position = origin + 95.0
    bench.run(1)
    assert bench.place() - begin == pytest.approx(80.0, abs=1e-3)
    assert bench.cam(profile, bReset=False) == (0, False, True)


@pytest.mark.manual("PD-188")
def test_lambda_is_between_0_and_1(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "modisin")
    found = [bench.call("ProfilSetLambda", profile, value) for value in (-0.1, 0.0, 0.3, 1.0, 1.1, inf, nan)]
    assert found == [False, True, True, True, False, False, False]
    assert bench.call("ProfilSetLambda", profile + 1, 0.5) is False


@pytest.mark.manual("PD-191")
def test_result_0_means_that_the_cam_was_taken(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "straight")
    assert bench.part(profile, 100.0, 100.0) == (0, True, False)
    assert bench.part(profile, 100.0, 100.0, instance=200) == (0, False, False)  # waits behind the first
    assert bench.part(profile, 100.0, 100.0, instance=300)[0] == 1  # no place left
    bench.master.position = 120.0
    bench.run(1)
    assert bench.part(profile, 100.0, 100.0, instance=300, bReset=False)[0] == 0
    assert bench.part(profile, 100.0, 100.0, instance=100, bReset=False) == (0, False, True)
    assert bench.part(profile, 100.0, 100.0, instance=200, bReset=False) == (0, True, False)


@pytest.mark.manual("PD-191")
def test_without_reset_a_job_is_not_begun_twice(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "straight")
    bench.part(profile, 100.0, 100.0)
    for _ in range(5):
        assert bench.part(profile, 100.0, 100.0, bReset=False) == (0, True, False)
    assert bench.part(profile, 100.0, 100.0, instance=200)[0] == 0  # so nothing waits yet


def test_a_job_that_waits_is_judged_by_its_pins_once_the_axis_has_room(bench: CamBench) -> None:
    """While the axis has no room, a call without reset answers 1 whatever its other pins are; then they count."""
    straight = bench.call("ProfilLoad", "straight")
    bench.master.velocity = 100.0
    for instance in (1, 2):
        assert bench.part(straight, 10.0, 10.0, instance=instance)[0] == 0
    assert bench.part(straight, 10.0, 10.0, instance=3)[0] == 1
    assert bench.part(straight, 0.0, 10.0, instance=3, bReset=False)[0] == 1
    assert bench.part(straight, 0.0, 10.0, instance=3)[0] == -4  # a new job is judged at once
    assert bench.part(straight, 10.0, 10.0, instance=3)[0] == 1
    bench.run(30)  # the first cam is over, so the second one moves the axis
    assert bench.part(straight, 0.0, 10.0, instance=3, bReset=False)[0] == -4
    assert bench.part(straight, 10.0, 10.0, instance=3, bReset=False)[0] == 0


def test_wrong_pins_give_results_below_zero(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "straight")
    wrong: list[tuple[int, dict[str, Any]]] = [
        (-1, {"lAxisId": 12345}), (-2, {"lEncId": 0}), (-3, {"lProfilId": 99}), (-3, {"lProfilId": -1}),
        (-4, {"lrXFactor": 0.0}), (-4, {"lrYFactor": nan}), (-4, {"lrXOffset": inf}), (-4, {"lrYSetposPos": 1e300}),
        (-4, {"bXLimMinOn": True, "bXLimMaxOn": True}), (-4, {"bXLimMaxOn": True, "lrXLimMax": nan}),
        (-5, {"iXSetposMode": 7}), (-5, {"iYSetposMode": -1}),
    ]  # fmt: skip
    for result, pins in wrong:
        assert bench.cam(profile, **pins)[0] == result, pins
    bench.feed = 0.0
    assert bench.cam(profile)[0] == -4
    bench.feed = 1000.0
    bench.axes["belt"].enable(False)
    bench.run(2)
    assert bench.cam(profile)[0] == -6


@pytest.mark.manual("PD-188", "PD-189", "PD-192")
@pytest.mark.parametrize(("law", "k"), [("modisin", CV), ("poly5", 1.875), ("inclsin", 2.0), ("moditrap", 2.0)])
@pytest.mark.parametrize("speed", [333.3, 1000.0, 7919.0])
def test_start_straight_and_stop_join_at_the_same_speed(law: str, k: float, speed: float) -> None:
    """At every speed of the master, however far beyond the joint its next position is."""
    bench, length = CamBench(), 1000.0
    start, cycle, stop = (bench.call("ProfilLoad", name) for name in (law, "straight", law))
    bench.call("ProfilSetLambda", start, 1.0)
    bench.call("ProfilSetLambda", stop, 0.0)
    waiting = [(start, k), (cycle, 1.0), (cycle, 1.0), (stop, k)]
    begin, instance, taken_after = bench.place(), 0, []
    bench.master.velocity = speed
    cycles = round(4.2 * length / speed * S / CYCLE_NS)
    for number in range(cycles):
        if waiting and number % 3 == 0:  # a task that is slower than the ring
            profile, k_of_law = waiting[0]
            height = bench.call("ScalFollPos", 1.0, length, k_of_law)
            if bench.part(profile, length, height, instance=instance)[0] == 0:
                waiting.pop(0)
                instance += 1
                taken_after.append(number)
        bench.run(1)
    assert not waiting
    speeds = bench.speeds()
    steps = [abs(after - before) for before, after in pairwise(speeds)]
    # the largest change within a cycle is that of the law, Ca v^2 / (K length), and one increment of rounding
    assert max(steps) <= 6.3 * speed * speed / length * CYCLE_NS / S + 2 * 0.001 * S / CYCLE_NS
    assert max(speeds) == pytest.approx(speed, rel=0.002)
    assert speeds[-1] == 0.0
    assert bench.place() - begin == pytest.approx(2 * length + 2 * length / k, abs=0.01)


@given(st.floats(10, 5000), st.floats(5, 500))
def test_a_waiting_cam_begins_exactly_at_the_limit(speed: float, length: float) -> None:
    """Two straights of different slope: their common way depends on the master only, not on where cycles fall."""
    bench = CamBench()
    profile = bench.call("ProfilLoad", "straight")
    bench.part(profile, length, length)
    bench.part(profile, length, 3 * length, instance=200)
    begin, bench.master.velocity = bench.place(), speed
    for _ in range(200):
        bench.run(1)
        x = bench.master.position
        y = x if x < length else length + 3 * min(x - length, length)
        assert bench.place() - begin == pytest.approx(y, abs=2e-3)


@pytest.mark.manual("PD-193")
def test_a_cam_that_comes_too_late_begins_from_rest(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "straight")
    bench.part(profile, 100.0, 100.0)
    begin, bench.master.velocity = bench.place(), 1000.0
    bench.run(50)  # 200 ms, so the master is at 200
    assert bench.place() - begin == 100.0
    assert bench.speeds()[-1] == 0.0  # the belt jumped to rest
    assert bench.part(profile, 100.0, 100.0, instance=200)[:2] == (0, True)
    bench.run(5)
    assert bench.place() - begin == pytest.approx(120.0, abs=0.01)


@pytest.mark.manual("PD-191")
def test_set_position_modes_say_what_the_coordinates_are(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "straight")
    bench.master.position, begin = 500.0, bench.place()
    bench.cam(profile, iXSetposMode=ABSOLUTE, lrXSetposPos=30.0, iYSetposMode=ABSOLUTE, lrYSetposPos=30.0)
    bench.master.position = 510.0
    bench.run(1)
    assert bench.place() - begin == pytest.approx(10.0, abs=1e-3)
    # x goes on at 40 and becomes 30, y goes on at 40 and becomes 30: nothing moves
    shifted: dict[str, Any] = {"lrXSetposPos": -10.0, "lrYSetposPos": -10.0}
    bench.cam(profile, iXSetposMode=RELATIVE, iYSetposMode=RELATIVE, **shifted)
    bench.run(1)
    assert bench.place() - begin == pytest.approx(10.0, abs=1e-3)
    # x and y go on at 30, and the cam is twice as steep
    bench.cam(profile, iXSetposMode=NO_SETPOS, iYSetposMode=NO_SETPOS, lrYFactor=2.0)
    bench.run(1)
    assert bench.place() - begin == pytest.approx(40.0, abs=1e-3)


def test_without_set_position_a_first_cam_has_the_coordinates_of_encoder_and_axis(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "straight")
    bench.master.position = 250.0
    bench.cam(profile, iXSetposMode=NO_SETPOS, iYSetposMode=NO_SETPOS, lrYFactor=0.5)
    bench.run(1)
    assert bench.place() == pytest.approx(125.0, abs=1e-3)


def test_a_master_that_trembles_at_the_begin_does_not_end_the_cam(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "straight")
    bench.part(profile, 100.0, 100.0)
    bench.part(profile, 100.0, 100.0, instance=200)
    begin = bench.place()
    for x, y in ((0.5, 0.5), (-0.5, 0.0), (0.2, 0.2), (-3.0, 0.0), (50.0, 50.0)):
        bench.master.position = x
        bench.run(1)
        assert bench.place() - begin == pytest.approx(y, abs=1e-3)
    assert bench.part(profile, 100.0, 100.0, bReset=False)[1]


def test_a_cam_that_is_over_does_not_come_back_with_its_master(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "straight")
    bench.part(profile, 100.0, 100.0)
    begin = bench.place()
    for x in (50.0, 101.0, 40.0, 0.0):
        bench.master.position = x
        bench.run(1)
    assert bench.place() - begin == 100.0
    assert bench.part(profile, 100.0, 100.0, bReset=False) == (0, False, True)


def test_a_master_that_runs_backwards_reaches_the_lower_limit(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "straight")
    bench.cam(
        profile, lrXSetposPos=100.0, lrYSetposPos=100.0, lrXLimMax=100.0, bXLimMinOn=True, bXLimMaxOn=True,
    )  # fmt: skip
    begin, bench.master.velocity = bench.place(), -1000.0
    bench.run(50)
    assert bench.place() - begin == -100.0


def test_negative_factors_turn_the_cam_around(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "quadpara")
    bench.cam(profile, lrXFactor=-100.0, lrYFactor=-10.0)
    begin = bench.place()
    for x, y in ((-25.0, -1.25), (-50.0, -5.0), (-100.0, -10.0), (20.0, 0.0)):
        bench.master.position = x
        bench.run(1)
        assert bench.place() - begin == pytest.approx(y, abs=1e-3)


@pytest.mark.manual("PD-183", "PD-180")
def test_a_law_is_changed_while_a_cam_of_it_runs(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "quadpara")
    bench.cam(profile, lrXFactor=100.0, lrYFactor=100.0)
    begin = bench.place()
    assert bench.call("ProfilSetLambda", profile, 1.0)
    bench.master.position = 50.0
    bench.run(1)
    assert bench.place() - begin == pytest.approx(50.0, abs=1e-3)  # the cam that runs keeps its shape
    bench.cam(profile, lrXFactor=100.0, lrYFactor=100.0, instance=200)
    bench.master.position = 100.0
    bench.run(1)
    assert bench.place() - begin == pytest.approx(75.0, abs=1e-3)  # 50 and 100 * 0.5^2 more
    assert not bench.call("ProfilSetLambda", profile, 1.5)
    assert not bench.call("ProfilSetLambda", 99, 1.0)


def test_another_source_takes_the_axis_over_and_the_cam_is_over(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "straight")
    bench.part(profile, 100.0, 100.0)
    bench.part(profile, 100.0, 100.0, instance=200)
    bench.axes["belt"].follow(None)
    assert bench.part(profile, 100.0, 100.0, bReset=False) == (0, False, True)
    assert bench.part(profile, 100.0, 100.0, instance=200, bReset=False) == (0, False, True)
    bench.master.position = 50.0
    bench.run(2)
    assert bench.part(profile, 100.0, 100.0, instance=300) == (0, True, False)


def test_an_axis_that_loses_control_forgets_its_cams(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "straight")
    bench.part(profile, 100.0, 100.0)
    bench.master.velocity = 100.0
    bench.run(10)
    axis = bench.axes["belt"]
    axis.enable(False)
    bench.run(5)
    axis.enable(True)
    bench.run(40)
    assert axis.axis_state is AxisState.CONTROLLED
    rest = bench.place()
    bench.run(10)
    assert bench.place() == rest
    assert bench.part(profile, 100.0, 100.0, bReset=False) == (0, False, True)


def test_a_cam_begins_on_an_axis_that_moves_without_a_step(bench: CamBench) -> None:
    bench.call("PosVelocity", bench.axes["belt"].log_adr, 100.0, 1000.0, 1000.0)
    bench.run(100)
    assert isinstance(bench.axes["belt"].set_values, Positioner)
    profile = bench.call("ProfilLoad", "straight")
    bench.master.velocity = 100.0
    bench.cam(profile)
    bench.run(20)
    assert bench.speeds()[80:] == pytest.approx([100.0] * len(bench.speeds()[80:]), abs=0.3)


def test_positions_that_no_drive_has_leave_the_axis_where_it_is(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "modisin")
    bench.call("ProfilSetLambda", profile, 1.0)
    bench.cam(profile, lrXFactor=1e-9, lrYFactor=1e12)
    begin = bench.place()
    bench.master.position = 1e308
    bench.run(2)
    assert bench.place() == begin


@pytest.mark.manual("PD-180")
def test_numbers_of_a_program_that_begins_anew_begin_anew(bench: CamBench) -> None:
    bench.call("ProfilLoad", "modisin")
    cam = next(library.blocks["cam"] for library in bench.libraries if "cam" in library.blocks)
    cam.forget()
    assert bench.call("ProfilLoad", "straight") == 1
