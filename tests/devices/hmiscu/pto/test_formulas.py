"""The mathematics of profiles against the worked tables of the digest (sections 9 and 15)."""

from decimal import ROUND_CEILING, ROUND_HALF_UP, Decimal, localcontext
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.hmiscu.enumerations import Direction
from fieldrig_devices.hmiscu.pto.command import Order
from fieldrig_devices.hmiscu.pto.exact import ATTOSECONDS
from fieldrig_devices.hmiscu.pto.matrix import Next
from fieldrig_devices.hmiscu.pto.periods import Staircase, approach, move
from fieldrig_devices.hmiscu.pto.piece import Piece
from fieldrig_devices.hmiscu.pto.planner import Ends, Planner
from fieldrig_devices.hmiscu.pto.ramp import Ramp, peak_square
from fieldrig_devices.hmiscu.pto.rates import RampUnit, end_frequency, rate
from fieldrig_devices.hmiscu.pto.settings import PtoSettings

# Unit, pin, from, to, rate in Hz/s (digest 9.1).
RATES: list[tuple[RampUnit, int, int, int, float]] = [
    ("ms", 10_000, 5_000, 20_000, 1_500),  # manual 507 to 516
    ("ms", 20_000, 0, 1_000, 1_000),  # 50, raised
    ("ms", 49_999, 0, 50_000, 1_000.02),
    ("ms", 49_999, 1_000, 50_000, 1_000),  # 980.02, raised
    ("ms", 500, 1_000, 10_000, 18_000),
    ("ms", 20_000, 10_000, 50_000, 2_000),
    ("ms", 20_000, 50_000, 10_000, 2_000),
    ("Hz/ms", 1, 0, 50_000, 1_000),
    ("Hz/ms", 2_500, 5_000, 6_000, 2_500_000),
]


@pytest.mark.manual("SCU-027", "SCU-085", "SCU-086", "SCU-089", "SCU-091")
@pytest.mark.parametrize(("unit", "pin", "from_hz", "to_hz", "expected"), RATES)
def test_a_rate_follows_from_the_pin_and_both_frequencies(
    unit: RampUnit, pin: int, from_hz: int, to_hz: int, expected: float
) -> None:
    assert float(rate(unit, pin, from_hz, to_hz)) == pytest.approx(expected, rel=1e-8)


@pytest.mark.manual("SCU-020", "SCU-021")
@pytest.mark.parametrize(
    ("hz_per_s", "expected"), [(2_500_000, 1118), (20_000, 100), (5_000, 50), (1_000, 22), (50_000_000, 5_000)]
)
def test_a_zero_start_frequency_is_calculated_to_the_nearest_hertz(hz_per_s: int, expected: int) -> None:
    assert end_frequency(0, Fraction(hz_per_s)) == expected
    assert end_frequency(700, Fraction(hz_per_s)) == 700


# fs, fe, ft, a, d, the minimum of pulses, then a distance below it with t1, t2 and fm (digest 9.3 and 9.5).
PROFILES = [
    ((0, 0, 20_000, 20_000, 40_000), 15_000, (5_000, 0.577350, 0.288675, 11547.005)),
    ((5_000, 5_000, 20_000, 1_500, 1_500), 250_000, (100_000, 5.485838, 5.485838, 13228.757)),
    ((1_000, 500, 30_000, 14_500, 29_500), 46_250, (20_000, 1.292324, 0.652159, 19738.705)),
]


@pytest.mark.manual("SCU-042")
@pytest.mark.parametrize(("profile", "least", "_short"), PROFILES)
def test_the_minimum_of_pulses_is_the_area_under_both_ramps(profile: tuple[int, ...], least: int, _short: Any) -> None:
    start, stop, top, up, down = map(Fraction, profile)
    assert Ramp(start, top * top, up).pulses + Ramp(stop, top * top, down).pulses == least


