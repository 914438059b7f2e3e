"""DAC with slope, the owner of an output, and diagnostic outputs (manual 3.1, 5.6.2)."""

import pytest
from arp_signals import SignalsBench, SignalsCard
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.arp.parameters import Kind

SOURCE, GAIN, OFFSET = 10, 11, 12  # @Par of diagnostic output 1; add 3 for output 2
CODES = range(1, 10)


def ms_until(card: SignalsCard, channel: int, volts: float) -> int:
    """Number of loops of 1 ms until the output has settled."""
    for ms in range(20_000):
        if card.outputs.volts(channel) == volts:
            return ms
        card.loop()
    raise AssertionError(f"never at {volts} V")


@pytest.mark.manual("ARP-039")
@pytest.mark.manual("ARP-092")
@pytest.mark.parametrize("channel", [1, 2])
def test_dac_without_a_slope_is_there_at_once(channel: int) -> None:
    bench = SignalsBench(f"DAC {channel}, -10\nWAIT 0.005\nDAC {channel}, 7.125").run(1)
    assert (bench.card.outputs.volts(channel), bench.card.outputs.volts(3 - channel)) == (-10.0, 0.0)
    assert bench.run(6).card.outputs.volts(channel) == 7.125


@pytest.mark.manual("ARP-039")
@pytest.mark.parametrize("channel", [1, 2])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_range_of_both_outputs_is_10_volts(channel: int, sign: int) -> None:
    program = f"DAC {channel}, {sign * 10}\nWAIT 0.005\nV1 == {sign * 10.001}\nDAC {channel}, V1"
    bench = SignalsBench(program).run(1)
    assert (bench.card.outputs.volts(channel), bench.card.errors.warning) == (sign * 10.0, 0)
    assert bench.run(6).card.outputs.volts(channel) == sign * 10.0
    assert bench.card.errors.warning == 203


@pytest.mark.manual("ARP-092")
@pytest.mark.parametrize(
    ("begin", "end", "slope", "ms"),
    [
        ("-5", "5", "2", 2_000),  # digest 9 and 21
        ("0", "3", "0.5", 150),
        ("3", "0", "0.5", 150),
        ("0", "10", "0.010", 10),
        ("0", "10", "10.000", 10_000),
        ("0", "-10", "0.011", 11),
        ("1.234", "1.234", "5", 0),
    ],
)
def test_a10_the_slope_is_the_time_of_10_volts(begin: str, end: str, slope: str, ms: int) -> None:
    bench = SignalsBench(f"DAC 1, {begin}\nDAC 1, {end}, {slope}").run()
    assert ms_until(bench.card, 1, float(end)) == ms
    assert bench.card.errors.warning == 0


@pytest.mark.manual("ARP-092")
def test_a_slope_is_a_straight_line() -> None:
    card = SignalsBench("DAC 2, -5\nDAC 2, 5, 2").run().card
    for ms in range(1, 2_001):
        card.loop()
        assert card.outputs.volts(2) == pytest.approx(-5 + ms * 0.005)


@pytest.mark.manual("ARP-092")
def test_a_later_dac_goes_on_from_the_present_voltage() -> None:
    card = SignalsCard()
    card.outputs.write(1, 10_000, 1_000)
    card.loop(300)
    assert card.outputs.volts(1) == pytest.approx(3.0)
    card.outputs.write(1, 0, 100)
    card.loop(10)
    assert card.outputs.volts(1) == pytest.approx(2.0)
    card.outputs.write(1, -1_500, 0)
    card.loop(500)
    assert card.outputs.volts(1) == -1.5


def test_a_slope_goes_by_time_when_loops_are_missed() -> None:
    card = SignalsCard()
    card.outputs.write(1, 10_000, 1_000)
    card.loop(100, 10)
    assert card.outputs.volts(1) == pytest.approx(1.0)


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.integers(-10_000, 10_000), st.integers(10, 10_000), st.integers(1, 40)), max_size=8))
def test_no_slope_is_ever_steeper_than_asked(orders: list[tuple[int, int, int]]) -> None:
    card = SignalsCard()
    for volt, slope_ms, loops in orders:
        before, asked = card.outputs.volts(1), volt / 1_000
        card.outputs.write(1, volt, slope_ms)
        for _ in range(loops):
            last = card.outputs.volts(1)
            card.loop()
            step = abs(card.outputs.volts(1) - last)
            assert step <= 10 / slope_ms * (1 + 1e-6)
            assert abs(card.outputs.volts(1)) <= 10
        gone = abs(card.outputs.volts(1) - before)
        assert gone == pytest.approx(min(abs(asked - before), 10 / slope_ms * loops))


