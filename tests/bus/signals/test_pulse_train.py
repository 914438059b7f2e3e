"""A pulse train: its edges, counts and totals, by closed formulas and by properties.

The expected instants are from N(t) = f t + r t^2 / 2, as in the digest of the HMISCU's manual, section 9.
"""

from fractions import Fraction
from math import sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS, S
from fieldrig_bus.signals.codec import check_sent, decode, encode, show
from fieldrig_bus.signals.pulse_train import PulseTrain


def test_a_constant_train_rises_at_the_beginning_of_each_period() -> None:
    train = PulseTrain("pto.pulse", 0, start_ns=5, frequency=50_000, count=3)
    assert list(train.edges(0, S)) == [
        (5, True), (10_005, False), (20_005, True), (30_005, False), (40_005, True), (50_005, False),
    ]  # fmt: skip
    assert train.end_ns == 60_005
    assert [train.at(instant) for instant in (4, 5, 20_004, 20_005, 40_005, 10**9)] == [0, 1, 1, 2, 3, 3]


def test_a_period_that_is_no_whole_number_does_not_drift() -> None:
    train = PulseTrain("p", 0, frequency=3, count=None)
    assert train.rise_ns(2) == 333_333_334
    assert train.rise_ns(4) == S
    assert train.rise_ns(3_000_000_001) == 1_000_000_000 * S
    assert train.pulses_at(10**9 * S - 1) == 3_000_000_000


@pytest.mark.parametrize("rate", [20_000, 2_500_000])
@pytest.mark.parametrize("number", [1, 2, 3, 10, 1000])
def test_a_train_from_standstill_follows_the_parabola(rate: int, number: int) -> None:
    train = PulseTrain("p", 0, rate=rate, count=5000)
    ideal_ns = sqrt(2 * (number - 1) / rate) * S
    risen_ns = train.rise_ns(number)
    assert risen_ns is not None
    assert 0 <= risen_ns - ideal_ns < 1.001


