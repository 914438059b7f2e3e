"""Laws that hold for every legal move: count, duration, band, order of the edges, and what a stop leaves."""

import math
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import pytest
from hmiscu_bench import PtoBench, edges, shown
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fieldrig.clock import MS, S
from fieldrig_bus.signals.limits import check_pulse_train
from fieldrig_devices.pulses.pulse_input import PulseInput

RAMPS = ("smooth", "periods")


class Move(NamedTuple):
    unit: Literal["ms", "Hz/ms"]
    start: int
    stop: int
    velocity: int
    acceleration: int
    deceleration: int
    distance: int

    @property
    def settings(self) -> dict[str, Any]:
        return {"ramp_unit": self.unit, "start_frequency_hz": self.start, "stop_frequency_hz": self.stop}

    @property
    def inputs(self) -> dict[str, int]:
        return {
            "Velocity": self.velocity,
            "Distance": self.distance,
            "Acceleration": self.acceleration,
            "Deceleration": self.deceleration,
        }

    def rate(self, pin: int, end: int) -> float:
        """Return a rate by the manual's formulas, in Hz/s (manual 1811 to 1825, 1877)."""
        return max(pin * 1000 if self.unit == "Hz/ms" else (self.velocity - end) * 1000 / pin, 1000)


@st.composite
def moves(draw: st.DrawFn, most: int = 2**32 - 1) -> Move:
    unit: Literal["ms", "Hz/ms"] = draw(st.sampled_from(["ms", "Hz/ms"]))
    start, stop = (draw(st.one_of(st.just(0), st.integers(0, 50_000))) for _ in range(2))
    pin = st.integers(20, 49_999) if unit == "ms" else st.integers(1, 2_500)
    velocity = draw(st.integers(max(start, stop, 1), 50_000))
    distance = draw(st.one_of(st.integers(1, most), st.integers(1, min(most, 50_000))))
    return Move(unit, start, stop, velocity, draw(pin), draw(pin), distance)


def closed_form_s(move: Move) -> float | None:
    """Return the time of a move by the formulas of the manual (683 to 893) in floats; None if it has no profile."""
    up, down = move.rate(move.acceleration, move.start), move.rate(move.deceleration, move.stop)
    if move.distance <= 3:
        return move.distance / (move.stop or round(math.sqrt(down / 2)))
    calculated = [round(math.sqrt(rate / 2)) for rate, end in ((up, move.start), (down, move.stop)) if not end]
    if calculated and move.velocity <= max(calculated):
        return move.distance / move.velocity
    top = move.velocity
    least = (top**2 - move.start**2) / (2 * up) + (top**2 - move.stop**2) / (2 * down)
    if move.distance < least:
        square = (2 * up * down * move.distance + down * move.start**2 + up * move.stop**2) / (up + down)
        peak = math.sqrt(square)
        if peak <= max(move.start, move.stop) * (1 + 1e-12):
            return None
        return (peak - move.start) / up + (peak - move.stop) / down
    return (top - move.start) / up + (move.distance - least) / top + (top - move.stop) / down


def done(move: Move, **others: Any) -> PtoBench:
    """Carry out a legal move."""
    assume(closed_form_s(move) is not None)
    bench = PtoBench(**move.settings, **others)
    bench.relative(**move.inputs)
    bench.rest_ns()
    return bench


@pytest.mark.long
@pytest.mark.manual("SCU-041", "SCU-042", "SCU-043", "SCU-044", "SCU-045", "SCU-035")
@settings(max_examples=150, deadline=None)
@given(moves())
def test_every_move_sends_its_pulses_in_the_time_of_the_formulas(move: Move) -> None:
    bench = PtoBench(**move.settings)
    bench.relative(**move.inputs)
    expected = closed_form_s(move)
    if expected is None:
        assert shown(bench.move) == {"Error"}
        assert bench.segments == []
        return
    assert bench.rest_ns() / S == pytest.approx(expected, rel=1e-9, abs=1e-8)
    assert bench.sent == move.distance
    assert len(bench.segments) <= 6  # and the last one is at rest


