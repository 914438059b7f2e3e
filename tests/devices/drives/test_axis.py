"""The axis against closed solutions: what physics and control theory promise."""

import struct
from math import exp, isclose, pi, tau

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.drives.axis import Axis, Mode
from fieldrig_devices.drives.fold import Numbers, folded
from fieldrig_devices.drives.loops import INCREMENTS, INNER_S, RAD, Elastic, Gains, Limits, Plant
from fieldrig_devices.drives.matrices import exponential
from fieldrig_devices.plants.axis_model import Mechanics, State, after

quick = settings(max_examples=60, deadline=None)
J = 1.2e-3
PLANT = Plant(J, viscous=2e-4)
KP = J * 400
GAINS = Gains(kv=60.0, kp=KP, ki=KP / 0.02, ff=0.0)
LAGLESS = Gains(60.0, KP, KP / 0.02, 1.0)
LIMITS = Limits(torque=32.0, speed=500.0)
CHANGING = (
    "e", "v", "i", "t", "twist", "load_speed", "way", "moved", "set_increments", "lead", "heat", "work", "is_at_rest",
)  # fmt: skip


def make_axis(
    plant: Plant = PLANT, gains: Gains = GAINS, limits: Limits = LIMITS, *, dry: float = 0.0, brake: float = 0.0
) -> Axis:
    axis = Axis(plant, gains, limits, dry_nm=dry, brake_nm=brake)
    axis.brake(False)
    return axis


def stepped(axis: Axis, target: int) -> None:
    """The same cycle by inner steps."""
    axis.follow(target)
    axis.go(16)


def states(axis: Axis) -> tuple[float, ...]:
    return axis.e, axis.v, axis.i, axis.t, axis.twist, axis.load_speed


def everything(axis: Axis) -> dict[str, object]:
    """Return the changing part of the state, by name."""
    return {name: getattr(axis, name) for name in CHANGING}


@pytest.mark.long
@quick
@given(
    st.floats(-0.01, 0.01), st.floats(-30, 30), st.floats(-2, 2), st.integers(-3000, 3000), st.sampled_from([0.0, 0.4])
)
def test_folded_cycle_is_the_sixteen_steps(e: float, v: float, i: float, way: int, dry: float) -> None:
    axis, other = make_axis(dry=dry), make_axis(dry=dry)
    for each in (axis, other):
        each.control(Mode.POSITION)
        each.e, each.v, each.i, each.t = e, v, i, i
        each.load(0.3)
    axis.follow(way)
    axis.cycle()
    stepped(other, way)
    assert states(axis) == pytest.approx(states(other), rel=1e-9, abs=1e-9)
    assert axis.set_increments == other.set_increments


@pytest.mark.long
@quick
@given(
    st.floats(-0.1, 0.1), st.floats(-300, 300), st.floats(-20, 20), st.floats(-20, 20), st.integers(-8000, 8000),
    st.sampled_from([0.0, 1.0]),
)  # fmt: skip
def test_no_step_of_a_folded_cycle_meets_a_limit(e: float, v: float, i: float, t: float, way: int, ff: float) -> None:
    """`way` is that of a step."""
    gains = Gains(60.0, KP, KP / 0.02, ff)
    limits = Limits(20.0, 250.0)
    axis, other = make_axis(gains=gains), make_axis(gains=gains)
    for each in (axis, other):
        each.e, each.v, each.i, each.t = e, v, i, t
        each.load(0.5)
    axis.way = 16 * way
    if not folded(PLANT, gains, limits, 16, 1e-12)(axis):
        assert states(axis) == states(other)
        return
    speed = way * RAD / INNER_S
    step = folded(PLANT, gains, Limits(1e9, 1e9), 1)
    for _ in range(16):
        wish = gains.kv * other.e + gains.ff * speed
        assert abs(wish) <= limits.speed * 1.000001
        assert abs(gains.kp * (wish - other.v) + other.i) <= limits.torque * 1.000001
        assert other.v * speed > 0
        other.way = way
        assert step(other)
    assert states(axis) == pytest.approx(states(other), rel=1e-9, abs=1e-9)


