"""The axis against closed solutions: what physics and control theory promise."""

import struct
from math import exp, isclose, pi, tau

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.mc4.axis import Axis, Mode
from fieldrig_devices.mc4.fold import Numbers, folded
from fieldrig_devices.mc4.loops import INCREMENTS, INNER_S, RAD, Elastic, Gains, Limits, Plant
from fieldrig_devices.mc4.matrices import exponential
from fieldrig_devices.plants.axis_model import Mechanics, State, after

quick = settings(max_examples=60, deadline=None)
J = 1.2e-3
PLANT = Plant(J, viscous=2e-4)
KP = J * 400
GAINS = Gains(kv=60.0, kp=KP, ki=KP / 0.02, ff=0.0)
LAGLESS = Gains(60.0, KP, KP / 0.02, 1.0)
LIMITS = Limits(torque=32.0, speed=500.0)
CHANGING = (
    "e", "v", "i", "t", "twist", "load_speed", "way", "moved", "set_increments", "lead", "heats", "works", "is_at_rest",
)  # fmt: skip


def axis(
    plant: Plant = PLANT, gains: Gains = GAINS, limits: Limits = LIMITS, *, dry: float = 0.0, brake: float = 0.0
) -> Axis:
    one = Axis(plant, gains, limits, dry_nm=dry, brake_nm=brake)
    one.brake(False)
    return one


def stepped(one: Axis, target: int) -> None:
    """The same cycle by inner steps."""
    one.follow(target)
    one.go(16)


def states(one: Axis) -> tuple[float, ...]:
    return one.e, one.v, one.i, one.t, one.twist, one.load_speed


def everything(one: Axis) -> dict[str, object]:
    """Return the changing part of the state, by name."""
    return {name: getattr(one, name) for name in CHANGING}


@quick
@given(
    st.floats(-0.01, 0.01), st.floats(-30, 30), st.floats(-2, 2), st.integers(-3000, 3000), st.sampled_from([0.0, 0.4])
)
def test_folded_cycle_is_the_sixteen_steps(e: float, v: float, i: float, way: int, dry: float) -> None:
    one, other = axis(dry=dry), axis(dry=dry)
    for each in (one, other):
        each.control(Mode.POSITION)
        each.e, each.v, each.i, each.t = e, v, i, i
        each.load(0.3)
    one.follow(way)
    one.cycle()
    stepped(other, way)
    assert states(one) == pytest.approx(states(other), rel=1e-9, abs=1e-9)
    assert one.set_increments == other.set_increments


@quick
@given(
    st.floats(-0.1, 0.1), st.floats(-300, 300), st.floats(-20, 20), st.floats(-20, 20), st.integers(-8000, 8000),
    st.sampled_from([0.0, 1.0]),
)  # fmt: skip
def test_no_step_of_a_folded_cycle_meets_a_limit(e: float, v: float, i: float, t: float, way: int, ff: float) -> None:
    """`way` is that of a step."""
    gains = Gains(60.0, KP, KP / 0.02, ff)
    limits = Limits(20.0, 250.0)
    one, other = axis(gains=gains), axis(gains=gains)
    for each in (one, other):
        each.e, each.v, each.i, each.t = e, v, i, t
        each.load(0.5)
    one.way = 16 * way
    if not folded(PLANT, gains, limits, 16, 1e-12)(one):
        assert states(one) == states(other)
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
    assert states(one) == pytest.approx(states(other), rel=1e-9, abs=1e-9)


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
    one, other = axis(plant, gains, dry=dry), axis(plant, gains, dry=dry)
    for each in (one, other):
        each.arrange(plant, gains, LIMITS, 16, lead_inertia=J / 2)
        each.control(Mode.POSITION)
        each.load(load)
        each.follow(700)
    go = one.following(Numbers(("place", "new_e", "new_v", "new_t"), "qddd"), is_published=False)
    assert go is not None
    for increments in wanted:
        before = everything(one)
        values = go(one, increments, 0.05, 0, None)
        other.cycle()
        if values is None:
            assert everything(one) == before
            one.cycle()
        else:
            assert values == struct.pack("<qddd", other.set_increments, other.e, other.v, other.t)
            assert abs(other.e) < 0.05
        other.follow(increments)
        if values is None:
            one.follow(increments)
        assert everything(one) == everything(other)


@pytest.mark.parametrize("way", [0, 2_500])
def test_axis_follows_by_one_map_while_nothing_is_limited(way: int) -> None:
    one = axis(gains=LAGLESS)
    one.control(Mode.POSITION)
    go = one.following(Numbers(("place",), "i"), is_published=False)
    assert go is not None
    assert [go(one, way * cycle, 1.0, 0, None) for cycle in range(1, 5)] == [
        struct.pack("<i", cycle * way) for cycle in range(4)
    ]
    assert one.slow_cycles == 0