@pytest.mark.long
@pytest.mark.parametrize("ramps", RAMPS)
@settings(max_examples=40, deadline=None)
@given(moves(most=2_000), st.floats(0, 1))
def test_a_receiver_of_the_segments_counts_what_was_sent(ramps: str, move: Move, part: float) -> None:
    seconds = closed_form_s(move)
    assume(seconds is not None)
    bench = PtoBench(**move.settings, ramps=ramps)
    counter = PulseInput(0)
    bench.relative(**move.inputs)
    bench.now_ns = int((seconds or 0) * part * S)
    bench.halt(Deceleration=move.deceleration)
    bench.rest_ns()
    for segment in bench.segments:
        check_pulse_train(segment)
        counter.receive(segment, segment.start_ns)
    assert counter.received_at(bench.now_ns) == bench.sent
    assert counter.missed == counter.surplus == 0


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(moves(most=3_000))
def test_a_move_in_periods_has_the_same_pulses_and_nearly_the_same_time(move: Move) -> None:
    bench = done(move, ramps="periods")
    seconds = closed_form_s(move)
    assert seconds is not None
    assert bench.sent == move.distance
    # The first and the last period are those of the end frequencies; all others are at most 1 Hz too fast.
    slowest = min(end or math.sqrt(1000 / 2) for end in (move.start, move.stop))
    assert bench.rest_ns() / S == pytest.approx(seconds, rel=0.03, abs=2 / slowest)


@pytest.mark.long
@pytest.mark.parametrize("ramps", RAMPS)
@settings(max_examples=60, deadline=None)
@given(moves(most=300))
def test_edges_are_in_order_and_no_period_leaves_the_band(ramps: str, move: Move) -> None:
    bench = done(move, ramps=ramps)
    found = edges(bench.segments)
    assert [is_high for _, is_high in found] == [True, False] * move.distance
    assert all(earlier < later for (earlier, _), (later, _) in pairwise(found))
    up, down = move.rate(move.acceleration, move.start), move.rate(move.deceleration, move.stop)
    ends = [end or round(math.sqrt(rate / 2)) for end, rate in ((move.start, up), (move.stop, down))]
    highest = ends[1] if move.distance <= 3 else move.velocity
    # A period in which the curve reaches its plateau may have begun at the low end: at most a quarter longer.
    lowest = 0.79 * min(*ends, move.velocity)
    rises = [instant for instant, is_high in found if is_high] + [bench.channel.output.train.start_ns]
    assert all(S / highest - 2 <= later - earlier <= S / lowest + 2 for earlier, later in pairwise(rises))


@pytest.mark.long
@pytest.mark.parametrize("ramps", RAMPS)
@settings(max_examples=40, deadline=None)
@given(moves(most=400), st.lists(st.floats(0, 1), min_size=1, max_size=5))
def test_the_count_at_any_instant_is_that_of_the_edges(ramps: str, move: Move, instants: list[float]) -> None:
    whole = done(move, ramps=ramps)
    rises = [instant for instant, is_high in edges(whole.segments) if is_high]
    end_ns = whole.channel.output.train.start_ns
    bench = PtoBench(**move.settings, ramps=ramps)
    bench.relative(**move.inputs)
    for part in sorted(instants):
        bench.now_ns = int(part * end_ns)
        bench.cycle()
        assert bench.sent == sum(1 for rise in rises if rise <= bench.now_ns)
        assert bench.simple.outputs["Distance"] == bench.sent


