"""The closed solution of an axis against fine steps of another method, and against what physics promises."""

import itertools
import math
from math import inf

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.plants.axis_model import Mechanics, Segment, State, after

quick = settings(max_examples=60, deadline=None)
torques = st.floats(-3, 3).map(lambda x: round(x, 3))


@st.composite
def axes(draw: st.DrawFn) -> Mechanics:
    coulomb = draw(st.sampled_from([0.0, 0.1, 0.5]))
    return Mechanics(
        inertia=draw(st.sampled_from([1e-3, 0.02, 1.0])),
        viscous=draw(st.sampled_from([0.0, 1e-6, 1e-3, 0.05, 2.0])),
        coulomb=coulomb,
        breakaway=coulomb * draw(st.sampled_from([1.0, 1.3])),
        low=draw(st.sampled_from([-inf, -1.0])),
        high=draw(st.sampled_from([inf, 2.0])),
        lag_s=draw(st.sampled_from([0.0, 0.001, 0.03])),
    )


states = st.builds(State, st.floats(-1, 2), st.floats(-50, 50).map(lambda x: round(x, 3)), st.just(0.0))


def stepped(axis: Mechanics, state: State, reference: float, load: float, seconds: float, steps: int) -> State:
    """The same axis by Heun's method in fine steps: dry friction as a force that cannot turn the speed round."""
    position, speed, torque = state
    h = seconds / steps
    for n in range(steps):
        here, there = (
            reference + (torque - reference) * (math.exp(-t / axis.lag_s) if axis.lag_s else 0.0)
            for t in (n * h, (n + 1) * h)
        )
        holds = abs(here + load) <= axis.breakaway
        is_pushed_into_stop = (position >= axis.high and here + load > 0) or (position <= axis.low and here + load < 0)
        if speed == 0 and (holds or is_pushed_into_stop):
            continue
        sign = math.copysign(1.0, speed or here + load)
        first = (here + load - axis.coulomb * sign - axis.viscous * speed) / axis.inertia
        guess = speed + h * first
        second = (there + load - axis.coulomb * sign - axis.viscous * guess) / axis.inertia
        new = speed + h * (first + second) / 2
        if new * sign < 0:
            new = 0.0
        position += h * (speed + new) / 2
        speed = new
        if not axis.low < position < axis.high:
            position = min(max(position, axis.low), axis.high)
            speed = 0.0 if (position >= axis.high) is (speed > 0) else speed
    faded = (torque - reference) * math.exp(-seconds / axis.lag_s) if axis.lag_s else 0.0
    return State(position, speed, reference + faded)


@pytest.mark.long
@pytest.mark.parametrize(
    ("axis", "state", "reference", "load"),
    [
        pytest.param(Mechanics(0.01), State(0.0), 0.5, 0.0, id="free"),
        pytest.param(Mechanics(0.01, viscous=0.05), State(0.0, 10.0), 0.5, -0.1, id="viscous"),
        pytest.param(Mechanics(0.01, coulomb=0.2), State(0.0, 6.0), 0.0, 0.0, id="runs down"),
        pytest.param(Mechanics(0.01, 0.02, coulomb=0.2), State(0.0, 6.0), -0.5, 0.0, id="turns round"),
        pytest.param(Mechanics(0.01, 0.02, coulomb=0.2, breakaway=0.3), State(0.0, 6.0), -0.25, 0.0, id="sticks"),
        pytest.param(Mechanics(0.01, 0.02, lag_s=0.02), State(0.0, 6.0), -0.5, 0.0, id="lag"),
        pytest.param(Mechanics(0.01, 0.0, 0.1, lag_s=0.05), State(0.0, 0.0), 0.5, 0.0, id="breaks away"),
        pytest.param(Mechanics(0.01, 0.0, 0.1, lag_s=0.05), State(0.0, 4.0, -0.9), 0.5, 0.0, id="turns twice"),
        pytest.param(Mechanics(0.01, 0.01, 0.1, high=0.4), State(0.0, 4.0), 0.5, 0.0, id="meets a stop"),
        pytest.param(Mechanics(0.01, 0.01, 0.1, high=0.4, lag_s=0.05), State(0.4, 0.0, 0.9), -0.5, 0.0, id="leaves it"),
    ],
)
def test_closed_solution_is_what_fine_steps_come_to(
    axis: Mechanics, state: State, reference: float, load: float
) -> None:
    state = state if axis.lag_s else state._replace(torque=reference)
    for seconds in (0.01, 0.1, 0.4):
        exact = after(axis, state, reference, load, seconds)
        near = stepped(axis, state, reference, load, seconds, 20_000)
        assert exact.position == pytest.approx(near.position, abs=2e-4)
        assert exact.speed == pytest.approx(near.speed, abs=2e-3)
        assert exact.torque == pytest.approx(near.torque)


