"""Velocity mode (vl): the ramp function of CiA 402-2 with its bits, factors and limits.

A turn is 1 000 000 increments.
"""

import pytest
from cia402_bench import Cia402Bench

pytestmark = pytest.mark.long

VL = 2
RUN = 0x7F
PER_RPM = 1_000_000 / 60
RAMP = 600 * PER_RPM * 0.004
"""Change of the speed in a cycle by the start values of 6048h and 6049h, 600 min-1 in a second."""


@pytest.fixture
def bench() -> Cia402Bench:
    return Cia402Bench().put(0x6042, 300).enabled(VL)


def speed(bench: Cia402Bench, cycles: int) -> float:
    """The speed of the motor after some cycles, in min-1."""
    return round(bench.cycles(cycles).motor.velocity / PER_RPM, 1)


def test_the_bits_of_the_ramp_start_it(bench: Cia402Bench) -> None:
    """0Fh alone leaves bits 4 to 6 at 0, which is no ramp at all."""
    assert speed(bench, 200) == 0
    bench.control(RUN)
    assert speed(bench, 26) == pytest.approx(60, abs=3)  # 100 ms of 600 min-1 in a second
    assert speed(bench, 125) == 300
    assert (bench.get(0x6043), bench.get(0x6044), bench.status(0x0400)) == (300, 300, 0x0400)


@pytest.mark.parametrize(
    ("word", "then"),
    [(0x3F, 0), (0x0F, 0), (0x5F, 300), (0x17F, 0)],  # reference at 0, no ramp, locked, halt
)
def test_each_bit_has_its_meaning(bench: Cia402Bench, word: int, then: int) -> None:
    bench.control(RUN).cycles(200).control(word).put(0x6042, 900)
    assert speed(bench, 400) == then


def test_a_locked_ramp_keeps_its_output_and_goes_on_from_there(bench: Cia402Bench) -> None:
    bench.control(RUN).cycles(50).control(0x5F)
    held = speed(bench, 50)
    assert 0 < held < 300
    bench.control(RUN)
    assert speed(bench, 200) == 300


def test_deceleration_and_quick_stop_have_ramps_of_their_own(bench: Cia402Bench) -> None:
    bench.put(0x6049, 300, 1).control(RUN).cycles(200).put(0x6042, 0)
    assert speed(bench, 126) == pytest.approx(150, abs=3)  # half a second of 300 min-1 in a second
    bench.put(0x6042, 300).cycles(300).put(0x605A, 6).control(0x02)
    assert speed(bench, 6) == pytest.approx(180, abs=25)  # 20 ms of 6000 min-1 in a second
    assert speed(bench, 20) == 0


def test_factors_and_limits_apply_to_the_target(bench: Cia402Bench) -> None:
    bench.put(0x604C, 1, 1).put(0x604C, 2, 2).control(RUN)  # a pole pair more: electrical turns
    assert speed(bench, 300) == 150
    assert bench.get(0x6044) == 300
    bench.put(0x6046, 200, 1)
    assert speed(bench, 300) == 200
    bench.put(0x6042, -10)
    assert speed(bench, 900) == -200
    bench.put(0x6042, 0)
    assert speed(bench, 300) == 0  # our choice: a master stops it
    bench.put(0x6042, 300)
    bench.put(0x6046, 0, 1).put(0x6046, 100, 2)
    assert speed(bench, 300) == 100
    assert bench.status(0x0800) == 0x0800


def test_a_limit_switch_stops_it_and_the_way_back_is_free(bench: Cia402Bench) -> None:
    bench.motor.switches = lambda position: (position > 500_000) << 1
    bench.control(RUN)
    assert speed(bench, 600) == 0
    bench.put(0x6042, -60)
    assert speed(bench, 100) == -60


def test_the_polarity_of_velocities_turns_it_round(bench: Cia402Bench) -> None:
    bench.put(0x607E, 0x40).control(RUN)
    assert speed(bench, 200) == -300
    assert bench.get(0x6044) == 300
