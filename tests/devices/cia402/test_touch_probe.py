"""60B8h to 60BDh: where the axis was at the edges of two inputs, or at the encoder's zero."""

import pytest
from cia402_bench import Cia402Bench

from fieldrig_devices.cia402.motor import Captured

PV = 3
SPEED = 1_000_000
STEP = 4_000
"""Increments in a cycle."""


@pytest.fixture
def bench() -> Cia402Bench:
    """It turns; probe 1 is on from 10 000 to 30 000 in each 100 000, probe 2 in the other places."""
    bench = Cia402Bench()
    bench.motor.switches = lambda position: 0x1_0000 if 10_000 <= position % 100_000 <= 30_000 else 0x2_0000
    bench.motor.revolution = 70_000
    return bench


def turn(bench: Cia402Bench) -> Cia402Bench:
    return bench.put(0x6083, 1_000_000_000).put(0x60FF, SPEED).enabled(PV)


def test_both_edges_of_the_first_event(bench: Cia402Bench) -> None:
    bench.put(0x60B8, 0x0031)
    assert bench.get(0x60B9) == 0x0001
    turn(bench).cycles_until(lambda: bench.get(0x60B9) != 0x0001)
    assert (bench.get(0x60B9), bench.motor.position <= 10_000 + 2 * STEP) == (0x0003, True)
    bench.cycles(100)
    assert bench.get(0x60B9) == 0x0007
    assert 10_000 <= bench.get(0x60BA) <= 10_000 + STEP
    assert 30_000 <= bench.get(0x60BB) <= 30_000 + STEP


@pytest.mark.long
def test_a_probe_that_is_disabled_keeps_its_values_and_is_ready_again(bench: Cia402Bench) -> None:
    turn(bench).put(0x60B8, 0x0011).cycles(100)
    value = bench.get(0x60BA)
    bench.put(0x60B8, 0)
    assert (bench.get(0x60B9), bench.get(0x60BA)) == (0, value)
    bench.cycles(30).put(0x60B8, 0x0011).cycles(30)
    assert bench.get(0x60B9) == 0x0003
    assert bench.get(0x60BA) > value + 100_000


@pytest.mark.long
def test_an_edge_that_is_disabled_and_enabled_again_is_looked_for_again(bench: Cia402Bench) -> None:
    """CiA 402-2, timing diagram of the touch probe: bit 4 falls, so 60B9h bit 1 falls and 60BAh keeps its value."""
    turn(bench).put(0x60B8, 0x0031).cycles(20)
    value = bench.get(0x60BA)
    assert bench.get(0x60B9) == 0x0007
    bench.put(0x60B8, 0x0021)
    assert (bench.get(0x60B9), bench.get(0x60BA)) == (0x0005, value)
    bench.put(0x60B8, 0x0031)
    assert (bench.get(0x60B9), bench.get(0x60BA)) == (0x0005, value)
    bench.cycles(25)
    assert bench.get(0x60B9) == 0x0007
    assert bench.get(0x60BA) == pytest.approx(value + 100_000, abs=STEP)


def test_a_probe_that_is_told_the_same_again_keeps_what_it_has(bench: Cia402Bench) -> None:
    turn(bench).put(0x60B8, 0x0011).cycles(10)
    value = bench.get(0x60BA)
    bench.put(0x60B8, 0x0011).cycles(60)
    assert (bench.get(0x60B9), bench.get(0x60BA)) == (0x0003, value)


def test_edges_without_the_probe_are_none(bench: Cia402Bench) -> None:
    turn(bench).put(0x60B8, 0x1110).cycles(60)
    assert (bench.get(0x60B9), bench.get(0x60BA)) == (0x0300, 0)


def test_continuous_events_are_overwritten(bench: Cia402Bench) -> None:
    turn(bench).put(0x60B8, 0x0013).cycles(10)
    first = bench.get(0x60BA)
    bench.cycles(75)
    assert bench.get(0x60BA) == pytest.approx(first + 300_000, abs=STEP)
    assert (bench.get(0x60B9), bench.get(0x60BB)) == (0x0003, 0)


