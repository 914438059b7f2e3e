"""A pulse output and a pulse input: as many pulses are counted as sent, or the difference is known."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.signals.codec import check_sent
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.wires import Signal
from fieldrig_devices.pulses.output import EdgePlayer, PulseOutput
from fieldrig_devices.pulses.pulse_input import PulseInput


class Bench:
    """An output, and inputs that receive what it sends while they are connected."""

    def __init__(self, mode: Any = "segments") -> None:
        self.clock = VirtualClock()
        self.wires = RecordedLink[Signal]()
        self.output = PulseOutput(self.clock, self.wires, "pto.pulse", mode, "pto.direction")
        self.output.start()
        self.input = PulseInput(0)
        self.taken = 0
        self.take()

    def take(self) -> None:
        """Hand over what was sent."""
        for signal in self.wires.sent[self.taken :]:
            if signal.name == "pto.direction":
                self.input.is_reverse = not signal.value
            else:
                check_sent(signal)
                self.input.receive(signal, self.clock.now_ns())
        self.taken = len(self.wires.sent)

    def run(self, until_ns: int) -> None:
        while (next_ns := self.clock.next_ns()) is not None and next_ns <= until_ns:
            self.clock.advance_to(next_ns)
            self.take()
        self.clock.advance_to(until_ns)


@pytest.mark.parametrize("mode", ["segments", "edges"])
def test_a_trapezoid_arrives_with_each_pulse(mode: str) -> None:
    bench = Bench(mode)
    for frequency, rate, count in ((0, 100_000, 50), (3_162, 0, 100), (3_162, -99_000, 50)):
        bench.output.send(frequency, rate, count)
        bench.take()
        end_ns = bench.output.train.end_ns
        assert end_ns is not None
        bench.run(end_ns)
    bench.output.send(1_000, count=30, direction=-1)
    bench.take()
    bench.run(S)
    assert bench.input.received_at(S) == bench.output.train.sent_at(S) == 230
    assert bench.input.position_at(S) == 170
    assert bench.input.missed == bench.input.surplus == 0


def test_both_modes_count_the_same_at_each_edge() -> None:
    segments, edges = Bench(), Bench("edges")
    for bench in (segments, edges):
        bench.output.send(0, 1_000_000, 200)
        bench.take()
    for instant_ns, _ in segments.output.train.edges(0, S):
        edges.run(instant_ns)
        assert edges.input.position_at(instant_ns) == segments.input.position_at(instant_ns)
        assert edges.input.level_at(instant_ns) == segments.input.level_at(instant_ns)


def test_a_segment_that_is_sent_ahead_lets_the_one_before_end_in_both_modes() -> None:
    counted = []
    for mode in ("segments", "edges"):
        bench = Bench(mode)
        bench.output.send(1_000, count=None)
        bench.take()
        bench.run(3_700_000)
        bench.output.send(500, count=4, start_ns=5_250_000)
        bench.take()
        found = []
        for instant_ns in range(4 * MS, 20 * MS, 250_000):
            bench.run(instant_ns)
            found.append((bench.input.position_at(instant_ns), bench.input.level_at(instant_ns)))
        counted.append(found)
    assert counted[0] == counted[1]
    assert counted[0][-1] == (10, False)


def test_a_late_receiver_knows_what_it_missed() -> None:
    bench = Bench()
    bench.output.send(1_000, count=None)
    late = PulseInput(1_500_000)  # after the pulses at 0 and at 1 ms
    late.receive(bench.output.train, 1_500_000)
    assert (late.received_at(1_500_000), late.missed, late.missed_position) == (0, 2, 2)
    assert (late.received_at(4 * MS), late.sent_at(4 * MS)) == (3, 5)


def test_a_receiver_that_was_away_for_some_segments_shows_the_difference() -> None:
    bench = Bench()
    bench.clock.advance_to(MS)
    bench.output.send(1_000, count=10)
    bench.clock.advance_to(100 * MS)
    bench.output.send(1_000, count=5, direction=-1)
    bench.clock.advance_to(200 * MS)
    bench.input.receive(bench.output.send(), 200 * MS)
    assert (bench.input.received_at(S), bench.input.missed, bench.input.missed_position) == (0, 15, 5)
    assert bench.input.sent_at(S) == 15


def test_a_segment_that_ends_early_takes_back_what_did_not_come() -> None:
    bench = Bench()
    bench.output.send(1_000, count=100)
    bench.take()
    bench.clock.advance_to(50_500_000)
    assert bench.input.received_at(50_500_000) == 51
    bench.output.send()
    bench.take()
    assert bench.input.received_at(S) == bench.output.train.sent == 51
    assert bench.input.surplus == 0


def test_a_sender_that_starts_again_is_noticed() -> None:
    bench = Bench()
    bench.output.send(1_000, count=None)
    bench.take()
    bench.clock.advance_to(99_500_000)
    again = PulseOutput(bench.clock, bench.wires, "pto.pulse")
    again.start()
    again.send(1_000, count=7)
    bench.take()
    assert bench.input.restarts == 1
    assert bench.input.unconfirmed == 100
    assert bench.input.received_at(S) == 107
    assert bench.input.missed == 0


def test_a_repeated_segment_counts_once() -> None:
    bench = Bench()
    train = bench.output.send(1_000, count=9)
    for instant_ns in (0, 2 * MS, 20 * MS):
        bench.input.receive(train, instant_ns)
    assert bench.input.received_at(S) == 9


def test_cycles_of_pwm_count_as_pulses() -> None:
    counter = PulseInput(0)
    counter.receive(Pwm("pwm", 50, start_ns=0, frequency=1_000), 0)
    assert counter.received_at(9_999_999) == 10
    counter.receive(Pwm("pwm", 0, start_ns=10 * MS, frequency=1_000), 10 * MS)
    assert counter.received_at(S) == 10


def test_edges_of_pwm_at_their_instants() -> None:
    clock, wires = VirtualClock(), RecordedLink[Signal]()
    player = EdgePlayer(clock, wires, "pwm")
    player.play(Pwm("pwm", 25, start_ns=0, frequency=1_000))
    clock.advance_to(1_100_000)
    assert [signal.value for signal in wires.sent] == [True, False, True]
    player.play(Pwm("pwm", 100, start_ns=1_100_000, frequency=1_000))
    player.play(Pwm("pwm", 0, start_ns=1_100_000, frequency=1_000))
    clock.advance_to(S)
    assert [signal.value for signal in wires.sent] == [True, False, True, False]


STEPS = st.tuples(
    st.integers(1, 100_000),  # frequency
    st.none() | st.integers(0, 3_000),  # count
    st.sampled_from((1, -1)),
    st.integers(1, 20 * MS),  # until the next one
    st.booleans(),  # whether it goes on within the period
    st.booleans(),  # whether it arrives
)


@given(st.lists(STEPS, max_size=8), st.integers(0, 30 * MS), st.integers(0, 3))
def test_the_account_always_closes(steps: list[Any], on_ns: int, delay_ms: int) -> None:
    """Whatever arrives, with or without delay, and whenever the input is switched on."""
    now_ns, counter = 0, PulseInput(on_ns)
    train = PulseTrain("p", 0)
    for frequency, count, direction, ahead_ns, is_smooth, arrives in steps:
        phase = train.phase_at(now_ns) if is_smooth else 0
        train = train.then(now_ns, frequency, count=count, direction=direction, phase=phase)
        if arrives and now_ns + delay_ms * MS >= on_ns:
            counter.receive(train, now_ns + delay_ms * MS)
        now_ns += ahead_ns
    now_ns = max(now_ns, on_ns) + delay_ms * MS
    rest = train.then(now_ns)
    counter.receive(rest, now_ns)
    assert counter.sent_at(now_ns) == rest.sent
    assert counter.position_at(now_ns) + counter.missed_position == rest.value
    assert counter.received_at(now_ns) >= 0