def test_braked_axis_and_one_without_position_control_do_not_follow() -> None:
    one = axis(brake=2.0)
    assert one.following(Numbers(("place",), "i"), is_published=False) is None
    one.control(Mode.POSITION)
    one.brake(True)
    assert one.following(Numbers(("place",), "i"), is_published=False) is None


def test_exponential_of_a_matrix() -> None:
    turn = exponential([[0.0, -pi / 3], [pi / 3, 0.0]])
    assert turn[0] == pytest.approx([0.5, -(3**0.5) / 2])
    assert exponential([[-50.0]])[0][0] == pytest.approx(exp(-50.0), rel=1e-9)


def test_step_of_torque_is_the_closed_solution() -> None:
    one = axis()
    one.control(Mode.TORQUE)
    one.set_value(2.0)
    one.go(400)
    want = after(Mechanics(J, PLANT.viscous, lag_s=PLANT.lag_s), State(0.0), 2.0, 0.0, 400 * INNER_S)
    assert one.v == pytest.approx(want.speed, rel=1e-9)
    assert one.position * RAD == pytest.approx(want.position, rel=1e-6)
    assert one.t == pytest.approx(2.0)


@pytest.mark.manual("PD-164")
@pytest.mark.parametrize("way", [2_000, -5_000])
def test_following_error_at_steady_speed_is_speed_over_kv(way: int) -> None:
    one = axis()
    one.control(Mode.POSITION)
    for cycle in range(1, 501):
        one.follow(way * cycle)
        one.cycle()
    speed = way * RAD / 0.004
    assert one.v == pytest.approx(speed, rel=1e-9)
    assert one.e == pytest.approx(speed / GAINS.kv, rel=1e-6)
    assert one.t == pytest.approx(PLANT.viscous * speed, rel=1e-6)
    assert one.slow_cycles == 0


@pytest.mark.manual("PD-164")
def test_set_position_is_reached_within_a_cycle_and_stays_for_the_steps_that_follow() -> None:
    one, other = axis(), axis()
    for each in (one, other):
        each.control(Mode.POSITION)
        each.follow(2_000)
    one.go(16 + 40)
    for steps in (16, 16, 16, 8):
        other.go(steps)
        other.follow(2_000)
    assert states(one) == pytest.approx(states(other), abs=1e-12)
    assert one.set_increments == other.set_increments == 2_000


def test_speed_feed_forward_leaves_no_following_error() -> None:
    one = axis(gains=LAGLESS)
    one.control(Mode.POSITION)
    for cycle in range(1, 501):
        one.follow(3_000 * cycle)
        one.cycle()
    assert abs(one.e) < 1e-9


@pytest.mark.manual("PD-164")
def test_current_feed_forward_reduces_the_following_error() -> None:
    errors = []
    for inertia in (0.0, J):
        one = axis(gains=LAGLESS)
        one.arrange(PLANT, LAGLESS, LIMITS, 16, inertia)
        one.control(Mode.POSITION)
        worst = 0.0
        for cycle in range(1, 101):
            one.follow(10 * cycle * cycle)
            one.cycle()
            worst = max(worst, abs(one.e))
        errors.append(worst)
    assert errors[1] < errors[0] / 2


@pytest.mark.manual("PD-164")
def test_speed_regulator_takes_the_load_and_hardly_overshoots() -> None:
    one = axis()
    one.control(Mode.SPEED)
    one.load(3.0)
    one.set_value(10.0)
    seen = []
    for _ in range(2_000):
        one.go(1)
        seen.append(one.v)
    assert max(seen) < 10.0 * 1.25
    assert seen[-1] == pytest.approx(10.0, rel=1e-6)
    assert one.t == pytest.approx(3.0 + PLANT.viscous * 10.0, rel=1e-6)


def test_position_step_does_not_overshoot() -> None:
    one = axis()
    one.control(Mode.POSITION)
    highest = 0.0
    for _ in range(250):
        one.follow(1_000)
        one.cycle()
        highest = max(highest, one.position)
    assert highest <= 1_000 * 1.05
    assert one.position == pytest.approx(1_000, abs=0.5)


@pytest.mark.parametrize("torque", [4.0, 16.0])
def test_stops_with_maximum_current(torque: float) -> None:
    """J dw / T, but for the lag of the current and the last of it, where the regulator lets go."""
    one = axis(limits=Limits(torque, 500.0))
    one.v = 300.0
    one.control(Mode.SPEED)
    one.set_value(0.0)
    steps = 0
    while one.v > 15.0:
        one.go(1)
        steps += 1
    assert steps * INNER_S == pytest.approx(J * 285.0 / torque, rel=0.05, abs=1.5e-3)


