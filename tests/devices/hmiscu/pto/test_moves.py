"""Moves and stops of a channel in virtual time, against the manual's examples (acceptance cases of the digest)."""

import itertools
from fractions import Fraction

import pytest
from hmiscu_bench import PtoBench, edges, shown

from fieldrig.clock import MS, S
from fieldrig_devices.hmiscu.enumerations import Direction, ErrorId
from fieldrig_devices.hmiscu.pto.status import MotionState

TO_20_KHZ = {"Velocity": 20_000, "Acceleration": 1_000, "Deceleration": 500}


# fs, fe, velocity, times in ms, pulses, seconds (digest 9.3 to 9.5; acceptance cases 6, 7, 8).
MOVES = [
    pytest.param(0, 0, TO_20_KHZ, 15_000, 1.5, id="case 1", marks=pytest.mark.manual("SCU-042")),
    pytest.param(0, 0, TO_20_KHZ, 40_000, 2.75, id="case 2", marks=pytest.mark.manual("SCU-033", "SCU-043")),
    pytest.param(0, 0, TO_20_KHZ, 5_000, 0.8660254, id="case 3", marks=pytest.mark.manual("SCU-044")),
    pytest.param(
        5_000, 5_000, {"Velocity": 20_000, "Acceleration": 10_000, "Deceleration": 10_000}, 300_000, 22.5, id="row 2"
    ),
    pytest.param(
        1_000, 500, {"Velocity": 30_000, "Acceleration": 2_000, "Deceleration": 1_000}, 100_000, 4.7916667, id="row 3"
    ),
]


@pytest.mark.manual("SCU-041", "SCU-031")
@pytest.mark.parametrize(("start", "stop", "inputs", "distance", "seconds"), MOVES)
def test_a_move_sends_its_pulses_in_the_time_of_the_formulas(
    start: int, stop: int, inputs: dict[str, int], distance: int, seconds: float
) -> None:
    bench = PtoBench(start_frequency_hz=start, stop_frequency_hz=stop)
    bench.relative(**inputs, Distance=distance)
    assert shown(bench.move) == {"Busy", "Active"}
    assert bench.rest_ns() / S == pytest.approx(seconds, abs=5e-8)
    bench.cycle()
    assert shown(bench.move) == {"Done"}
    assert bench.simple.outputs["Distance"] == distance == bench.sent
    assert bench.channel.state is MotionState.STANDSTILL


@pytest.mark.long
@pytest.mark.manual("SCU-084")
@pytest.mark.parametrize(("start", "stop", "inputs", "distance", "seconds"), MOVES)
def test_a_move_in_periods_sends_the_same_pulses_a_little_faster(
    start: int, stop: int, inputs: dict[str, int], distance: int, seconds: float
) -> None:
    bench = PtoBench(start_frequency_hz=start, stop_frequency_hz=stop, ramps="periods")
    bench.relative(**inputs, Distance=distance)
    assert seconds - 1e-3 < bench.rest_ns() / S < seconds
    assert bench.sent == distance


@pytest.mark.manual("SCU-020", "SCU-021", "SCU-084", "SCU-008")
def test_the_first_edges_of_a_move_have_the_periods_of_the_manual() -> None:
    bench = PtoBench(ramp_unit="Hz/ms", ramps="periods")
    bench.relative(Velocity=50_000, Distance=2_000, Acceleration=2_500, Deceleration=20)
    bench.rest_ns()
    found = edges(bench.segments)
    rises = [instant for instant, is_high in found if is_high]
    periods_us = [(later - earlier) / 1000 for earlier, later in itertools.pairwise(rises[:7])]
    assert periods_us == pytest.approx([894.5, 370.4, 284.3, 239.6, 211.1, 190.9], abs=0.06)
    assert found[1][0] == pytest.approx(894_454 / 2, abs=1)  # a square wave: half a period high
    assert bench.channel.output.train.start_ns - rises[-1] == pytest.approx(10_000_000, abs=2)  # sqrt(20000 / 2) Hz


