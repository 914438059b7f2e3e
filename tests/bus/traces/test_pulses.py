"""Pulse trains and PWM as waveforms: each edge in a VCD file at its instant, as vcdvcd reads it, and in a picture."""

import io
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from vcd_reader import VCDVCD

from fieldrig.clock import MS, S
from fieldrig.errors import UsageError
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.signals.codec import encode
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.traces import vcd
from fieldrig_bus.traces.timing_diagram import RIGHT, Window, steps_in
from fieldrig_bus.traces.waves import waves_of
from fieldrig_bus.wires import Signal

DAY_NS = 1_700_000_000_123_456_789


def entry(time_ns: int, signal: Signal) -> TraceEntry:
    return TraceEntry(time_ns, "wires", "wires", "pto", encode(signal))


def read_back(*entries: TraceEntry, name: str) -> list[tuple[int, str]]:
    """The changes of a wire, as another library reads them, without the unknown value at the beginning."""
    file = io.BytesIO()
    vcd.write(entries, file, 0)
    found: Any = VCDVCD(vcd_string=file.getvalue().decode("ascii"))
    return [change for change in found[f"wires.{name}"].tv if change[1] != "x"]


def test_a_train_has_each_edge_at_its_nanosecond() -> None:
    train = PulseTrain("p", 0, start_ns=7, frequency=50_000, count=3)
    assert read_back(entry(7, train), name="p") == [
        (7, "1"), (10_007, "0"), (20_007, "1"), (30_007, "0"), (40_007, "1"), (50_007, "0"),
    ]  # fmt: skip


def test_a_train_that_another_one_cuts_short() -> None:
    first = PulseTrain("p", 0, frequency=1_000, count=None)
    second = first.then(1_250_000, 2_000, count=1)
    assert read_back(entry(0, first), entry(1_250_000, second), name="p") == [
        (0, "1"), (500_000, "0"), (1_000_000, "1"), (1_500_000, "0"),
    ]  # fmt: skip


def test_pwm_and_a_digital_output_on_one_wire() -> None:
    signals = [(0, Signal("p", False)), (5, Pwm("p", 25, start_ns=5, frequency=1_000_000)), (1_405, Signal("p", False))]
    assert read_back(*(entry(*signal) for signal in signals), name="p") == [
        (0, "0"), (5, "1"), (255, "0"), (1_005, "1"), (1_255, "0"),
    ]  # fmt: skip


def test_a_trace_of_real_time_is_placed_by_its_messages() -> None:
    first = PulseTrain("p", 0, start_ns=1_000_000, frequency=1_000, count=2)
    second = first.then(11_000_000, 1_000, count=1)
    entries = [entry(DAY_NS + 30_000, first), entry(DAY_NS + 10 * MS, second)]
    assert read_back(*entries, name="p") == [
        (0, "1"), (470_000, "0"), (970_000, "1"), (1_470_000, "0"), (9_970_000, "1"), (10_470_000, "0"),
    ]  # fmt: skip


def test_the_value_of_a_train_among_numbers_is_its_position() -> None:
    train = PulseTrain("p", 3, start_ns=5, frequency=1_000, count=2, sent=3)
    found = waves_of([entry(0, Signal("p", 1.5)), entry(5, train)])
    assert list(found.waves[0].values(0, S)) == [(0, 1.5), (5, 3)]


def test_a_very_long_train_is_refused_at_once() -> None:
    train = PulseTrain("p", 0, frequency=10_000_000, count=None)
    with pytest.raises(UsageError, match="edges; expected at most"):
        read_back(entry(0, train), entry(10**15, Signal("other", 1)), name="p")


def test_a_picture_shows_the_pulses_of_its_window() -> None:
    (wave,) = waves_of([entry(0, PulseTrain("p", 0, frequency=1_000, count=None))]).waves
    assert steps_in(wave, Window(1_250_000, 2_250_000)) == [
        (0.0, True), (RIGHT / 4, False), (RIGHT * 3 / 4, True),
    ]  # fmt: skip


@given(st.lists(st.tuples(st.integers(1, 10**6), st.integers(0, 50), st.integers(0, 10**7)), min_size=1, max_size=5))
def test_a_file_has_as_many_rising_edges_as_pulses_were_sent(segments: list[tuple[int, int, int]]) -> None:
    train, entries, now_ns = PulseTrain("p", 0), [], 0
    for frequency, count, ahead_ns in segments:
        train = train.then(now_ns, frequency, count=count)
        entries.append(entry(now_ns, train))
        now_ns = max(train.end_ns or 0, now_ns) + ahead_ns
    rest = train.then(now_ns)
    changes = read_back(*entries, entry(now_ns, rest), name="p")
    assert sum(value == "1" for _, value in changes) == rest.sent
    assert changes == sorted(changes, key=lambda change: change[0])