@pytest.mark.long
@quick
@given(axes(), states, torques, torques)
def test_any_axis_is_what_fine_steps_come_to(axis: Mechanics, state: State, reference: float, load: float) -> None:
    state = state._replace(torque=0.0 if axis.lag_s else reference)
    exact = after(axis, state, reference, load, 0.05)
    near = stepped(axis, state, reference, load, 0.05, 4_000)
    pace = 50 + 6 * 0.05 / axis.inertia
    assert exact.position == pytest.approx(near.position, abs=1e-4 * pace)
    assert exact.speed == pytest.approx(near.speed, abs=1e-2 * pace)


@pytest.mark.long
@quick
@given(axes(), states, torques, torques, st.integers(1, 9))
def test_two_steps_are_one(axis: Mechanics, state: State, reference: float, load: float, tenths: int) -> None:
    part = 0.2 * tenths / 10
    whole = after(axis, state, reference, load, 0.2)
    halves = after(axis, after(axis, state, reference, load, part), reference, load, 0.2 - part)
    scale = 1 + 1.2 / axis.inertia
    assert halves.position == pytest.approx(whole.position, abs=1e-9 * scale)
    assert halves.speed == pytest.approx(whole.speed, abs=1e-9 * scale)
    assert halves.torque == pytest.approx(whole.torque, abs=1e-12)


@quick
@given(axes(), states)
def test_speed_never_grows_without_torque(axis: Mechanics, state: State) -> None:
    segment = [after(axis, state, 0.0, 0.0, n * 0.007) for n in range(30)]
    for before, then in itertools.pairwise(segment):
        assert abs(then.speed) <= abs(before.speed) + 1e-12
        assert then.speed * before.speed >= 0


@pytest.mark.long
@quick
@given(axes(), states, torques, torques)
def test_energy_is_what_the_torques_brought_less_what_friction_took(
    axis: Mechanics, state: State, reference: float, load: float
) -> None:
    """Work done by motor and load, in fine steps, is at least the kinetic energy gained."""
    steps, h = 400, 0.0005
    work, largest = 0.0, 0.0
    here = first = state._replace(torque=0.0 if axis.lag_s else reference)
    for _ in range(steps):
        then = after(axis, here, reference, load, h)
        work += ((here.torque + then.torque) / 2 + load) * (then.position - here.position)
        largest = max(largest, abs(then.speed), abs(here.speed))
        here = then
    gained = axis.inertia * (here.speed**2 - first.speed**2) / 2
    assert gained <= work + steps * h * h * 40 * (1 + largest) + 1e-9


@pytest.mark.long
@quick
@given(axes(), states, torques, torques)
def test_position_has_no_jumps_and_stays_between_the_stops(
    axis: Mechanics, state: State, reference: float, load: float
) -> None:
    fastest = 50 + 6 * 0.1 / axis.inertia
    places = [after(axis, state, reference, load, n * 1e-4).position for n in range(1000)]
    assert all(abs(then - before) <= fastest * 1.01e-4 for before, then in itertools.pairwise(places))
    assert all(axis.low <= place <= axis.high for place in places)


