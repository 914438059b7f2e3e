"""The motion laws of VDI 2143 sheet 1 against their closed forms, and what lambda makes of them."""

from collections.abc import Callable
from math import cos, pi, sin, sqrt, tau

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.motion.curves.laws import LAWS
from fieldrig_devices.motion.curves.laws.polynomial_5 import between
from fieldrig_devices.motion.curves.profile import Profile, shaped

F = Callable[[float], float]


def modified_sine(z: float) -> float:
    """The three ranges as the digest gives them (section 3)."""
    if z <= 1 / 8:
        return (pi * z - sin(4 * pi * z) / 4) / (4 + pi)
    if z <= 7 / 8:
        return (2 + pi * z - 9 / 4 * sin(pi / 3 + 4 * pi * z / 3)) / (4 + pi)
    return (4 + pi * z - sin(4 * pi * z) / 4) / (4 + pi)


def modified_trapezoid(z: float) -> float:
    """The closed form with the constants of Norton, "Cam Design and Manufacturing Handbook"."""
    if z > 1 / 2:
        return 1 - modified_trapezoid(1 - z)
    if z <= 1 / 8:
        return 0.38898448 * z - 0.0309544 * sin(4 * pi * z)
    if z <= 3 / 8:
        return 2.44406184 * z * z - 0.22203097 * z + 0.00723407
    return 1.6110154 * z - 0.0309544 * sin(4 * pi * z - pi) - 0.3055077


CLOSED: dict[str, tuple[F, float, float]] = {
    "straight": (lambda z: z, 1.0, 0.0),
    "quadpara": (lambda z: 2 * z * z if z <= 1 / 2 else 1 - 2 * (1 - z) ** 2, 2.0, 4.0),
    "simpsin": (lambda z: (1 - cos(pi * z)) / 2, pi / 2, pi * pi / 2),
    "inclsin": (lambda z: z - sin(tau * z) / tau, 2.0, tau),
    "modisin": (modified_sine, 1.7596, 5.528),
    "moditrap": (modified_trapezoid, 2.0, 4.888),
    "poly5": (lambda z: 10 * z**3 - 15 * z**4 + 6 * z**5, 1.875, 5.774),
}
"""Each law with its Cv and Ca as they are printed."""

shares = st.floats(0, 1)


@pytest.mark.manual("PD-183", "PD-184")
@pytest.mark.parametrize("name", CLOSED)
def test_every_law_is_its_closed_form(name: str) -> None:
    law, (closed, cv, _) = shaped(LAWS[name]), CLOSED[name]
    for step in range(1001):
        z = step / 1000
        assert law.at(z) == pytest.approx(closed(z), abs=2e-7 if name == "moditrap" else 1e-12)
        if 0 < z < 1:
            assert law.slope(z) == pytest.approx((closed(z + 1e-4) - closed(z - 1e-4)) / 2e-4, abs=1e-3)
    assert max(law.slope(step / 1000) for step in range(1001)) == pytest.approx(cv, abs=1e-4)
    assert LAWS[name].cv == pytest.approx(cv, abs=1e-4)


@pytest.mark.manual("PD-183")
@pytest.mark.parametrize("name", [name for name in CLOSED if name != "straight"])
def test_the_largest_acceleration_is_that_of_the_table(name: str) -> None:
    law, ca = shaped(LAWS[name]), CLOSED[name][2]
    measured = max(abs(law.slope(z + 1e-6) - law.slope(z)) / 1e-6 for z in (step / 5000 for step in range(4999)))
    assert measured == pytest.approx(ca, abs=2e-3)
    assert LAWS[name].ca == pytest.approx(ca, abs=1e-3)


@given(shares, shares)
def test_every_lambda_keeps_ends_order_and_largest_slope(turning_point: float, z: float) -> None:
    for name, law in LAWS.items():
        profile = shaped(law, turning_point)
        assert profile.at(0.0) == pytest.approx(0.0, abs=1e-12)
        assert profile.at(1.0) == pytest.approx(1.0, abs=1e-12)
        assert profile.slope(turning_point) == pytest.approx(law.cv), name
        assert -1e-12 <= profile.slope(z) <= law.cv + 1e-9


@pytest.mark.manual("PD-188")
def test_lambda_1_leads_from_dwell_to_velocity_and_0_back() -> None:
    law = LAWS["modisin"]
    start, stop = shaped(law, 1.0), shaped(law, 0.0)
    assert (start.slope(0.0), start.slope(1.0)) == pytest.approx((0.0, 4 * pi / (4 + pi)))
    assert (stop.slope(0.0), stop.slope(1.0)) == pytest.approx((4 * pi / (4 + pi), 0.0))
    for step in range(101):
        z = step / 100
        assert start.at(z) == pytest.approx(2 * modified_sine(z / 2))  # the first half, stretched
        assert stop.at(z) == pytest.approx(2 * modified_sine((1 + z) / 2) - 1)


@pytest.mark.manual("PD-188")
def test_the_straight_is_the_same_for_every_lambda() -> None:
    for turning_point in (0.0, 0.3, 1.0):
        assert [shaped(LAWS["straight"], turning_point).at(z) for z in (0.0, 0.25, 1.0)] == [0.0, 0.25, 1.0]


@given(st.floats(0, 1), st.floats(-0.5, 1.5))
def test_behind_its_ends_a_profile_goes_on_along_its_tangent(turning_point: float, z: float) -> None:
    profile = shaped(LAWS["modisin"], turning_point)
    if z < 0:
        assert profile.at(z) == pytest.approx(profile.slope(0.0) * z, abs=1e-12)
    elif z > 1:
        assert profile.at(z) == pytest.approx(1 + profile.slope(1.0) * (z - 1), abs=1e-12)


@given(*[st.floats(-5, 5)] * 4)
def test_the_polynomial_between_two_velocities_meets_its_bounds(v0: float, v1: float, a0: float, a1: float) -> None:
    profile = Profile([between(v0, v1, a0, a1)])
    assert (profile.at(0.0), profile.at(1.0)) == pytest.approx((0.0, 1.0), abs=1e-9)
    assert (profile.slope(0.0), profile.slope(1.0)) == pytest.approx((v0, v1), abs=1e-9)
    bend = [(profile.slope(z + 1e-6) - profile.slope(z)) / 1e-6 for z in (0.0, 1 - 1e-6)]
    assert bend == pytest.approx([a0, a1], abs=1e-2)


def test_between_rest_and_rest_it_is_the_law() -> None:
    assert between(0.0, 0.0).powers == (0.0, 0.0, 0.0, 10.0, -15.0, 6.0)
    assert LAWS["poly5"].ca == pytest.approx(10 / sqrt(3))


@given(st.floats(0.01, 100), st.floats(-100, 100), shares)
def test_a_piece_is_scaled_and_reflected_in_closed_form(x: float, y: float, share: float) -> None:
    for law in LAWS.values():
        for piece in law.half:
            t = share * piece.length
            assert piece.scaled(x, y).at(t * x) == pytest.approx(y * piece.at(t), abs=1e-9)
            assert piece.reflected().at(t) == pytest.approx(-piece.at(piece.length - t), abs=1e-9)