@pytest.mark.manual("SCU-044")
@pytest.mark.parametrize(("profile", "_least", "short"), PROFILES)
def test_a_short_move_has_shorter_ramps_and_a_lower_maximum(
    profile: tuple[int, ...], _least: int, short: tuple[int, float, float, float]
) -> None:
    start, stop, _, up, down = map(Fraction, profile)
    distance, first_s, second_s, peak_hz = short
    square = peak_square(start, stop, up, down, distance)
    climb, fall = Ramp(start, square, up), Ramp(stop, square, down)
    assert float(climb.high) == pytest.approx(peak_hz, abs=5e-4)
    assert float(climb.seconds) == pytest.approx(first_s, abs=5e-7)
    assert float(fall.seconds) == pytest.approx(second_s, abs=5e-7)
    assert climb.pulses + fall.pulses == distance


# Rate, frequencies of the first periods (digest 9.8).
PERIODS = [
    (Staircase(0, Fraction(20_000)), [100, 242, 315, 374, 424, 469]),
    (Staircase(0, Fraction(2_500_000)), [1118, 2700, 3518, 4173, 4737, 5239]),
    (Staircase(0, Fraction(2_500_000), is_end=False), [1119, 2700, 3518, 4173, 4737, 5239]),
    (Staircase(0, Fraction(40_000), is_end=False), [142, 342, 445, 528, 600]),
    (Staircase(0, Fraction(1_000_000), is_end=False), [708, 1708, 2225, 2639, 2996]),
    (Staircase(5_000, Fraction(1_500_000)), [5000, 5430, 5700, 5957]),
    (Staircase(5_000, Fraction(1_500_000), is_end=False), [5146, 5430, 5700, 5957]),
]


@pytest.mark.manual("SCU-084")
@pytest.mark.parametrize(("stairs", "expected"), PERIODS)
def test_the_frequency_of_a_period_is_rounded_up(stairs: Staircase, expected: list[int]) -> None:
    assert [stairs.frequency(number) for number in range(len(expected))] == expected


@pytest.mark.manual("SCU-084")
@pytest.mark.parametrize(("hz_per_s", "expected_s"), [(20_000, 0.316143), (2_500_000, 0.028284)])
def test_a_thousand_periods_take_the_time_of_the_table(hz_per_s: int, expected_s: float) -> None:
    runs = Staircase(0, Fraction(hz_per_s)).rising(1000)
    assert sum(count / frequency for frequency, count in runs) == pytest.approx(expected_s, abs=1e-6)


# fs, fe, ft, a, d, pulses, time of the smooth form and of the form with all periods rounded up (digest 14.2).
MOVES = [
    ((0, 0, 20_000, 20_000, 40_000), 40_000, 2.75, 2.749808),
    ((0, 0, 20_000, 20_000, 40_000), 15_000, 1.5, 1.499808),
    ((0, 0, 20_000, 20_000, 40_000), 5_000, 0.866025, 0.865854),
    ((1_000, 500, 30_000, 14_500, 29_500), 20_000, 1.944484, 1.944319),
    ((5_000, 5_000, 20_000, 1_500, 1_500), 300_000, 22.5, 22.499079),
]


def taken_s(pieces: list[Piece]) -> float:
    return sum(piece.duration_as for piece in pieces) / ATTOSECONDS


def pulses(pieces: list[Piece]) -> int:
    return sum(piece.count or 0 for piece in pieces)


@pytest.mark.long
@pytest.mark.manual("SCU-084")
@pytest.mark.parametrize(("profile", "distance", "_smooth_s", "rounded_s"), MOVES)
def test_a_move_of_rounded_periods_takes_the_time_of_the_table(
    profile: tuple[int, ...], distance: int, _smooth_s: float, rounded_s: float
) -> None:
    start, stop, top, up, down = profile
    stairs = Staircase(start, Fraction(up), is_end=False), Staircase(stop, Fraction(down), is_end=False)
    pieces = list(move(*stairs, top, distance))
    assert pulses(pieces) == distance
    assert taken_s(pieces) == pytest.approx(rounded_s, abs=1e-6)


@pytest.mark.manual("SCU-042", "SCU-043", "SCU-044")
@pytest.mark.parametrize(("profile", "distance", "smooth_s", "_rounded_s"), MOVES)
def test_a_smooth_move_takes_exactly_the_time_of_the_formulas(
    profile: tuple[int, ...], distance: int, smooth_s: float, _rounded_s: float
) -> None:
    start, stop, top, up, down = profile
    ms = (top - start) * 1000 // up, (top - stop) * 1000 // down
    planner = Planner(PtoSettings.model_validate({"mode": "pto", "ramps": "smooth"}))
    order = Order(Next.MOVE_RELATIVE, top, distance, *ms, Direction.PTO_POSITIVE)
    plan = planner.move_relative(order, Ends(start, stop))
    assert plan is not None
    pieces = list(plan)
    assert len(pieces) <= 5
    assert pulses(pieces) == distance
    assert taken_s(pieces) == pytest.approx(smooth_s, abs=5e-7)