def test_the_second_probe_has_the_upper_byte(bench: Cia402Bench) -> None:
    turn(bench).put(0x60B8, 0x3100).cycles(60)
    assert bench.get(0x60B9) & 0xFFFF == 0x0700
    assert 30_000 <= bench.get(0x60BC) <= 30_000 + 2 * STEP
    assert 10_000 <= bench.get(0x60BD) <= 10_000 + 2 * STEP


def test_the_zero_of_the_encoder(bench: Cia402Bench) -> None:
    bench.motor.position = 1_000
    turn(bench).put(0x60B8, 0x0015).cycles(60)
    assert (bench.get(0x60B9), bench.get(0x60BA)) == (0x0003, 70_000)
    bench.put(0x60B8, 0).put(0x60FF, -SPEED).cycles(5).put(0x60B8, 0x0025).cycles(40)
    assert (bench.get(0x60B9), bench.get(0x60BB) % 70_000) == (0x0005, 0)


@pytest.mark.long
def test_an_axis_that_is_not_enabled_is_probed_too(bench: Cia402Bench) -> None:
    bench.put(0x60B8, 0x0011)
    assert bench.axis.is_awake
    bench.cycles(2)
    bench.motor.position = 20_000
    assert bench.cycles(1).get(0x60BA) == 20_000


def test_values_are_in_the_units_of_the_user(bench: Cia402Bench) -> None:
    bench.put(0x607E, 0x80).put(0x60B8, 0x0011)
    bench.motor.position = 20_000
    assert bench.cycles(1).get(0x60BA) == -20_000
    bench.put(0x607E, 0)
    assert bench.get(0x60BA) == -20_000


@pytest.mark.long
@pytest.mark.parametrize("function", [0x000D, 0x0D00])
def test_sources_that_are_not_there_are_refused(bench: Cia402Bench, function: int) -> None:
    assert bench.try_put(0x60B8, function) == "06090030"


def test_a_reset_of_the_node_ends_it(bench: Cia402Bench) -> None:
    bench.put(0x60B8, 0x0011)
    bench.send("000#81 05")
    assert (bench.get(0x60B8), bench.get(0x60B9), bench.axis.is_awake) == (0, 0, True)
    assert not bench.cycles(2).axis.is_awake


def test_60d0_names_the_source(bench: Cia402Bench) -> None:
    """Probe 1 by the encoder zero (5), and probe 2 by the input of probe 1."""
    bench.put(0x60D0, 5, 1).put(0x60D0, 1, 2).put(0x60B8, 0x1919)
    bench.motor.position = 1_300_000
    assert bench.cycles(1).get(0x60BA) == 1_260_000  # the encoder has a zero each 70 000
    bench.motor.switches = lambda position: 1 << 16
    assert bench.cycles(1).get(0x60BC) == 1_300_000
    assert bench.get(0x60B9) == 0x0303


@pytest.mark.parametrize("source", [0, 3, -1])
def test_60d0_refuses_other_sources(bench: Cia402Bench, source: int) -> None:
    assert bench.try_put(0x60D0, source, 1) == "06090030"


def test_a_captured_edge_has_its_own_position_and_time(bench: Cia402Bench) -> None:
    bench.put(0x60B8, 0x0011)
    bench.motor.edges[16] = Captured(12_345, 5_000_000_123)
    bench.motor.position, bench.motor.switches = 20_000, lambda position: 1 << 16
    assert bench.cycles(1).get(0x60BA) == 12_345
    assert bench.get(0x60D1) & 0xFFFF_FFFF == 5_000_000_123 & 0xFFFF_FFFF


def test_counters_count_all_edges_since_the_probe_was_enabled(bench: Cia402Bench) -> None:
    bench.put(0x60B8, 0x0031)
    for levels in (1 << 16, 0, 1 << 16):
        bench.motor.switches = dict.fromkeys((bench.motor.position,), levels).__getitem__
        bench.cycles(1)
    assert (bench.get(0x60D5), bench.get(0x60D6), bench.get(0x60B9)) == (2, 1, 0x0007)
    assert bench.put(0x60B8, 0).put(0x60B8, 0x0031).get(0x60D5) == 0