def test_energy_given_is_energy_kept_and_rubbed_off() -> None:
    one = axis(Plant(J), dry=0.5)
    one.control(Mode.TORQUE)
    one.set_value(2.0)
    one.go(800)
    _, work = one.take(1.0)
    turned = one.position * RAD
    assert work == pytest.approx(J * one.v**2 / 2 + 0.5 * turned, rel=0.01)


def test_coasting_motor_comes_to_rest_as_friction_says() -> None:
    one = axis(Plant(J), dry=0.5)
    one.v = 100.0
    one.go(4 * 230)
    assert one.v == pytest.approx(100.0 - 0.5 / J * 0.23, rel=1e-6)
    one.go(100)
    assert one.v == 0.0
    assert one.position * RAD == pytest.approx(J * 100.0**2 / 2 / 0.5, rel=1e-6)
    assert one.is_at_rest


@pytest.mark.manual("PD-161")
def test_brake_holds_a_weight_and_without_it_falls() -> None:
    one = axis(brake=9.0)
    one.brake(True)
    one.load(5.0)
    one.go(4_000)
    assert (one.v, one.position) == (0.0, 0.0)
    one.brake(False)
    one.go(400)
    assert one.v < -100


@pytest.mark.manual("PD-161")
def test_uncontrolled_stop_is_shorter_with_a_brake() -> None:
    ways = []
    for brake in (0.0, 9.0):
        one = axis(dry=0.2, brake=brake)
        one.v = 100.0
        one.brake(brake > 0)
        one.go(8_000)
        assert one.v == 0.0
        ways.append(one.position)
    assert ways[1] < ways[0] / 20


def test_friction_brings_it_to_rest_within_half_an_increment() -> None:
    one = axis(dry=0.3)
    one.control(Mode.POSITION)
    for cycle in range(500):
        one.follow(min(500 * cycle, 50_000))
        one.cycle()
    assert one.is_at_rest
    assert abs(one.position - 50_000) <= 0.5


def test_far_command_is_approached_with_the_highest_speed() -> None:
    one = axis(limits=Limits(32.0, 50.0), gains=LAGLESS)
    one.control(Mode.POSITION)
    for _ in range(100):
        one.follow(2_000_000_000)
        one.cycle()
    assert one.v == pytest.approx(50.0, rel=1e-3)


def test_positions_go_on_over_the_32_bits_of_the_ring() -> None:
    one = axis()
    one.put(2_147_483_000)
    one.control(Mode.POSITION)
    one.follow(-2_147_483_648 + 1_000)  # 1648 further
    for _ in range(100):
        one.cycle()
    assert one.position == pytest.approx(2_147_484_648, abs=0.5)


def test_changing_control_keeps_the_position() -> None:
    one = axis()
    one.put(123_456)
    one.v, one.e = 5.0, 0.001
    before = one.position
    for mode in (Mode.SPEED, Mode.POSITION, Mode.TORQUE, Mode.FREE):
        one.control(mode)
        assert isclose(one.position, before, abs_tol=1e-6)


ELASTIC = Plant(4e-4, 1e-4, elastic=Elastic(inertia=8e-4, stiffness=400.0, damping=0.02))


def test_load_behind_a_coupling_swings_with_its_own_frequency() -> None:
    """The motor held by its brake: the load alone on the spring."""
    still = Plant(1e6, elastic=Elastic(8e-4, 400.0, 0.0))
    one = axis(still)
    one.twist = 0.01
    turns, before = 0, one.load_speed
    for _ in range(4_000):  # 1 s
        one.go(1)
        turns += before <= 0 < one.load_speed
        before = one.load_speed
    assert turns == pytest.approx((400.0 / 8e-4) ** 0.5 / tau, abs=1.5)


def test_coupling_carries_the_load_at_steady_speed() -> None:
    gains = Gains(30.0, 1.2e-3 * 150, 1.2e-3 * 150 / 0.05, 1.0)
    one, other = axis(ELASTIC, gains), axis(ELASTIC, gains)
    for each in (one, other):
        each.control(Mode.POSITION)
        each.load(2.0)
    for cycle in range(1, 1_001):
        one.follow(2_000 * cycle)
        one.cycle()
        stepped(other, 2_000 * cycle)
    assert states(one) == pytest.approx(states(other), rel=1e-6, abs=1e-6)
    assert one.twist == pytest.approx(2.0 / 400.0, rel=1e-6)
    assert one.load_speed == pytest.approx(one.v, rel=1e-6)
    assert one.slow_cycles < 5
    assert pytest.approx(1.0) == RAD * INCREMENTS