@pytest.mark.long
@quick
@given(axes(), states, torques, torques, st.sampled_from([1e-5, 1e-3, 0.1]))
def test_tangent_is_good_for_as_long_as_it_says(
    axis: Mechanics, state: State, reference: float, load: float, tolerance: float
) -> None:
    segment = Segment(axis, state._replace(torque=0.0 if axis.lag_s else reference), reference, load)
    speed, acceleration, good = segment.tangent(tolerance)
    end = segment.end(min(good, 30.0))
    until = min(good, 30.0) if end is None else end.seconds
    for n in range(1, 101):
        t = until * n / 100
        told = state.position + speed * t + acceleration / 2 * t * t
        assert abs(told - segment.at(t)[0]) <= tolerance * 1.0001 + 1e-9


def test_axis_holds_up_to_the_breakaway_torque_and_then_runs_against_dry_friction() -> None:
    axis = Mechanics(0.01, coulomb=0.2, breakaway=0.3)
    assert after(axis, State(1.0, 0.0, 0.3), 0.3, 0.0, 10.0) == State(1.0, 0.0, 0.3)
    assert after(axis, State(0.0, 0.0, 0.31), 0.31, 0.0, 1.0).speed == pytest.approx(0.11 / 0.01)


def test_axis_that_comes_to_a_standstill_stays_there() -> None:
    axis = Mechanics(0.01, coulomb=0.2)
    rest = after(axis, State(0.0, 6.0), 0.0, 0.0, 5.0)
    assert rest.position == pytest.approx(6.0**2 / (2 * 0.2 / 0.01))
    assert rest.speed == 0.0


def test_axis_leaves_a_stop_only_backwards() -> None:
    axis = Mechanics(0.01, low=-1.0, high=1.0)
    assert after(axis, State(0.0, 5.0, 0.3), 0.3, 0.0, 3.0) == State(1.0, 0.0, 0.3)
    assert after(axis, State(1.0, 0.0, -0.3), -0.3, 0.0, 0.1).position == pytest.approx(1.0 - 30 * 0.01 / 2)


def test_lag_near_the_time_constant_of_the_friction_is_no_special_case() -> None:
    near, at = (after(Mechanics(1.0, 10.0, lag_s=lag), State(0.0), 5.0, 0.0, 0.2) for lag in (0.1001, 0.1))
    assert near.position == pytest.approx(at.position, rel=2e-3)
    exact = 5.0 / 10 * (0.2 - 2 * 0.1 * (1 - math.exp(-2)) + 0.2 * math.exp(-2))  # equal rates, by hand
    assert at.position == pytest.approx(exact, rel=1e-3)


def test_axis_that_drifts_from_its_stop_is_pushed_back_to_it() -> None:
    """The torque is 0 at first and then always backwards: the speed falls from the first instant on."""
    axis = Mechanics(0.2, low=0.0, lag_s=0.003)
    assert after(axis, State(0.0, 2e-9, 0.0), -0.0005, 0.0, 199.0).position == 0.0


def test_lag_that_has_passed_is_over() -> None:
    axis = Mechanics(2e-6, viscous=1000.0, lag_s=0.025)
    assert after(axis, State(0.0, 0.0, -0.0004), 0.0, 0.0, 50.0).speed == 0.0


magnitudes = st.one_of(
    st.just(0.0), st.builds(lambda sign, e: sign * 10.0**e, st.sampled_from([1, -1]), st.floats(-9, 6))
)


@pytest.mark.long
@quick
@given(
    st.builds(
        Mechanics,
        inertia=st.floats(-6, 3).map(lambda e: 10.0**e),
        viscous=magnitudes.map(abs),
        coulomb=magnitudes.map(abs),
        low=st.one_of(st.just(-inf), magnitudes.map(lambda x: -abs(x) - 1)),
        high=st.one_of(st.just(inf), magnitudes.map(abs)),
        lag_s=st.one_of(st.just(0.0), st.floats(-5, 0).map(lambda e: 10.0**e)),
    ),
    magnitudes,
    magnitudes,
    magnitudes,
    magnitudes,
    st.floats(-9, 5).map(lambda e: 10.0**e),
)
def test_axis_of_any_size_comes_to_an_end(
    axis: Mechanics, speed: float, torque: float, reference: float, load: float, seconds: float
) -> None:
    then = after(axis, State(0.0, speed, torque if axis.lag_s else reference), reference, load, seconds)
    assert all(map(math.isfinite, then))
    assert axis.low - 1e-9 <= then.position <= axis.high + 1e-9