@pytest.mark.manual("SCU-027", "SCU-046")
def test_the_manuals_acceleration_example() -> None:
    bench = PtoBench(start_frequency_hz=5_000, stop_frequency_hz=5_000)
    bench.run(Velocity=20_000, Acceleration=10_000)
    bench.cycle(5 * S)
    assert bench.frequency == pytest.approx(5_000 + 1_500 * 5, abs=1)
    bench.cycle(5 * S - MS)
    assert shown(bench.velocity) == {"Busy"}
    bench.cycle(2 * MS)
    assert shown(bench.velocity) == {"InVelocity"}
    assert bench.simple.outputs["Frequency"] == bench.frequency == 20_000


@pytest.mark.manual("SCU-036")
@pytest.mark.parametrize("distance", [1, 2, 3])
@pytest.mark.parametrize(("stop", "frequency"), [(0, 1118), (500, 500)])
def test_a_jog_goes_out_at_the_stop_frequency(distance: int, stop: int, frequency: int) -> None:
    bench = PtoBench(ramp_unit="Hz/ms", stop_frequency_hz=stop)
    bench.relative(Velocity=20_000, Distance=distance, Acceleration=2_500, Deceleration=2_500)
    assert bench.frequency == frequency
    assert bench.rest_ns() / S == pytest.approx(distance / frequency, abs=2e-9)
    assert bench.sent == distance


@pytest.mark.manual("SCU-034")
@pytest.mark.parametrize(("velocity", "is_flat"), [(1_000, True), (1_118, True), (1_119, False)])
def test_a_velocity_below_the_calculated_start_frequency_has_no_ramps(velocity: int, is_flat: bool) -> None:
    bench = PtoBench(ramp_unit="Hz/ms")
    bench.relative(Velocity=velocity, Distance=100, Acceleration=2_500, Deceleration=2_500)
    rest_ns = bench.rest_ns()
    assert (len(bench.segments) == 2) == is_flat
    assert (abs(rest_ns / S - 100 / velocity) < 2e-9) == is_flat


@pytest.mark.manual("SCU-045")
@pytest.mark.parametrize(("distance", "is_possible"), [(12, False), (13, True)])
def test_a_move_whose_maximum_is_not_above_the_start_frequency_is_an_error(distance: int, is_possible: bool) -> None:
    bench = PtoBench(ramp_unit="Hz/ms", start_frequency_hz=5_000, stop_frequency_hz=1_000)
    bench.relative(Distance=distance, Acceleration=1_000, Deceleration=1_000)
    bench.cycle()
    if is_possible:
        assert shown(bench.move) == {"Busy", "Active"}
    else:
        assert bench.move.outputs["ErrID"] == ErrorId.PTO_INVALID_PARAMETER
        assert bench.simple.outputs["PTOError"]
        assert bench.diagnosis() == 0x400000
        assert bench.segments == []


def velocity_after(bench: PtoBench, first: int, second: int, ms: int, after_ns: int) -> None:
    """Run at a velocity, ask for another within `ms`, and be `after_ns` behind that."""
    bench.run(Velocity=first, Acceleration=1_000)
    bench.until(lambda: shown(bench.velocity) == {"InVelocity"}, 10 * MS)
    bench.run(Velocity=second, Acceleration=ms, Deceleration=ms)
    bench.cycle(after_ns)


# Two velocities, ramp in ms, fe, ms of the stop; frequency at its beginning, seconds, pulses (digest 9.6).  A stop
# begins at the end of the period that is under way.
STOPS = [
    pytest.param(20_000, None, 0, 0, 2_000, 20_000, 2.0, 20_000, id="case 1"),
    pytest.param(20_000, None, 0, 5_000, 3_000, 20_000, 3.0, 37_500, id="case 1, stop frequency"),
    pytest.param(10_000, 50_000, 20_000, 0, 10_000, 30_000, 6.0, 90_000, id="case 2, manual"),
    pytest.param(50_000, 10_000, 20_000, 0, 10_000, 30_000, 30.0, 450_000, id="case 3, manual"),
    pytest.param(5_000, None, 0, 0, 10_000, 5_000, 5.0, 12_500, id="floor"),
]