def test_a_tiny_move_has_the_periods_of_the_table() -> None:
    stairs = Staircase(0, Fraction(1_000_000))
    runs = [(piece.frequency, piece.count) for piece in move(stairs, stairs, 5_000, 6)]
    assert runs == [(frequency, 1) for frequency in (707, 1708, 2225, 2225, 1708, 707)]  # 9.8: 707 is the nearest


@pytest.mark.manual("SCU-045")
def test_a_profile_needs_a_maximum_above_both_ends() -> None:
    start, stop, rate_ = Fraction(5_000), Fraction(1_000), Fraction(1_000_000)
    assert float(Ramp(start, peak_square(start, stop, rate_, rate_, 12), rate_).high) == 5_000
    assert float(Ramp(start, peak_square(start, stop, rate_, rate_, 13), rate_).high) == pytest.approx(
        5099.02, abs=5e-3
    )


def printed(low: int, rate_: Fraction, number: int) -> int:
    """Return the frequency of a period by the formula as it is printed, in decimals (manual 1775 to 1809)."""
    if number == 0:
        return low or int((Decimal(rate_.numerator) / rate_.denominator / 2).sqrt().quantize(Decimal(1), ROUND_HALF_UP))
    return rounded_up(low, rate_, number)


def rounded_up(low: int, rate_: Fraction, number: int) -> int:
    with localcontext(prec=60):
        hz_per_s = Decimal(rate_.numerator) / rate_.denominator
        before = low * low / (2 * hz_per_s) + number
        exact = (hz_per_s / 2).sqrt() / ((before + 1).sqrt() - before.sqrt())
        return int(exact.quantize(Decimal("1e-30")).to_integral_value(ROUND_CEILING))


ENDS = st.one_of(st.just(0), st.integers(0, 3_000))
STEEPNESS = st.one_of(
    st.integers(1, 50).map(lambda root: Fraction(2_000 * root * root)),  # whole frequencies
    st.builds(Fraction, st.integers(1_000_000, 50_000_000), st.integers(1, 1_000)),
)


@pytest.mark.long
@pytest.mark.manual("SCU-084")
@settings(max_examples=60, deadline=None)
@given(ENDS, ENDS, STEEPNESS, STEEPNESS, st.integers(0, 47_000), st.integers(4, 80))
def test_every_period_of_a_move_has_the_lowest_of_the_printed_frequencies(
    start: int, stop: int, up: Fraction, down: Fraction, above: int, distance: int
) -> None:
    top = max(start, stop, end_frequency(0, up), end_frequency(0, down)) + above + 1
    pieces = move(Staircase(start, up), Staircase(stop, down), top, distance)
    found = [piece.frequency for piece in pieces for _ in range(piece.count or 0)]
    assert found == [
        min(printed(start, up, number), top, printed(stop, down, distance - 1 - number)) for number in range(distance)
    ]


@pytest.mark.long
@pytest.mark.manual("SCU-046", "SCU-084")
@settings(max_examples=25, deadline=None)
@given(st.integers(1, 4_000), st.integers(1, 2_000), STEEPNESS)
def test_a_change_of_the_velocity_has_the_printed_periods_in_both_directions(
    low: int, above: int, rate_: Fraction
) -> None:
    high = low + above
    expected: list[int] = []
    while len(expected) < 1_000 and (frequency := rounded_up(low, rate_, len(expected))) <= high:
        expected.append(frequency)
    for first, second, ramp in ((low, high, expected), (high, low, expected[::-1])):
        pieces = approach(first, second, rate_, is_from_rest=False)
        runs = [(piece.frequency, piece.count) for piece in pieces]
        assert runs.pop() == (second, None)
        found = [frequency for frequency, count in runs for _ in range(count or 0)]
        if len(expected) < 1_000:
            assert found == ramp
