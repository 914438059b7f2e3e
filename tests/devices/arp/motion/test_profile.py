"""The closed solutions of manual 5.9.3: times, peaks and every sample of a move."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.motion.profile import Limits, Profile, brake, change_speed, keep, move

LIMITS = Limits(1000.0, 5000.0, 2500.0)


def thousandths(low: float, high: float) -> st.SearchStrategy[float]:
    """Limits as parameters and programs give them."""
    return st.integers(round(low * 1000), round(high * 1000)).map(lambda raw: raw / 1000)


DISTANCES = thousandths(-1e6, 1e6)
SPEEDS = thousandths(-2e3, 2e3)
ANY_LIMITS = st.builds(Limits, thousandths(0.001, 1e4), thousandths(0.01, 1e6), thousandths(0.01, 1e6))


def closed_trapezoid(t: float, v: float, a: float, d: float, distance: float) -> float:
    """Digest chapter 12, a second implementation: from rest, with a section at full speed."""
    total = v / a + v / d + (distance - v * v / 2 / a - v * v / 2 / d) / v
    if t < v / a:
        return a * t * t / 2
    if t < total - v / d:
        return v * v / 2 / a + v * (t - v / a)
    return distance - d * (total - t) ** 2 / 2


def closed_triangle(t: float, a: float, d: float, distance: float) -> float:
    peak = math.sqrt(2 * a * d * distance / (a + d))
    total = peak / a + peak / d
    return a * t * t / 2 if t < peak / a else distance - d * (total - t) ** 2 / 2


def samples(profile: Profile, count: int = 400) -> list[float]:
    return [profile.duration_s * number / count for number in range(count)]


@pytest.mark.manual("ARP-095")
@pytest.mark.parametrize("sign", [1, -1])
def test_trapezoid_of_the_manual_takes_10_3_s(sign: int) -> None:
    trajectory = move(sign * 10_000.0, 0.0, LIMITS)
    assert trajectory.duration_s == pytest.approx(10.3, abs=1e-12)
    for t in samples(trajectory):
        assert trajectory.at(t).position == pytest.approx(sign * closed_trapezoid(t, *LIMITS[:3], 10_000.0), abs=1e-8)


@pytest.mark.manual("ARP-095")
def test_short_way_is_a_triangle_with_its_peak() -> None:
    trajectory = move(120.0, 0.0, LIMITS)
    assert trajectory.duration_s == pytest.approx(0.3795, abs=5e-5)
    peak_s = math.sqrt(2 * 5000 * 2500 * 120 / 7500) / 5000
    assert trajectory.at(peak_s).speed == pytest.approx(632.456, abs=5e-4)
    for t in samples(trajectory):
        assert trajectory.at(t).position == pytest.approx(closed_triangle(t, 5000, 2500, 120), abs=1e-9)


def test_way_that_is_too_short_to_stop_in_overshoots_and_returns() -> None:
    trajectory = move(100.0, 1000.0, LIMITS)  # stopping takes 200
    assert trajectory.at(0.4).position == pytest.approx(200.0)
    assert trajectory.at(0.4).speed == pytest.approx(0.0, abs=1e-9)
    peak = math.sqrt(2 * 5000 * 2500 * 100 / 7500)
    assert trajectory.duration_s == pytest.approx(0.4 + peak / 5000 + peak / 2500)
    assert trajectory.at(trajectory.duration_s).position == pytest.approx(100.0)


def test_moving_away_from_the_target_stops_first() -> None:
    trajectory = move(100.0, -1000.0, LIMITS)
    assert trajectory.at(0.4).position == pytest.approx(-200.0)
    assert trajectory.at(trajectory.duration_s).position == pytest.approx(100.0)


def test_speed_above_the_limit_is_brought_down_to_it() -> None:
    trajectory = move(10_000.0, 1500.0, LIMITS)
    assert trajectory.at(0.1).speed == pytest.approx(1250.0)
    assert trajectory.at(0.3).speed == pytest.approx(1000.0)
    assert trajectory.distance == pytest.approx(10_000.0)


def test_change_of_speed_brakes_through_rest() -> None:
    trajectory = change_speed(-500.0, 1000.0, LIMITS)
    assert trajectory.duration_s == pytest.approx(500 / 2500 + 1000 / 5000)
    assert trajectory.at(0.1).acceleration == 2500.0
    assert trajectory.at(0.3).acceleration == 5000.0
    assert trajectory.at(9.0).speed == 1000.0


def test_brake_from_rest_is_over_at_once() -> None:
    assert brake(0.0, LIMITS).duration_s == 0
    assert keep(7.0).at(2.0).position == 14.0


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(DISTANCES, SPEEDS, ANY_LIMITS)
def test_every_move_ends_at_its_target_at_rest(distance: float, speed: float, limits: Limits) -> None:
    trajectory = move(distance, speed, limits)
    scale = abs(distance) + speed * speed / limits.deceleration + 1
    assert trajectory.distance == pytest.approx(distance, abs=1e-9 * scale)
    last = trajectory.at(trajectory.duration_s + 1)
    assert last.speed == 0
    assert last.position == trajectory.distance


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(DISTANCES, SPEEDS, ANY_LIMITS)
def test_no_move_exceeds_its_limits(distance: float, speed: float, limits: Limits) -> None:
    trajectory = move(distance, speed, limits)
    top = max(limits.speed, abs(speed)) * (1 + 1e-9)
    for t in samples(trajectory, 60):
        state = trajectory.at(t)
        assert abs(state.speed) <= top
        is_braking = state.speed * state.acceleration < 0 and abs(state.speed) > 1e-6
        allowed = limits.deceleration if is_braking else max(limits.acceleration, limits.deceleration)
        assert abs(state.acceleration) <= allowed


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(DISTANCES, SPEEDS, ANY_LIMITS)
def test_speed_and_position_have_no_steps(distance: float, speed: float, limits: Limits) -> None:
    trajectory = move(distance, speed, limits)
    assert trajectory.at(0.0).speed == pytest.approx(speed)
    grain = trajectory.duration_s / 1e4
    for t in samples(trajectory, 50):
        here, there = trajectory.at(t), trajectory.at(t + grain)
        steepest = max(limits.acceleration, limits.deceleration)
        assert abs(there.speed - here.speed) <= steepest * grain * (1 + 1e-6) + 1e-6
        fastest = max(limits.speed, abs(speed))
        assert abs(there.position - here.position) <= fastest * grain * (1 + 1e-6) + 1e-6
