"""Counter inputs: up, down, preset, wrapping, and the edges of an incremental encoder."""

from typing import Any, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS, S
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.pulses.counter import Counter, IncrementalInput

FORWARDS = [("a", True), ("b", True), ("a", False), ("b", False)]
"""A period of an encoder that turns forwards: A leads B by a quarter."""


def test_a_train_counts_up_and_down() -> None:
    counter = Counter("direction", 0)
    train = PulseTrain("p", 0, frequency=1_000, count=10)
    counter.receive("a", train, 0)
    assert counter.value_at(4_500_000) == 5
    counter.receive("a", train.then(20 * MS, 1_000, count=3, direction=-1), 20 * MS)
    assert (counter.value_at(S), counter.missed) == (7, 0)


def test_the_second_input_says_the_direction_of_edges_or_counts_down() -> None:
    for mode, value in (("direction", -2), ("up_down", 1)):
        counter = Counter(mode, 0)  # type: ignore[arg-type]
        counter.receive("b", Signal("b", False), 0)
        for level in (False, True, False, True):
            counter.receive("a", Signal("a", level), 1)
        if mode == "up_down":
            counter.receive("b", Signal("b", True), 2)
        assert counter.value_at(3) == value


def test_a_preset_is_loaded_in_the_middle_of_a_train() -> None:
    counter = Counter("direction", 0)
    counter.receive("a", PulseTrain("p", 0, frequency=1_000, count=None), 0)
    counter.load(-100, 9_999_999)
    assert counter.value_at(9_999_999) == -100
    assert counter.value_at(19_999_999) == -90
    assert counter.reaches_ns(0, 19_999_999) == 109 * MS
    assert counter.reaches_ns(-200, 19_999_999) is None
    assert counter.speed_at(S) == 1_000


def test_a_counter_of_16_bits_wraps() -> None:
    counter = Counter("direction", 0, bits=16)
    counter.load(32_767, 0)
    counter.receive("a", PulseTrain("p", 0, start_ns=1, frequency=1_000, count=1), 1)
    assert counter.value_at(1) == -32_768


@pytest.mark.parametrize(("multiplication", "forwards"), [(1, 1), (2, 2), (4, 4)])
def test_a_period_of_an_encoder(multiplication: Literal[1, 2, 4], forwards: int) -> None:
    encoder = IncrementalInput(0, multiplication)
    turn: list[Any] = [("a", False), ("b", False), *FORWARDS * 3]
    for which, level in turn:
        encoder.receive(which, Signal(which, level), 0)
    assert encoder.value_at(0) == 3 * forwards
    back = {True: False, False: True}
    for which, level in reversed(FORWARDS * 3):
        encoder.receive(which, Signal(which, back[level]), 0)  # type: ignore[arg-type]
    assert encoder.value_at(0) == 0


@given(st.lists(st.tuples(st.sampled_from(("a", "b")), st.booleans())))
def test_an_encoder_that_goes_forth_and_back_is_where_it_was(edges: list[tuple[Any, bool]]) -> None:
    encoder = IncrementalInput(0)
    levels = {"a": False, "b": False}
    for which in levels:
        encoder.receive(which, Signal(which, False), 0)  # type: ignore[arg-type]
    undo: list[tuple[Any, bool]] = []
    for which, level in edges:
        undo.append((which, levels[which]))
        levels[which] = level
        encoder.receive(which, Signal(which, level), 0)
    for which, level in reversed(undo):
        encoder.receive(which, Signal(which, level), 0)
    assert encoder.value_at(0) == 0


def test_an_encoder_as_a_motion_and_as_a_train() -> None:
    encoder = IncrementalInput(0)
    encoder.receive("a", Motion("x", 10.5, "count", 0, 1_000.0), 0)
    assert encoder.value_at(S) == 1_010
    encoder.load(5, S)
    assert encoder.value_at(S) == 5
    encoder = IncrementalInput(0)
    for which in ("a", "b"):
        encoder.receive(which, PulseTrain("x", 0, frequency=1_000, count=10, direction=-1), 0)
    assert encoder.value_at(S) == -40
