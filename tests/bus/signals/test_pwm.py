"""PWM on a wire.  The expected periods are those of the HMISCU's manual, section 10 of its digest."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import S
from fieldrig_bus.signals.codec import check_sent, decode, encode, show
from fieldrig_bus.signals.pwm import Pwm

# Frequency in Hz, duty in %, second rising edge and first falling edge in ns.
CASES = [
    (10, 25, 100_000_000, 25_000_000),
    (1_000, 50, 1_000_000, 500_000),
    (50_000, 50, 20_000, 10_000),
    (65_000, 15, 15_385, 2_308),
]


@pytest.mark.parametrize(("frequency", "duty", "period_ns", "high_ns"), CASES)
def test_the_cycles_of_the_manual(frequency: int, duty: int, period_ns: int, high_ns: int) -> None:
    signal = Pwm("heater.pwm", duty, start_ns=7, frequency=frequency)
    assert list(signal.edges(0, period_ns + 8)) == [(7, True), (7 + high_ns, False), (7 + period_ns, True)]
    assert signal.at(10**9) == duty
    assert [signal.pulses_at(instant) for instant in (6, 7, 6 + period_ns, 7 + period_ns)] == [0, 1, 1, 2]


@pytest.mark.parametrize(("duty", "level"), [(0, False), (100, True)])
def test_an_output_that_is_always_low_or_high_has_no_edges(duty: int, level: bool) -> None:
    signal = Pwm("p", duty, frequency=1_000)
    assert list(signal.edges(0, S)) == []
    assert signal.level_at(S) is level
    assert signal.pulses_at(S) == 0
    assert signal.cycles_at(S) == 1_001


def test_the_encoding() -> None:
    signal = Pwm("pwm.out", 25, "%", 5, Fraction(1001, 10))
    assert encode(signal) == b'["pwm.out","pwm",25,"%",5,1001,10]'
    assert decode(encode(signal)) == signal
    assert show(signal) == "pwm.out = 25 %, 100.1 Hz"


SIGNALS = st.builds(
    Pwm,
    st.just("p"),
    st.integers(0, 100) | st.floats(0.2, 99.8),
    start_ns=st.integers(-S, S),
    frequency=st.integers(1, 10**6) | st.fractions(Fraction(1, 10), 10**6, max_denominator=100),
)


@given(SIGNALS, st.integers(-S, 2 * S))
def test_edges_are_in_order_and_agree_with_level_and_count(signal: Pwm, from_ns: int) -> None:
    check_sent(signal)
    assert decode(encode(signal)) == signal
    level, count = signal.level_at(from_ns - 1), signal.pulses_at(from_ns - 1)
    for _, (instant_ns, is_high) in zip(range(20), signal.edges(from_ns, from_ns + S), strict=False):
        assert instant_ns >= from_ns
        count += is_high
        assert signal.pulses_at(instant_ns) == count
        if is_high is not level:
            assert signal.level_at(instant_ns) is is_high
        level = is_high


@pytest.mark.parametrize("fields", ['-1,"%",0,1,1', '101,"%",0,1,1', 'true,"%",0,1,1', '5,"%",0,0,1', '5,"%",0,1,0',
                                    '5,"%",0,-1,1', '5,"%",0.5,1,1', '5,"%",0,1', '5,"%",0,90000000,1'])  # fmt: skip
def test_what_is_no_pwm_is_refused(fields: str) -> None:
    with pytest.raises((ValueError, TypeError)):
        decode(f'["p","pwm",{fields}]'.encode())
