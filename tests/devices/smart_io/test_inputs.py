"""Inputs: the scan with PERIOD and DEBOUNCE, digital inputs, counters, and events only when something changes."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from smart_io_bench import SmartIoBench

from fieldrig.clock import MS
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_devices.pamring.frames import CounterItem, InputChanged, InputItem


@pytest.mark.manual("PAML-082")
@pytest.mark.manual("PAML-083")
def test_a_level_is_accepted_after_debounce_samples_of_the_period() -> None:
    bench = SmartIoBench()
    bench.configure(InputItem(7, 103, 1, True, 20, 3))
    bench.run(5)
    bench.wire("button", True)  # samples at 20, 40 and 60 ms
    bench.run(54.9)
    assert bench.inputs() == []
    bench.run(0.1)
    assert bench.inputs() == [(7, 1)]


@pytest.mark.manual("PAML-083")
def test_a_bounce_begins_the_count_again() -> None:
    bench = SmartIoBench()
    bench.configure(InputItem(7, 103, 1, True, 10, 2))
    bench.wire("button", True)  # counted at 10 ms
    bench.run(15)
    bench.wire("button", False)  # not at 20 ms
    bench.run(10)
    bench.wire("button", True)  # counted at 30 and 40 ms
    bench.run(14)
    assert bench.inputs() == []
    bench.run(1)
    assert bench.inputs() == [(7, 1)]


def test_a_pulse_between_two_samples_is_not_seen() -> None:
    bench = SmartIoBench()
    bench.configure(InputItem(7, 103, 1, True, 10, 1))
    bench.run(1)
    bench.wire("button", True)
    bench.run(5)
    bench.wire("button", False)
    bench.run(20)
    assert bench.inputs() == []


@pytest.mark.manual("PAML-080")
@pytest.mark.manual("PAML-084")
def test_each_input_reports_its_first_value_when_the_node_begins_to_run() -> None:
    bench = SmartIoBench()
    bench.wire("button", True)
    bench.program.attach(bench.port)
    bench.program.forget()
    assert bench.program.accept(InputItem(7, 103, 1, True, 20, 2))
    assert bench.program.accept(InputItem(8, 104, 1, True, 20, 2))
    assert bench.port.take() == []
    bench.program.run()
    assert bench.port.take() == [InputChanged(7, 1), InputChanged(8, 0)]


@pytest.mark.manual("PAML-081")
@pytest.mark.parametrize("is_active_high", [True, False])
def test_the_bits_are_levels_whatever_active_says(is_active_high: bool) -> None:
    bench = SmartIoBench()
    bench.configure(InputItem(7, 103, 1, is_active_high, 1, 1))
    bench.wire("button", True)
    bench.run(1)
    assert bench.inputs() == [(7, 1)]


@pytest.mark.manual("PAML-085")
@pytest.mark.manual("PAMS-111")
def test_a_digital_input_of_5_bits_at_208_is_in_7_to_in_11_of_module_2_with_the_lowest_address_as_bit_0() -> None:
    bench = SmartIoBench(terminals={})
    bench.configure(InputItem(7, 208, 5, True, 1, 1))
    for address, value in ((208, 0b00001), (212, 0b10001), (210, 0b10101)):
        bench.set(f"in{address}", True)
        bench.run(1)
        assert bench.inputs() == [(7, value)]
    for address in (209, 211):
        bench.set(f"in{address}", True)
    bench.run(1)
    assert bench.inputs() == [(7, 31)], "bits of one sample are one event"


@pytest.mark.manual("PAML-086")
@pytest.mark.parametrize(("is_active_high", "counted"), [(True, [1, 2]), (False, [1])])
def test_a_counter_counts_edges_to_the_active_level(is_active_high: bool, counted: list[int]) -> None:
    bench = SmartIoBench()
    bench.configure(CounterItem(7, 101, is_active_high, 1, 1))
    for level in (True, False, True):
        bench.wire("motor.pulse", level)
        bench.run(3)
    assert bench.inputs() == [(7, count) for count in counted]


@pytest.mark.manual("PAML-093")
def test_nothing_is_reported_or_computed_while_nothing_changes() -> None:
    bench = SmartIoBench()
    bench.configure(InputItem(7, 103, 1, True, 1, 5), CounterItem(8, 101, True, 1, 1))
    bench.wire("button", False)
    for _ in range(100):
        bench.program.cycle()
    assert bench.clock.next_ns() is None
    assert bench.port.take() == []


def test_an_input_with_a_pwm_signal_is_sampled_while_it_changes() -> None:
    bench = SmartIoBench()
    bench.configure(CounterItem(7, 101, True, 1, 1))
    bench.wires.deliver(Pwm("motor.pulse", 50, "%", 0, 100))
    bench.run(95)
    assert bench.inputs()[-1] == (7, 10)
    bench.wires.deliver(Pwm("motor.pulse", 0, "%", 95 * MS, 100))
    bench.run(10)
    bench.port.take()
    assert bench.clock.next_ns() is None


def polled(edges: list[tuple[int, bool]], period: int, debounce: int, until: int) -> list[tuple[int, bool]]:
    """The levels that a scan that never rests accepts, with their instants; an edge comes before a sample."""
    accepted, count, found = False, 0, []
    for now in range(period, until + 1, period):
        level = next((value for at, value in reversed(edges) if at <= now), False)
        count = count + 1 if level is not accepted else 0
        if count >= debounce:
            accepted, count = level, 0
            found.append((now, accepted))
    return found


@pytest.mark.long
@given(
    edges=st.lists(st.tuples(st.integers(1, 200), st.booleans()), max_size=30, unique_by=lambda edge: edge[0]),
    period=st.integers(1, 20),
    debounce=st.integers(1, 5),
)
def test_sampling_only_after_edges_equals_a_scan_that_never_rests(
    edges: list[tuple[int, bool]], period: int, debounce: int
) -> None:
    bench = SmartIoBench(keyboard="none", modules={1: {}}, terminals={})
    bench.configure(InputItem(7, 103, 1, True, period, debounce))
    found: list[tuple[int, bool]] = []
    at_ms: dict[int, Any] = dict(edges)
    for now in range(1, 301):
        if now in at_ms:
            bench.clock.advance_to(now * MS - 1)
            found += [(now - 1, bool(value)) for _, value in bench.inputs()]
            bench.clock.instant_ns = now * MS  # the edge comes first at its instant
            bench.set("in103", at_ms[now])
        bench.clock.advance_to(now * MS)
        found += [(now, bool(value)) for _, value in bench.inputs()]
    assert found == polled(sorted(edges), period, debounce, 300)


def one_pulse(number: int, start_ns: int, frequency: int = 100) -> PulseTrain:
    return PulseTrain("motor.pulse", number, start_ns=start_ns, frequency=frequency, count=1, sent=number)


@pytest.mark.long
@pytest.mark.manual("PAML-086")
@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.integers(10, 40), st.integers(0, 60)), min_size=1, max_size=20), st.booleans())
def test_pulses_count_however_late_their_messages_are(pulses: list[tuple[int, int]], is_active_high: bool) -> None:
    bench = SmartIoBench()
    bench.wires.deliver(PulseTrain("motor.pulse", 0))
    bench.configure(CounterItem(7, 101, is_active_high, 1, 3))
    start_ns = 0
    for number, (distance_ms, delay_ms) in enumerate(pulses):
        start_ns += distance_ms * MS
        due_ns = max(start_ns + delay_ms * MS, bench.clock.now_ns())
        bench.clock.advance_to(due_ns)
        bench.wires.deliver(one_pulse(number, start_ns))
    bench.run(50)
    assert bench.inputs()[-1] == (7, len(pulses))
    assert bench.clock.next_ns() is None, "a node at rest computes nothing"


def test_a_train_that_began_long_ago_costs_no_more_than_a_second_of_samples() -> None:
    bench = SmartIoBench()
    bench.configure(CounterItem(7, 101, True, 1, 1))
    bench.clock.advance_to(3_600_000 * MS)
    bench.wires.deliver(PulseTrain("motor.pulse", 0, frequency=100, count=None))
    bench.run(20)
    assert 100 <= bench.inputs()[-1][1] <= 103


@pytest.mark.manual("PAML-083")
def test_late_pulses_are_not_longer_than_others() -> None:
    bench = SmartIoBench()
    bench.configure(CounterItem(7, 101, True, 1, 6))
    bench.run(200)
    bench.wires.deliver(one_pulse(0, 100 * MS))  # high for 5 ms, and DEBOUNCE is 6
    bench.run(50)
    assert bench.inputs() == []