def test_a_train_that_ends_at_zero_is_complete_when_it_stops() -> None:
    train = PulseTrain("p", 0, frequency=10_000, rate=-10_000, count=5_000)  # manual case: 10000^2 / (2 * 10000) pulses
    assert train.end_ns == S
    assert train.pulses_at(S - 1) == train.pulses_at(S) == 5_000
    assert train.frequency_at(S // 2) == 5_000
    assert train.frequency_at(S) == 0
    assert not train.level_at(S)


def test_a_part_of_a_pulse_at_the_end_falls_when_the_train_stops() -> None:
    train = PulseTrain("p", 0, frequency=9_750, rate=-9_750, count=4_875)
    longer = PulseTrain("p", 0, frequency=99, rate=-100, count=50)  # 49.005 periods until it stands
    check_sent(train)
    check_sent(longer)
    assert longer.end_ns == 990_000_000
    assert list(longer.edges(980 * MS, S)) == [(980 * MS, True), (990 * MS, False)]


def test_a_long_move_costs_no_more_than_a_short_one() -> None:
    train = PulseTrain("p", 0, frequency=50_000, count=4_294_967_295)
    assert train.rise_ns(4_294_967_295) == 4_294_967_294 * 20_000
    assert train.end_ns == 4_294_967_295 * 20_000
    assert train.pulses_at(10**18) == 4_294_967_295


def test_the_next_segment_goes_on_within_a_period() -> None:
    first = PulseTrain("p", 0, frequency=1_000, count=None)
    second = first.then(5_250_000, 500, count=None, phase=first.phase_at(5_250_000))
    assert second.phase == Fraction(1, 4)
    assert second.sent == second.value == 6
    assert second.level_at(5_250_000)
    assert list(second.edges(0, 9 * MS)) == [
        (5_750_000, False),
        (6_750_000, True),
        (7_750_000, False),
        (8_750_000, True),
    ]


def test_an_edge_at_the_instant_of_a_new_segment_is_that_segment_s() -> None:
    first = PulseTrain("p", 0, frequency=1_000, count=None)
    second = first.then(5 * MS, 2_000, count=2, direction=-1)
    assert (second.sent, second.value) == (5, 5)
    assert second.at(5 * MS) == 4
    third = second.then(6 * MS)
    assert (third.sent, third.value, third.direction) == (7, 3, -1)
    assert not third.level_at(6 * MS)


def test_the_encoding() -> None:
    train = PulseTrain("pto.pulse", -2, "count", 7, 20_000, Fraction(-5, 3), 12, -1, Fraction(1, 4), 4, 3)
    data = b'["pto.pulse","pulses",-2,"count",7,20000,1,-5,3,12,-1,1,4,4,3]'
    assert encode(train) == data
    assert decode(data) == train
    assert show(train) == "pto.pulse = -2 count, 20000 Hz, -1.6666666666666667 Hz/s, 12 pulses backwards"


FREQUENCIES = st.fractions(0, 1_000_000, max_denominator=1_000) | st.integers(0, 1_000_000)
RATES = st.fractions(-(10**8), 10**8, max_denominator=50_000) | st.integers(-(10**8), 10**8)


@st.composite
def trains(draw: st.DrawFn) -> PulseTrain:
    """Any legal segment, of which the sender may be anywhere in its life."""
    frequency, phase = draw(FREQUENCIES), draw(st.just(0) | st.fractions(0, Fraction(999, 1000), max_denominator=1000))
    rate = draw(RATES) if draw(st.booleans()) else 0
    back, forth = draw(st.integers(0, 10**6)), draw(st.integers(0, 10**6))
    most = 10**5
    if rate < 0:
        most = min(most, int(Fraction(frequency) ** 2 / (-2 * rate)))
    count = draw(st.integers(0, most)) if rate or not frequency else draw(st.none() | st.integers(0, most))
    if not rate and not frequency:
        count = 0
    start_ns, direction = draw(st.integers(0, 10**18)), draw(st.sampled_from((1, -1)))
    train = PulseTrain(
        "p",
        forth - back,
        "count",
        start_ns,
        frequency,
        rate,
        count,
        direction,
        phase,
        back + forth,
        draw(st.integers(0, 9)),
    )
    try:
        check_sent(train)
    except ValueError:
        return PulseTrain("p", 0, start_ns=start_ns, frequency=frequency + 1, count=count)
    return train


@given(trains())
def test_every_train_comes_back(train: PulseTrain) -> None:
    assert decode(encode(train)) == train


@given(trains(), st.integers(1, 10**5))
def test_a_pulse_is_counted_at_its_rising_edge(train: PulseTrain, number: int) -> None:
    risen_ns = train.rise_ns(number)
    if risen_ns is None:
        assert train.count is not None
        assert number > train.count
        return
    assert train.pulses_at(risen_ns) >= number
    assert train.pulses_at(risen_ns - 1) < number
    fall_ns = train.fall_ns(number)
    assert fall_ns is not None
    assert fall_ns >= risen_ns
    assert train.end_ns is None or fall_ns <= train.end_ns


@given(trains(), st.integers(-10, 2 * 10**9))
def test_edges_are_in_order_and_agree_with_level_and_count(train: PulseTrain, after_ns: int) -> None:
    from_ns = train.start_ns + after_ns
    edges = [edge for edge, _ in zip(train.edges(from_ns, from_ns + S), range(20), strict=False)]
    level, count = train.level_at(from_ns - 1), train.pulses_at(from_ns - 1)
    if from_ns <= train.start_ns:
        level = 0 < train.phase < Fraction(1, 2)
    last_ns = from_ns
    for instant_ns, is_high in edges:
        assert instant_ns >= last_ns
        assert is_high is not level
        level, last_ns, count = is_high, instant_ns, count + is_high
        assert train.level_at(instant_ns) is is_high
        assert train.pulses_at(instant_ns) == count


@given(trains(), st.integers(0, 2 * 10**9), st.booleans())
def test_the_totals_go_on_with_the_next_segment(train: PulseTrain, after_ns: int, is_smooth: bool) -> None:
    start_ns = train.start_ns + after_ns
    following = train.then(start_ns, 1_000, count=None, phase=train.phase_at(start_ns) if is_smooth else 0)
    check_sent(following)
    assert following.sent == train.sent + train.pulses_at(start_ns - 1)
    assert following.sent_at(start_ns - 1) == following.sent


@pytest.mark.parametrize(
    "change",
    [
        "1.5,1,0,1,5,1,0,1,0,0", "-1,1,0,1,5,1,0,1,0,0", "1,0,0,1,5,1,0,1,0,0", "20000000,1,0,1,5,1,0,1,0,0",
        "1,1,0,1,-5,1,0,1,0,0", "1,1,0,1,true,1,0,1,0,0", "1,1,0,1,5,0,0,1,0,0", "1,1,0,1,5,2,0,1,0,0",
        "1,1,0,1,5,1,1,1,0,0", "1,1,0,1,5,1,0,1,1,0", "1,1,0,1,5,1,0,1,-2,0", "1,1,-1,1,5,1,0,1,0,0",
        "0,1,0,1,5,1,0,1,0,0", "1,1,1,1,null,1,0,1,0,0", "0,1,0,1,null,1,0,1,0,0", '1,1,0,1,"5",1,0,1,0,0',
        "1,1,1000000000000,1,1000,1,0,1,0,0", "1,1,0,1,5,1,0,1,0", "1,1,0,1,5,1,0,1,0,0,0", "1,1,0,1,5,1,0,-1,0,0",
    ],
)  # fmt: skip
def test_what_is_no_train_is_refused(change: str) -> None:
    with pytest.raises((ValueError, TypeError)):
        decode(f'["p","pulses",0,"count",0,{change}]'.encode())


@given(st.lists(st.integers(-3, 3) | st.none() | st.text(max_size=1) | st.floats(), min_size=11, max_size=11))
def test_no_fields_raise_anything_else(fields: list[object]) -> None:
    import json

    try:
        decoded = decode(json.dumps(["p", "pulses", 0, "count", *fields]).encode())
    except (ValueError, TypeError):
        return
    assert isinstance(decoded, PulseTrain)
