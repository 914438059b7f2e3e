"""Load cells with range and filter, analog inputs (manual 3.1, 5.6.1)."""

import math

import pytest
from arp_signals import SignalsBench, SignalsCard
from hypothesis import given, settings
from hypothesis import strategies as st

RANGES = {1: 0.010, 2: 0.020}
FILTERS = {50: 2, 100: 4, 250: 10, 500: 20, 1000: 40}  # @Par[4]: frequency of -3 dB, both in Hz
SETTLED_MS = 1_000


def settled(card: SignalsCard, channel: int, volt: float) -> int:
    card.inputs.take(channel, volt)
    card.loop(SETTLED_MS)
    return card.inputs.read(channel)


@pytest.mark.manual("ARP-008")
@pytest.mark.manual("ARP-038")
@pytest.mark.parametrize("channel", [1, 2])
@pytest.mark.parametrize(
    ("code", "volt", "raw"),
    [
        (0, 0.005, 0),
        (1, 0.004, 4_000_000),
        (1, -0.0012345, -1_234_500),
        (1, 0.010, 10_000_000),
        (1, 0.0101, 10_000_000),
        (1, -3.0, -10_000_000),
        (2, 0.0101, 10_100_000),
        (2, 0.021, 20_000_000),
        (2, -0.021, -20_000_000),
    ],
)
def test_a_load_cell_reads_in_microvolts_within_its_range(channel: int, code: int, volt: float, raw: int) -> None:
    card = SignalsCard({channel + 1: code})  # the other load cell is absent
    assert settled(card, channel, volt) == raw
    assert settled(card, 3 - channel, volt) == 0


@pytest.mark.manual("ARP-008")
@pytest.mark.manual("ARP-009")
def test_range_and_filter_are_read_at_power_on_only() -> None:
    card = SignalsCard({2: 1, 4: 1000})
    assert settled(card, 1, 0.015) == 10_000_000
    assert card.set_general(2, 2)
    assert card.set_general(4, 50)
    assert settled(card, 1, 0.0151) == 10_000_000
    assert steps_of(card, 40) == 40  # still at 1000 Hz
    card.inputs.start()
    assert settled(card, 1, 0.015) == 15_000_000
    assert steps_of(card, 40) == 2
    assert card.set_general(2, 0)
    card.inputs.start()
    assert card.inputs.read(1) == 0


def steps_of(card: SignalsCard, ms: int) -> int:
    """Number of changes of ADC 1 in a number of loops of 1 ms, after a step of its wire to -5 mV."""
    card.inputs.take(1, -0.005)
    changes, last = 0, card.inputs.read(1)
    for _ in range(ms):
        card.loop()
        changes, last = changes + (card.inputs.read(1) != last), card.inputs.read(1)
    return changes


@pytest.mark.manual("ARP-009")
@pytest.mark.parametrize("rate", FILTERS)
def test_a_load_cell_has_a_new_value_at_the_output_rate(rate: int) -> None:
    card = SignalsCard({2: 1, 4: rate})
    card.inputs.take(1, 0.004)
    card.loop(1_000 // rate - 1)
    assert card.inputs.read(1) == 0  # no conversion is over yet
    card.loop()
    assert card.inputs.read(1) == 4_000_000
    card.loop(SETTLED_MS)
    assert steps_of(card, 40) == 40 * rate // 1000


@pytest.mark.manual("ARP-009")
@pytest.mark.parametrize(("rate", "hertz"), FILTERS.items())
def test_the_filter_is_at_minus_3_db_where_the_table_says(rate: int, hertz: int) -> None:
    assert 20 * math.log10(gain_of(rate, hertz)) == pytest.approx(-3.01, abs=0.01)
    assert gain_of(rate, hertz / 20) == pytest.approx(1, abs=0.01)
    assert gain_of(rate, hertz * 4) < 0.3


def gain_of(rate: int, hertz: float) -> float:
    """Gain for a sine at the output rate, over whole periods after it has settled."""
    card = SignalsCard({2: 2, 4: rate})
    step_ms, turns = 1000 // rate, 4
    count = round(turns * rate / hertz)
    sine = cosine = 0.0
    for index in range(2 * count):
        angle = 2 * math.pi * hertz * index / rate
        card.inputs.take(1, 0.010 * math.sin(angle))
        card.loop(step_ms, step_ms)
        if index >= count:
            sine += card.inputs.read(1) * math.sin(angle)
            cosine += card.inputs.read(1) * math.cos(angle)
    return math.hypot(sine, cosine) / (count / 2) / 10_000_000


@pytest.mark.manual("ARP-009")
def test_a_slow_control_loop_finds_the_same_filtered_value() -> None:
    cards = {period: SignalsCard({2: 1, 4: 500}) for period in (1, 5, 10)}
    for period, card in cards.items():
        card.loop(100, period)
        card.inputs.take(1, 0.008)
    for _ in range(5):
        for period, card in cards.items():
            card.loop(10, period)
        assert len({card.inputs.read(1) for card in cards.values()}) == 1


@pytest.mark.manual("ARP-038")
@pytest.mark.manual("ARP-091")
@pytest.mark.parametrize(
    ("channel", "volt", "raw"),
    [
        *((channel, volt, raw) for channel in (3, 4) for volt, raw in ((2.5, 2_500), (-10.0, -10_000), (12, 10_000))),
        *((channel, volt, raw) for channel in (5, 6) for volt, raw in ((2.5, 2_500), (-1.0, 0), (12, 10_000))),
    ],
)
def test_adc_reads_volts_within_the_range_of_the_input(channel: int, volt: float, raw: int) -> None:
    bench = SignalsBench(f"LOOP:\nV1 == ADC {channel}\nGOTO LOOP")
    bench.card.inputs.take(channel, volt)
    assert bench.run().card.V[1] == raw
    bench.card.inputs.take(channel, 0.0)
    assert bench.run().card.V[1] == 0


@pytest.mark.manual("ARP-091")
def test_a10_adc_2_reads_the_load_cell() -> None:
    bench = SignalsBench("LOOP:\nV001 == ADC 2\nGOTO LOOP", SignalsCard({3: 2, 4: 1000}))
    bench.card.inputs.take(2, 0.012_345_678)
    assert bench.run(100).card.V[1] == 12_345_678  # 12345.678 uV


@settings(max_examples=50, deadline=None)
@given(st.floats(), st.sampled_from((0, 1, 2)))
def test_whatever_a_wire_says_the_reading_is_within_its_range(volt: float, code: int) -> None:
    card = SignalsCard({2: code, 3: code})
    for channel in range(1, 7):
        card.inputs.take(channel, volt)
    card.loop(100)
    limit = round(RANGES.get(code, 0) * 1e9)
    assert all(abs(card.inputs.read(channel)) <= limit for channel in (1, 2))
    assert all(abs(card.inputs.read(channel)) <= 10_000 for channel in (3, 4))
    assert all(0 <= card.inputs.read(channel) <= 10_000 for channel in (5, 6))
