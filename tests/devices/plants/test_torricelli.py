"""The level of a tank against the closed solutions, and against an integration in small steps."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.plants.torricelli import GRAVITY, moved, root_after, root_coefficient, seconds_to

AREA_M2 = 0.25
TALL_M = 1e9  # a tank that never runs over
K = root_coefficient(0.62 * 2e-4)

LEVELS = st.floats(0, 100)
FLOWS = st.just(0.0) | st.floats(1e-9, 1.0)
COEFFICIENTS = st.just(0.0) | st.floats(1e-9, 1.0)
AREAS = st.floats(1e-2, 100)
TIMES = st.floats(1e-4, 1e5)


def level_after(level_m: float, inflow: float, k: float, seconds: float) -> float:
    return moved(level_m, inflow, k, AREA_M2, TALL_M, seconds).level_m


def integrated(level_m: float, inflow: float, k: float, seconds: float, steps: int) -> float:
    """Runge-Kutta of fourth order on the level, which knows nothing of the solution."""
    step = seconds / steps

    def rate(level: float) -> float:
        return (inflow - k * math.sqrt(max(level, 0.0))) / AREA_M2

    for _ in range(steps):
        k1 = rate(level_m)
        k2 = rate(level_m + step / 2 * k1)
        k3 = rate(level_m + step / 2 * k2)
        k4 = rate(level_m + step * k3)
        level_m += step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return level_m


def test_outflow_is_torricellis() -> None:
    assert K * math.sqrt(2.0) == pytest.approx(0.62 * 2e-4 * math.sqrt(2 * 9.80665 * 2.0), rel=1e-12)


@pytest.mark.parametrize("seconds", [0.01, 1.0, 100.0, 500.0])
def test_draining_tanks_root_falls_linearly(seconds: float) -> None:
    root = math.sqrt(2.0) - K * seconds / (2 * AREA_M2)
    assert level_after(2.0, 0.0, K, seconds) == pytest.approx(root * root, rel=1e-9)


def test_tank_is_empty_after_torricellis_time() -> None:
    empty_after = AREA_M2 / (0.62 * 2e-4) * math.sqrt(2 * 2.0 / GRAVITY)  # the textbook's
    assert level_after(2.0, 0.0, K, empty_after * 1.000001) == 0.0
    assert 0.0 < level_after(2.0, 0.0, K, empty_after * 0.999) < 1e-5


def test_filling_tank_rises_linearly() -> None:
    assert level_after(0.5, 0.001, 0.0, 100.0) == pytest.approx(0.5 + 0.001 * 100 / 0.25, rel=1e-12)


@pytest.mark.parametrize("level_m", [0.0, 1e-6, 0.1, 1.0, 3.0])
@pytest.mark.parametrize("opening", [0.01, 0.5, 1.0])
@pytest.mark.parametrize("seconds", [0.01, 1.0, 60.0])
def test_filling_and_draining_agree_with_an_integration(level_m: float, opening: float, seconds: float) -> None:
    begun_m = level_after(level_m, 0.001, opening * K, 1.0)  # a step on from empty, where Runge-Kutta is inexact
    expected = integrated(begun_m, 0.001, opening * K, seconds, 2_000)
    assert level_after(begun_m, 0.001, opening * K, seconds) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("level_m", [0.0, 0.2, 5.0])
def test_level_comes_to_rest_where_the_flows_are_equal(level_m: float) -> None:
    inflow = 0.0005
    rest_m = (inflow / (0.62 * 2e-4)) ** 2 / (2 * GRAVITY)
    assert level_after(level_m, inflow, K, 1e7) == pytest.approx(rest_m, rel=1e-12)
    assert level_after(rest_m, inflow, K, 60.0) == pytest.approx(rest_m, rel=1e-12)


def test_overflow_is_what_can_not_stay() -> None:
    after = moved(1.9, 0.001, 0.0, AREA_M2, 2.0, 100.0)
    assert after.level_m == 2.0
    assert after.over_m3 == pytest.approx(0.1 - 0.1 * AREA_M2, rel=1e-9)
    assert after.out_m3 == pytest.approx(0.0, abs=1e-12)


def test_overflow_while_draining_is_the_difference_of_the_flows() -> None:
    inflow = 2 * K * math.sqrt(2.0)
    after = moved(2.0, inflow, K, AREA_M2, 2.0, 10.0)
    assert after.level_m == 2.0
    assert after.over_m3 == pytest.approx(10.0 * inflow / 2, rel=1e-9)


@given(LEVELS, FLOWS, COEFFICIENTS, AREAS, st.floats(0.1, 100), TIMES)
def test_no_water_is_made_or_lost(
    level_m: float, inflow: float, k: float, area_m2: float, height_m: float, seconds: float
) -> None:
    level_m = min(level_m, height_m)
    after = moved(level_m, inflow, k, area_m2, height_m, seconds)
    assert 0 <= after.level_m <= height_m
    assert after.out_m3 >= 0
    assert after.over_m3 >= 0
    there = area_m2 * level_m + inflow * seconds
    assert area_m2 * after.level_m + after.out_m3 + after.over_m3 == pytest.approx(there, rel=1e-9, abs=1e-12)


@given(LEVELS, FLOWS, COEFFICIENTS, AREAS, TIMES, st.floats(0.01, 0.99))
def test_two_steps_are_as_one(
    level_m: float, inflow: float, k: float, area_m2: float, seconds: float, share: float
) -> None:
    whole = moved(level_m, inflow, k, area_m2, TALL_M, seconds).level_m
    half = moved(level_m, inflow, k, area_m2, TALL_M, seconds * share).level_m
    assert moved(half, inflow, k, area_m2, TALL_M, seconds * (1 - share)).level_m == pytest.approx(
        whole, rel=1e-6, abs=1e-12
    )


@given(LEVELS, st.floats(1e-9, 1.0), st.floats(1e-9, 1.0), AREAS, TIMES)
def test_level_moves_towards_its_rest_and_never_beyond(
    level_m: float, inflow: float, k: float, area_m2: float, seconds: float
) -> None:
    rest = inflow / k
    root = math.sqrt(level_m)
    after = root_after(root, inflow, k, area_m2, seconds)
    low, high = sorted((root, rest))
    assert low * (1 - 1e-12) <= after <= high * (1 + 1e-12)


@given(LEVELS, st.floats(1e-6, 1.0), COEFFICIENTS, AREAS, st.floats(0.01, 0.99))
def test_time_to_a_level_is_the_inverse_of_the_course(
    level_m: float, inflow: float, k: float, area_m2: float, share: float
) -> None:
    root = math.sqrt(level_m)
    top = root + 3 if k == 0 else inflow / k
    if top <= root * 1.001:
        return
    target = root + share * (top - root)
    seconds = seconds_to(target, root, inflow, k, area_m2)
    assert moved(level_m, inflow, k, area_m2, 1e30, seconds).level_m == pytest.approx(target * target, rel=1e-6)
