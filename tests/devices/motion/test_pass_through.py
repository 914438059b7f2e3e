"""A motion over a distance without a stop has the length and the end speed of constant acceleration."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.motion.profile import Limits, pass_through

LIMITS = Limits(1000.0, 5000.0, 2500.0)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_long_way_ends_at_full_speed(sign: int) -> None:
    profile = pass_through(sign * 600.0, 0.0, LIMITS)
    # 0.2 s of acceleration over 100, then 500 at 1000
    assert profile.duration_s == pytest.approx(0.7)
    assert profile.at(0.7) == pytest.approx((sign * 600.0, sign * 1000.0, 0.0))


def test_a_short_way_ends_while_it_accelerates() -> None:
    profile = pass_through(10.0, 0.0, LIMITS)
    assert profile.duration_s == pytest.approx(math.sqrt(2 * 10 / 5000))
    assert profile.at(1.0).speed == pytest.approx(math.sqrt(2 * 10 * 5000))


def test_what_is_too_fast_is_slowed_down() -> None:
    profile = pass_through(1000.0, 2000.0, LIMITS)
    # from 2000 to 1000 with 2500: 0.4 s over 600, then 400 at 1000
    assert [profile.duration_s, profile.at(0.8).speed] == pytest.approx([0.8, 1000.0])


@pytest.mark.long
@settings(deadline=None, max_examples=200)
@given(st.floats(0.01, 1e6), st.floats(0.0, 3000.0), st.booleans())
def test_it_is_at_the_end_when_it_ends(way: float, speed: float, is_back: bool) -> None:
    sign = -1 if is_back else 1
    profile = pass_through(sign * way, sign * speed, LIMITS)
    assert profile.distance == pytest.approx(sign * way, rel=1e-6, abs=1e-6)
    assert profile.at(profile.duration_s).speed * sign >= 0