@pytest.mark.manual("ARP-092")
@pytest.mark.parametrize("channel", [1, 2])
@pytest.mark.parametrize("owner", ["diagnostics", "axis", "pid"])
def test_dac_on_an_owned_output_is_ignored_with_w03(channel: int, owner: str) -> None:
    bench = SignalsBench(f"WAIT 0.005\nDAC {channel}, 5\nDAC {3 - channel}, 2")
    card = bench.card
    match owner:
        case "diagnostics":
            card.diagnostics[1, 1] = 1.5
            assert card.set_general(SOURCE + 3 * (channel - 1), 1)
        case "axis":
            card.driven[channel] = 1.5
        case "pid":
            card.outputs.regulate(channel, 1.5)
    bench.run(10)
    assert (card.outputs.volts(channel), card.errors.warning) == (1.5, 203)
    assert card.outputs.volts(3 - channel) == 2.0


@pytest.mark.manual("ARP-014")
def test_owners_come_in_their_order_and_the_last_leaves_0_volts() -> None:
    card = SignalsCard()
    card.diagnostics[2, 8] = 4.0
    assert card.set_general(SOURCE, 18)
    card.driven[1] = 3.0
    card.outputs.regulate(1, 2.0)
    seen = []
    for release in (lambda: card.set_general(SOURCE, 0), lambda: card.driven.update({1: None}), lambda: None):
        card.loop()
        seen.append(card.outputs.volts(1))
        release()
    card.outputs.regulate(1, None)
    card.loop()
    assert [*seen, card.outputs.volts(1)] == [4.0, 3.0, 2.0, 0.0]
    card.outputs.write(1, 1_000, 0)
    assert (card.outputs.volts(1), card.errors.warning) == (1.0, 0)


def test_an_owner_makes_an_earlier_dac_forgotten() -> None:
    card = SignalsCard()
    card.outputs.write(2, 5_000, 1_000)
    card.loop(100)
    card.outputs.regulate(2, 6.0)
    card.loop()
    card.outputs.regulate(2, None)
    card.loop(1_000)
    assert card.outputs.volts(2) == 0.0


@pytest.mark.manual("ARP-014")
@pytest.mark.parametrize("channel", [1, 2])
@pytest.mark.parametrize("axis", [1, 2])
def test_every_source_of_a_diagnostic_output(channel: int, axis: int) -> None:
    card = SignalsCard()
    card.diagnostics = {(axis, code): axis + code / 10 for axis in (1, 2) for code in CODES}
    for code in CODES:
        assert card.set_general(SOURCE + 3 * (channel - 1), 10 * (axis - 1) + code)
        card.loop()
        assert card.outputs.volts(channel) == pytest.approx(axis + code / 10)
        assert card.outputs.volts(3 - channel) == 0.0
    assert not card.set_general(SOURCE + 3 * (channel - 1), 10)  # 10 and 20 are not sources
    assert not card.set_general(SOURCE + 3 * (channel - 1), 20)


@pytest.mark.manual("ARP-015")
@pytest.mark.parametrize("channel", [1, 2])
@pytest.mark.parametrize(
    ("value", "gain", "offset", "volts"),
    [
        (5_000.0, 0.001, 0, 5.0),
        (5_000.0, 0.001, -7.5, -2.5),
        (2.0, -3.0, 0.5, -5.5),
        (5_000.0, 1.0, 0, 10.0),
        (-5_000.0, 1.0, 4, -10.0),
        (7.0, 0, 3.333, 3.333),
    ],
)
def test_gain_and_offset_are_taken_while_it_runs(
    channel: int, value: float, gain: float, offset: float, volts: float
) -> None:
    card = SignalsCard()
    card.diagnostics[1, 3] = value
    first = SOURCE + 3 * (channel - 1)
    assert card.set_general(first, 3)
    card.loop()
    assert card.outputs.volts(channel) == max(-10.0, min(10.0, value))
    assert card.set_general(first + 1, gain)
    assert card.set_general(first + 2, offset)
    card.loop()
    assert card.outputs.volts(channel) == pytest.approx(volts)


@pytest.mark.manual("ARP-041")
def test_release_brings_both_to_0_volts() -> None:
    card = SignalsCard()
    card.set_kind(2, Kind.CONTROLLED)
    card.driven[2] = 5.0
    card.outputs.write(1, 5_000, 0)
    card.loop()
    assert (card.outputs.volts(1), card.outputs.volts(2)) == (5.0, 5.0)
    card.outputs.release()
    assert (card.outputs.volts(1), card.outputs.volts(2)) == (0.0, 0.0)
    card.driven[2] = 0.0
    card.loop(10)
    assert (card.outputs.volts(1), card.outputs.volts(2)) == (0.0, 0.0)


@settings(max_examples=60, deadline=None)
@given(st.floats(allow_nan=False), st.floats(allow_nan=False), st.integers(-(10**6), 10**6))
def test_no_output_ever_leaves_10_volts(axis_volts: float, regulated: float, offset: int) -> None:
    card = SignalsCard()
    card.driven[1] = axis_volts
    card.outputs.regulate(2, regulated)
    card.loop()
    assert max(abs(card.outputs.volts(channel)) for channel in (1, 2)) <= 10
    card.diagnostics[1, 1] = axis_volts
    assert card.set_general(SOURCE, 1)
    assert card.set_general(OFFSET, offset / 1000)
    card.loop()
    assert abs(card.outputs.volts(1)) <= 10