@pytest.mark.long
@pytest.mark.parametrize("ramps", RAMPS)
@pytest.mark.parametrize("how", ["stop", "fast stop"])
@settings(max_examples=40, deadline=None)
@given(moves(most=8_000), st.floats(0, 1))
def test_a_stop_at_any_instant_and_a_second_move_lose_no_pulse(ramps: str, how: str, move: Move, part: float) -> None:
    seconds = closed_form_s(move)
    assume(seconds is not None and seconds < 100)
    bench = PtoBench(**move.settings, ramps=ramps)
    bench.relative(**move.inputs)
    bench.now_ns = int((seconds or 0) * part * S)
    if how == "stop":
        bench.halt(Deceleration=move.deceleration)
    else:
        bench.channel.fail(bench.now_ns)
    bench.rest_ns()
    bench.release(bench.move)
    bench.release(bench.stop)
    bench.reset()
    missing = move.distance - bench.sent
    if missing > 0:  # a stop that is gentler than the move's own deceleration goes further
        rest = move._replace(distance=missing)
        assume(closed_form_s(rest) is not None)
        bench.relative(**rest.inputs)
        bench.rest_ns()
        assert bench.sent == move.distance
    found = edges(bench.segments)
    assert [is_high for _, is_high in found] == [True, False] * bench.sent
    assert all(earlier < later for (earlier, _), (later, _) in pairwise(found))


@pytest.mark.long
@pytest.mark.manual("SCU-046")
@pytest.mark.parametrize("ramps", RAMPS)
@settings(max_examples=20, deadline=None)
@given(st.lists(st.tuples(st.integers(1, 3_000), st.integers(20, 300), st.integers(0, 50)), min_size=1, max_size=4))
def test_velocities_follow_one_another_without_a_gap(ramps: str, changes: list[tuple[int, int, int]]) -> None:
    bench = PtoBench(ramps=ramps)
    for velocity, ramp_ms, after_ms in changes:
        bench.run(Velocity=velocity, Acceleration=ramp_ms, Deceleration=ramp_ms)
        while shown(bench.velocity) == {"Busy"}:
            bench.now_ns = bench.channel.next_ns
            bench.cycle()
        assert shown(bench.velocity) == {"InVelocity"}
        assert bench.frequency == velocity
        bench.cycle(after_ms * MS)
    bench.halt(Deceleration=1_000)
    bench.rest_ns()
    found = edges(bench.segments)
    rises = [instant for instant, is_high in found if is_high]
    assert len(rises) == bench.sent
    assert all(earlier < later for (earlier, _), (later, _) in pairwise(found))
    slowest = min(22, *(velocity for velocity, _, _ in changes))
    assert all(later - earlier <= 1.3 * S / slowest for earlier, later in pairwise(rises))


@pytest.mark.long
@pytest.mark.manual("SCU-046", "SCU-086", "SCU-089")
@settings(max_examples=100, deadline=None)
@given(st.integers(1, 50_000), st.integers(1, 50_000), st.integers(20, 49_999), st.floats(0, 1.5))
def test_a_change_of_the_velocity_follows_its_curve_to_the_pulse(first: int, second: int, ms: int, part: float) -> None:
    bench = PtoBench()
    bench.run(Velocity=first)
    while shown(bench.velocity) == {"Busy"}:
        bench.now_ns = bench.channel.next_ns
        bench.cycle()
    bench.run(Velocity=second, Acceleration=ms, Deceleration=ms)
    begin_ns = bench.channel.output.next_ns if first != second else bench.now_ns
    before = bench.channel.output.sent_at(begin_ns - 1)
    rate = max(abs(second - first) * 1000 / ms, 1000)
    ramp_s = abs(second - first) / rate
    bench.now_ns = max(bench.now_ns, begin_ns + int(part * ramp_s * S))
    bench.cycle()
    seconds = (bench.now_ns - begin_ns) / S
    on_ramp_s = min(seconds, ramp_s)
    signed = rate if second > first else -rate
    curve = first * on_ramp_s + signed * on_ramp_s**2 / 2 + second * (seconds - on_ramp_s)
    if first != second:
        # In the one period in which the ramp ends, pulses are only whole numbers at its two edges.
        assert abs(bench.sent - before - math.floor(curve + 1e-6) - 1) <= (0 if abs(curve - round(curve)) > 0.01 else 1)