@pytest.mark.manual("SCU-051", "SCU-087", "SCU-089", "SCU-090")
@pytest.mark.parametrize(("first", "then", "ms", "stop_hz", "stop_ms", "frequency", "seconds", "pulses"), STOPS)
def test_a_stop_takes_the_time_of_its_case(
    first: int, then: int | None, ms: int, stop_hz: int, stop_ms: int, frequency: int, seconds: float, pulses: int
) -> None:
    bench = PtoBench(stop_frequency_hz=stop_hz)
    if then is None:
        bench.run(Velocity=first)
        bench.cycle(2 * S)
    else:
        velocity_after(bench, first, then, ms, ms * MS // 2)
    assert bench.frequency == pytest.approx(frequency, abs=1)
    before_ns, before = bench.now_ns, bench.sent
    bench.halt(Deceleration=stop_ms)
    bench.cycle()
    assert bench.channel.state is MotionState.STOPPING
    assert (bench.rest_ns() - before_ns) / S == pytest.approx(seconds, abs=1e-4 + 1.01 / frequency)
    assert bench.sent - before == pytest.approx(pulses, abs=3)
    bench.cycle()
    assert shown(bench.stop) == {"Done"}


@pytest.mark.manual("SCU-021", "SCU-052")
@pytest.mark.parametrize(("stop_hz", "last_hz"), [(2, 2), (0, 100)])
def test_the_last_pulse_of_a_stop_has_the_stop_frequency(stop_hz: int, last_hz: int) -> None:
    bench = PtoBench(ramp_unit="Hz/ms", ramps="periods", stop_frequency_hz=stop_hz)
    bench.run(Velocity=5_000)
    bench.cycle(S)
    bench.halt(Deceleration=20)
    rest_ns = bench.rest_ns()
    *_, (rise_ns, _), (fall_ns, _) = edges(bench.segments)
    assert rest_ns - rise_ns == pytest.approx(S / last_hz, abs=2)
    assert fall_ns - rise_ns == pytest.approx(S / last_hz / 2, abs=2)


@pytest.mark.manual("SCU-021")
@pytest.mark.parametrize("stop_hz", [0, 2, 700])
def test_a_smooth_ramp_ends_at_the_stop_frequency(stop_hz: int) -> None:
    bench = PtoBench(ramp_unit="Hz/ms", stop_frequency_hz=stop_hz)
    bench.run(Velocity=5_000)
    bench.cycle(S)
    bench.halt(Deceleration=20)
    rest_ns = bench.rest_ns()
    ramp = bench.segments[-2]
    assert float(ramp.frequency + ramp.rate * Fraction(rest_ns - ramp.start_ns, S)) == pytest.approx(stop_hz, abs=1e-3)


# Velocity, fe, time of the stop in ms, frequency at its beginning, seconds, pulses (digest 9.6, case 4).
STOPS_OF_MOVES = [(20_000, 0, 5_000, 8_000, 2.0, 8_000), (20_000, 1_000, 5_000, 12_000, 2.894737, 18_815)]


@pytest.mark.long
@pytest.mark.manual("SCU-039", "SCU-090")
@pytest.mark.parametrize(("velocity", "stop_hz", "stop_ms", "frequency", "seconds", "pulses"), STOPS_OF_MOVES)
@pytest.mark.parametrize("is_slowing_down", [False, True])
def test_a_stop_of_a_move_goes_by_its_velocity_in_every_phase(
    velocity: int, stop_hz: int, stop_ms: int, frequency: int, seconds: float, pulses: int, is_slowing_down: bool
) -> None:
    bench = PtoBench(stop_frequency_hz=stop_hz)
    bench.relative(Velocity=velocity, Distance=150_000, Acceleration=1_000, Deceleration=10_000)
    if is_slowing_down:
        bench.until(lambda: bench.frequency == velocity)
        bench.until(lambda: bench.frequency < frequency)
    else:
        bench.cycle(frequency * S // velocity)
    assert bench.frequency == pytest.approx(frequency, abs=25)
    before_ns, before = bench.now_ns, bench.sent
    bench.halt(Deceleration=stop_ms)
    assert (bench.rest_ns() - before_ns) / S == pytest.approx(seconds, abs=1e-2)
    assert bench.sent - before == pytest.approx(pulses, rel=5e-3)


@pytest.mark.manual("SCU-091")
def test_a_stop_in_hz_per_ms_follows_the_pin() -> None:
    bench = PtoBench(ramp_unit="Hz/ms")
    bench.run(Velocity=50_000, Acceleration=10)
    bench.cycle(S)
    assert bench.frequency == pytest.approx(10_000, abs=1)
    before_ns = bench.now_ns
    bench.halt(Deceleration=4)
    assert (bench.rest_ns() - before_ns) / S == pytest.approx(2.5, abs=4e-4)


# Settings, frequency in Hz, seconds, pulses (digest 9.7).
FAST_STOPS = [
    pytest.param({"fast_stop": 10_000}, 10_000, 2.0, 10_000, id="manual"),
    pytest.param({}, 50_000, 0.1, 2_500, id="default"),
    pytest.param({"fast_stop": 10_000, "stop_frequency_hz": 1_000}, 10_000, 1.8367, 10_102, id="stop frequency"),
    pytest.param({"fast_stop": 10_000, "maximum_frequency_hz": 5_000}, 5_000, 5.0, 12_500, id="floor"),
    pytest.param({"ramp_unit": "Hz/ms", "fast_stop": 20}, 20_000, 1.0, 10_000, id="Hz/ms"),
]


@pytest.mark.manual("SCU-016", "SCU-017", "SCU-088")
@pytest.mark.parametrize(("settings", "frequency", "seconds", "pulses"), FAST_STOPS)
def test_a_fast_stop_has_the_configured_rate(
    settings: dict[str, int | str], frequency: int, seconds: float, pulses: int
) -> None:
    bench = PtoBench(**settings)
    bench.run(Velocity=frequency)
    bench.until(lambda: shown(bench.velocity) == {"InVelocity"}, 10 * MS)
    before_ns, before = bench.now_ns, bench.sent
    bench.relative(Velocity=1_000 if frequency > 1_000 else 1, Distance=1_000)
    bench.cycle()
    assert shown(bench.velocity) == {"CommandAborted"}
    assert bench.move.outputs["ErrID"] == ErrorId.PTO_INVALID_PARAMETER
    assert bench.simple.outputs["PTOError"]
    assert bench.simple.outputs["Stopping"]
    assert (bench.rest_ns() - before_ns) / S == pytest.approx(seconds, abs=1e-4 + 1.01 / frequency)
    assert bench.sent - before == pytest.approx(pulses, abs=3)


@pytest.mark.manual("SCU-019", "SCU-018", "SCU-099")
@pytest.mark.parametrize(
    ("cap", "is_shutdown", "seconds"), [("shutdown", True, 6), ("shutdown", False, 50), ("all", False, 6)]
)
def test_a_fast_stop_of_a_shutdown_ends_after_six_seconds(cap: str, is_shutdown: bool, seconds: int) -> None:
    bench = PtoBench(fast_stop=49_999, fast_stop_cap=cap)
    bench.run(Velocity=50_000)
    bench.cycle(2 * S)
    if is_shutdown:
        bench.channel.shutdown(bench.now_ns)
    else:
        bench.channel.fail(bench.now_ns)
    before_ns = bench.now_ns
    bench.cycle(6 * S - MS)
    assert bench.frequency == pytest.approx(43_999.9, abs=2)
    assert bench.channel.state is MotionState.ERROR_STOP
    assert (bench.rest_ns() - before_ns) / S == pytest.approx(seconds, abs=2e-3)


@pytest.mark.manual("SCU-012", "SCU-093")
@pytest.mark.parametrize(("mode", "place"), [("pulse/direction", 1), ("direction/pulse", 0)])
@pytest.mark.parametrize("direction", [Direction.PTO_POSITIVE, Direction.PTO_NEGATIVE])
def test_the_direction_output_is_set_with_the_move_and_false_after_a_stop(
    mode: str, place: int, direction: Direction
) -> None:
    bench = PtoBench(output_mode=mode)
    bench.run(Direction=direction)
    assert bench.channel.levels_at(bench.now_ns)[place] == (direction is Direction.PTO_POSITIVE)
    assert bench.channel.levels_at(bench.now_ns)[1 - place] is True  # the first pulse has risen
    bench.cycle(100 * MS)
    bench.halt()
    bench.rest_ns()
    bench.cycle()
    assert bench.channel.levels_at(bench.now_ns) == (False, False)


def test_the_direction_output_keeps_its_level_after_a_move_and_may_be_inverted() -> None:
    for positive_level in (True, False):
        bench = PtoBench(positive_level=positive_level)
        bench.relative(Distance=10)
        bench.rest_ns()
        bench.cycle()
        assert bench.channel.levels_at(bench.now_ns) == (False, positive_level)


def test_the_current_direction_is_that_of_the_last_move() -> None:
    bench = PtoBench()
    for direction, position in ((Direction.PTO_NEGATIVE, -10), (Direction.PTO_CURRENT, -20)):
        bench.relative(Distance=10, Direction=direction)
        bench.rest_ns()
        bench.cycle()
        assert bench.channel.output.train.at(bench.now_ns) == position


@pytest.mark.manual("SCU-035", "SCU-050")
def test_the_longest_move_takes_a_handful_of_segments() -> None:
    bench = PtoBench()
    bench.relative(Distance=2**32 - 1, Velocity=50_000)
    bench.now_ns = 40_000 * S
    bench.cycle()
    assert bench.sent == bench.simple.outputs["Distance"] == 50_000 * 40_000 - 25_000 + 1  # and the one that has risen
    assert bench.rest_ns() == 85_900_345_900_000
    assert bench.sent == 2**32 - 1
    assert len(bench.segments) <= 6


@pytest.mark.parametrize("ramps", ["smooth", "periods"])
def test_a_stop_within_the_last_period_of_a_move_adds_no_pulse(ramps: str) -> None:
    bench = PtoBench(ramps=ramps, ramp_unit="Hz/ms")
    bench.relative(Velocity=20_000, Distance=1, Acceleration=2_000, Deceleration=2_000)
    bench.halt(Deceleration=1)
    assert bench.rest_ns() == 1_000_000
    bench.cycle()
    assert bench.sent == 1
    assert (shown(bench.move), shown(bench.stop)) == ({"Done"}, {"Done"})


@pytest.mark.manual("SCU-020", "SCU-046", "SCU-084")
def test_only_from_rest_a_ramp_in_periods_begins_at_its_own_frequency() -> None:
    bench = PtoBench(ramps="periods", ramp_unit="Hz/ms", start_frequency_hz=700)
    bench.run(Velocity=5_000)
    assert (bench.segments[-1].frequency, bench.segments[-1].count) == (700, 1)
    bench.cycle(S)
    bench.run(Velocity=10_000)
    bench.now_ns = bench.channel.next_ns
    bench.cycle()
    assert bench.segments[-1].frequency == 5_002  # (5000 + sqrt(5000^2 + 2 * 20000)) / 2, rounded up
