"""Profiles with a limited jerk: durations by hand, and limits that hold from any state on."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.motion import profile as trapezoid
from fieldrig_devices.motion.jerk import JerkProfile, change_speed, move, pass_through
from fieldrig_devices.motion.profile import Limits

LIMITS = Limits(100.0, 1_000.0, 500.0, 10_000.0)
"""Full acceleration after 0.1 s, full deceleration after 0.05 s."""
SOME = st.floats(1.0, 1e4)
A_LIMIT = st.builds(Limits, SOME, SOME, SOME, st.floats(1.0, 1e6))


def test_a_change_of_speed_takes_the_time_of_both_roundings_longer() -> None:
    """The time from 0 to 200 is 200 / 1000 + 1000 / 10000 = 0.3 s, at the mean speed of 100."""
    profile = change_speed(0.0, 200.0, LIMITS)
    assert profile.duration_s == pytest.approx(0.3)
    assert profile.distance == pytest.approx(30.0)
    assert profile.at(0.1) == pytest.approx((10_000 * 0.1**3 / 6, 50.0, 1_000.0))
    assert profile.at(0.2).speed == pytest.approx(150.0)


def test_a_small_change_never_reaches_the_acceleration() -> None:
    """The way from 0 to 25 is two triangles of sqrt(25 / 10000) = 0.05 s, with a peak of 500."""
    profile = change_speed(0.0, 25.0, LIMITS)
    assert profile.duration_s == pytest.approx(0.1)
    assert profile.at(0.05) == pytest.approx((10_000 * 0.05**3 / 6, 12.5, 500.0))


def test_a_long_move_has_two_ramps_and_full_speed_between_them() -> None:
    """Up 100 / 1000 + 0.1 = 0.2 s over 10, down 100 / 500 + 0.05 = 0.25 s over 12.5, and 77.5 at 100."""
    profile = move(100.0, 0.0, LIMITS)
    assert profile.duration_s == pytest.approx(0.2 + 0.775 + 0.25)
    assert profile.at(profile.duration_s) == pytest.approx((100.0, 0.0, 0.0))


def test_the_same_command_again_changes_nothing() -> None:
    """An acceleration that goes the right way goes on, wherever in its rise, its hold or its fall."""
    whole = change_speed(0.0, 200.0, LIMITS)
    for moment in (0.05, 0.1, 0.17):
        state = whole.at(moment)
        rest = change_speed(state.speed, 200.0, LIMITS, state.acceleration)
        assert rest.duration_s == pytest.approx(0.3 - moment)
        assert state.position + rest.distance == pytest.approx(30.0)


def test_a_set_point_that_is_passed_through_early_keeps_its_acceleration() -> None:
    profile = pass_through(10_000 * 0.1**3 / 6, 0.0, LIMITS)
    assert profile.at(profile.duration_s) == pytest.approx((10_000 * 0.1**3 / 6, 50.0, 1_000.0))


@pytest.mark.parametrize("part", [0.01, 0.1, 0.3, 0.5, 0.7, 0.8244477569146318, 0.9, 0.99])
def test_the_same_target_again_takes_the_time_that_is_left(part: float) -> None:
    """At the last of these a rest of rounding was crawled for 0.6 s."""
    limits = Limits(440074.7415526012, 411678682.09496826, 527390445.9783695, 1323025.9923400106)
    whole = move(669318.8653579677, 0.0, limits)
    state = whole.at(whole.duration_s * part)
    again = move(whole.distance - state.position, state.speed, limits, state.acceleration)
    assert again.duration_s == pytest.approx(whole.duration_s * (1 - part), abs=1e-3)


def within(profile: JerkProfile, limits: Limits, speed: float) -> bool:
    """True if no instant exceeds the limits, nor the jerk from one to the next; `speed` is the one at the start."""
    most, rates = max(limits.speed, abs(speed)) * (1 + 1e-6), max(limits.acceleration, limits.deceleration) * (1 + 1e-6)
    before = profile.values_at(0.0)
    ends = [piece.seconds for piece in profile.pieces]
    moments = sorted(
        {sum(ends[:place]) + seconds * part / 4 for place, seconds in enumerate(ends) for part in range(4)}
    )
    last = 0.0
    for moment in [*moments, profile.duration_s]:
        now = profile.values_at(moment)
        if abs(now[1]) > most + 1e-9 or abs(now[2]) > rates + 1e-9:
            return False
        if abs(now[2] - before[2]) > limits.jerk * (moment - last) * (1 + 1e-3) + 1e-6 * rates:
            return False
        before, last = now, moment
    return True


@pytest.mark.long
@settings(deadline=None, max_examples=60)
@given(A_LIMIT, st.floats(-1e5, 1e5), st.floats(-1e5, 1e5), st.floats(0.0, 1.0))
def test_moves_keep_the_limits_and_end_where_a_trapezoid_ends(
    limits: Limits, first: float, distance: float, part: float
) -> None:
    """The second move begins somewhere within the first one."""
    way = move(first, 0.0, limits)
    assert within(way, limits, 0.0)
    state = way.at(way.duration_s * part)
    then = move(distance, state.speed, limits, state.acceleration)
    relaxed = abs(state.speed) + state.acceleration**2 / (2 * limits.jerk)
    assert within(then, limits, relaxed)
    assert then.distance == trapezoid.move(0.0, 0.0, limits).distance + distance
    last = then.pieces[-1] if then.pieces else None
    if last is not None:
        scale = max(abs(distance), abs(first), abs(state.speed) * then.duration_s, 1.0)
        position, speed, acceleration = last.at(last.seconds)
        assert math.isclose(position, distance, rel_tol=0, abs_tol=1e-6 * scale)
        assert abs(speed) <= 1e-6 * limits.speed
        assert abs(acceleration) <= 1e-6 * max(limits.acceleration, limits.deceleration)


@pytest.mark.long
@settings(deadline=None, max_examples=60)
@given(A_LIMIT, st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(0.0, 1.0))
def test_changes_of_speed_keep_the_limits(limits: Limits, first: float, second: float, part: float) -> None:
    way = change_speed(0.0, first * limits.speed, limits)
    state = way.at(way.duration_s * part)
    then = change_speed(state.speed, second * limits.speed, limits, state.acceleration)
    assert within(then, limits, abs(state.speed) + state.acceleration**2 / (2 * limits.jerk))
    assert then.end_speed == second * limits.speed
    assert then.at(then.duration_s).speed == pytest.approx(second * limits.speed, abs=1e-6)