@pytest.mark.long
@quick
@given(
    st.sampled_from([PLANT, Plant(4e-4, 1e-4, elastic=Elastic(inertia=8e-4, stiffness=400.0, damping=0.02))]),
    st.sampled_from([GAINS, LAGLESS]), st.sampled_from([0.0, 0.3]), st.floats(-3, 3),
    st.lists(st.integers(-0x8000_0000, 0x7FFF_FFFF) | st.integers(-9_000, 9_000), min_size=1, max_size=40),
)  # fmt: skip
def test_axis_that_only_follows_goes_the_same_way(
    plant: Plant, gains: Gains, dry: float, load: float, wanted: list[int]
) -> None:
    """Bit by bit."""
    axis, other = make_axis(plant, gains, dry=dry), make_axis(plant, gains, dry=dry)
    for each in (axis, other):
        each.arrange(plant, gains, LIMITS, 16, lead_inertia=J / 2)
        each.control(Mode.POSITION)
        each.load(load)
        each.follow(700)
    go = axis.following(Numbers(("target", "new_e", "new_v", "new_t"), "qddd"), is_published=False)
    assert go is not None
    for increments in wanted:
        before = everything(axis)
        values = go(axis, increments, 0.05, 0, None)
        other.cycle()
        if values is None:
            assert everything(axis) == before
            axis.cycle()
        else:
            assert values == struct.pack("<qddd", other.set_increments, other.e, other.v, other.t)
            assert abs(other.e) < 0.05
        other.follow(increments)
        if values is None:
            axis.follow(increments)
        assert everything(axis) == everything(other)


@pytest.mark.parametrize("way", [0, 2_500])
def test_axis_follows_by_one_map_while_nothing_is_limited(way: int) -> None:
    axis = make_axis(gains=LAGLESS)
    axis.control(Mode.POSITION)
    go = axis.following(Numbers(("target",), "i"), is_published=False)
    assert go is not None
    assert [go(axis, way * cycle, 1.0, 0, None) for cycle in range(1, 5)] == [
        struct.pack("<i", cycle * way) for cycle in range(4)
    ]
    assert axis.slow_cycles == 0


def test_braked_axis_and_one_without_position_control_do_not_follow() -> None:
    axis = make_axis(brake=2.0)
    assert axis.following(Numbers(("target",), "i"), is_published=False) is None
    axis.control(Mode.POSITION)
    axis.brake(True)
    assert axis.following(Numbers(("target",), "i"), is_published=False) is None


def test_exponential_of_a_matrix() -> None:
    turn = exponential([[0.0, -pi / 3], [pi / 3, 0.0]])
    assert turn[0] == pytest.approx([0.5, -(3**0.5) / 2])
    assert exponential([[-50.0]])[0][0] == pytest.approx(exp(-50.0), rel=1e-9)


def test_step_of_torque_is_the_closed_solution() -> None:
    axis = make_axis()
    axis.control(Mode.TORQUE)
    axis.set_value(2.0)
    axis.go(400)
    want = after(Mechanics(J, PLANT.viscous, lag_s=PLANT.lag_s), State(0.0), 2.0, 0.0, 400 * INNER_S)
    assert axis.v == pytest.approx(want.speed, rel=1e-9)
    assert axis.position * RAD == pytest.approx(want.position, rel=1e-6)
    assert axis.t == pytest.approx(2.0)


@pytest.mark.manual("PD-164")
@pytest.mark.parametrize("way", [2_000, -5_000])
def test_following_error_at_steady_speed_is_speed_over_kv(way: int) -> None:
    axis = make_axis()
    axis.control(Mode.POSITION)
    for cycle in range(1, 501):
        axis.follow(way * cycle)
        axis.cycle()
    speed = way * RAD / 0.004
    assert axis.v == pytest.approx(speed, rel=1e-9)
    assert axis.e == pytest.approx(speed / GAINS.kv, rel=1e-6)
    assert axis.t == pytest.approx(PLANT.viscous * speed, rel=1e-6)
    assert axis.slow_cycles == 0


@pytest.mark.manual("PD-164")
def test_set_position_is_reached_within_a_cycle_and_stays_for_the_steps_that_follow() -> None:
    axis, other = make_axis(), make_axis()
    for each in (axis, other):
        each.control(Mode.POSITION)
        each.follow(2_000)
    axis.go(16 + 40)
    for steps in (16, 16, 16, 8):
        other.go(steps)
        other.follow(2_000)
    assert states(axis) == pytest.approx(states(other), abs=1e-12)
    assert axis.set_increments == other.set_increments == 2_000


def test_speed_feed_forward_leaves_no_following_error() -> None:
    axis = make_axis(gains=LAGLESS)
    axis.control(Mode.POSITION)
    for cycle in range(1, 501):
        axis.follow(3_000 * cycle)
        axis.cycle()
    assert abs(axis.e) < 1e-9


@pytest.mark.manual("PD-164")
def test_current_feed_forward_reduces_the_following_error() -> None:
    errors = []
    for inertia in (0.0, J):
        axis = make_axis(gains=LAGLESS)
        axis.arrange(PLANT, LAGLESS, LIMITS, 16, inertia)
        axis.control(Mode.POSITION)
        worst = 0.0
        for cycle in range(1, 101):
            axis.follow(10 * cycle * cycle)
            axis.cycle()
            worst = max(worst, abs(axis.e))
        errors.append(worst)
    assert errors[1] < errors[0] / 2


@pytest.mark.manual("PD-164")
def test_speed_regulator_takes_the_load_and_hardly_overshoots() -> None:
    axis = make_axis()
    axis.control(Mode.SPEED)
    axis.load(3.0)
    axis.set_value(10.0)
    seen = []
    for _ in range(2_000):
        axis.go(1)
        seen.append(axis.v)
    assert max(seen) < 10.0 * 1.25
    assert seen[-1] == pytest.approx(10.0, rel=1e-6)
    assert axis.t == pytest.approx(3.0 + PLANT.viscous * 10.0, rel=1e-6)


def test_position_step_does_not_overshoot() -> None:
    axis = make_axis()
    axis.control(Mode.POSITION)
    highest = 0.0
    for _ in range(250):
        axis.follow(1_000)
        axis.cycle()
        highest = max(highest, axis.position)
    assert highest <= 1_000 * 1.05
    assert axis.position == pytest.approx(1_000, abs=0.5)


@pytest.mark.parametrize("torque", [4.0, 16.0])
def test_stops_with_maximum_current(torque: float) -> None:
    """J dw / T, but for the lag of the current and the last of it, where the regulator lets go."""
    axis = make_axis(limits=Limits(torque, 500.0))
    axis.v = 300.0
    axis.control(Mode.SPEED)
    axis.set_value(0.0)
    steps = 0
    while axis.v > 15.0:
        axis.go(1)
        steps += 1
    assert steps * INNER_S == pytest.approx(J * 285.0 / torque, rel=0.05, abs=1.5e-3)


def test_energy_given_is_energy_kept_and_rubbed_off() -> None:
    axis = make_axis(Plant(J), dry=0.5)
    axis.control(Mode.TORQUE)
    axis.set_value(2.0)
    axis.go(800)
    _, work = axis.take(1.0)
    turned = axis.position * RAD
    assert work == pytest.approx(J * axis.v**2 / 2 + 0.5 * turned, rel=0.01)


def test_coasting_motor_comes_to_rest_as_friction_says() -> None:
    axis = make_axis(Plant(J), dry=0.5)
    axis.v = 100.0
    axis.go(4 * 230)
    assert axis.v == pytest.approx(100.0 - 0.5 / J * 0.23, rel=1e-6)
    axis.go(100)
    assert axis.v == 0.0
    assert axis.position * RAD == pytest.approx(J * 100.0**2 / 2 / 0.5, rel=1e-6)
    assert axis.is_at_rest


@pytest.mark.manual("PD-161")
def test_brake_holds_a_weight_and_without_it_falls() -> None:
    axis = make_axis(brake=9.0)
    axis.brake(True)
    axis.load(5.0)
    axis.go(4_000)
    assert (axis.v, axis.position) == (0.0, 0.0)
    axis.brake(False)
    axis.go(400)
    assert axis.v < -100


@pytest.mark.manual("PD-161")
def test_uncontrolled_stop_is_shorter_with_a_brake() -> None:
    ways = []
    for brake in (0.0, 9.0):
        axis = make_axis(dry=0.2, brake=brake)
        axis.v = 100.0
        axis.brake(brake > 0)
        axis.go(8_000)
        assert axis.v == 0.0
        ways.append(axis.position)
    assert ways[1] < ways[0] / 20


def test_friction_brings_it_to_rest_within_half_an_increment() -> None:
    axis = make_axis(dry=0.3)
    axis.control(Mode.POSITION)
    for cycle in range(500):
        axis.follow(min(500 * cycle, 50_000))
        axis.cycle()
    assert axis.is_at_rest
    assert abs(axis.position - 50_000) <= 0.5


def test_far_command_is_approached_with_the_highest_speed() -> None:
    axis = make_axis(limits=Limits(32.0, 50.0), gains=LAGLESS)
    axis.control(Mode.POSITION)
    for _ in range(100):
        axis.follow(2_000_000_000)
        axis.cycle()
    assert axis.v == pytest.approx(50.0, rel=1e-3)


def test_positions_go_on_over_the_32_bits_of_the_ring() -> None:
    axis = make_axis()
    axis.put(2_147_483_000)
    axis.control(Mode.POSITION)
    axis.follow(-2_147_483_648 + 1_000)  # 1648 further
    for _ in range(100):
        axis.cycle()
    assert axis.position == pytest.approx(2_147_484_648, abs=0.5)


def test_changing_control_keeps_the_position() -> None:
    axis = make_axis()
    axis.put(123_456)
    axis.v, axis.e = 5.0, 0.001
    before = axis.position
    for mode in (Mode.SPEED, Mode.POSITION, Mode.TORQUE, Mode.FREE):
        axis.control(mode)
        assert isclose(axis.position, before, abs_tol=1e-6)


ELASTIC = Plant(4e-4, 1e-4, elastic=Elastic(inertia=8e-4, stiffness=400.0, damping=0.02))


@pytest.mark.long
def test_load_behind_a_coupling_swings_with_its_own_frequency() -> None:
    """The motor held by its brake: the load alone on the spring."""
    still = Plant(1e6, elastic=Elastic(8e-4, 400.0, 0.0))
    axis = make_axis(still)
    axis.twist = 0.01
    turns, before = 0, axis.load_speed
    for _ in range(4_000):  # 1 s
        axis.go(1)
        turns += before <= 0 < axis.load_speed
        before = axis.load_speed
    assert turns == pytest.approx((400.0 / 8e-4) ** 0.5 / tau, abs=1.5)


@pytest.mark.long
def test_coupling_carries_the_load_at_steady_speed() -> None:
    gains = Gains(30.0, 1.2e-3 * 150, 1.2e-3 * 150 / 0.05, 1.0)
    axis, other = make_axis(ELASTIC, gains), make_axis(ELASTIC, gains)
    for each in (axis, other):
        each.control(Mode.POSITION)
        each.load(2.0)
    for cycle in range(1, 1_001):
        axis.follow(2_000 * cycle)
        axis.cycle()
        stepped(other, 2_000 * cycle)
    assert states(axis) == pytest.approx(states(other), rel=1e-6, abs=1e-6)
    assert axis.twist == pytest.approx(2.0 / 400.0, rel=1e-6)
    assert axis.load_speed == pytest.approx(axis.v, rel=1e-6)
    assert axis.slow_cycles < 5
    assert pytest.approx(1.0) == RAD * INCREMENTS
