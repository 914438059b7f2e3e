"""The trace of a program: samples, trigger, and limits."""

import pytest

from fieldrig_devices.languages.debugging.recorder import Edge, Recorder, RecorderState, Trigger


def record(recorder: Recorder, values: list[float]) -> None:
    for cycle, value in enumerate(values):
        recorder.take(cycle * 10, [value])


def test_without_a_trigger_the_latest_samples_are_kept() -> None:
    recorder = Recorder(1, depth=3)
    record(recorder, [1, 2, 3, 4, 5])
    assert recorder.samples() == [(20, (3,)), (30, (4,)), (40, (5,))]
    assert recorder.taken == 5
    assert recorder.samples(after=4) == [(40, (5,))]
    assert recorder.samples(after=5) == []


def test_every_second_cycle() -> None:
    recorder = Recorder(1, every=2)
    record(recorder, [1, 2, 3, 4, 5])
    assert [values for _, values in recorder.samples()] == [(1,), (3,), (5,)]


@pytest.mark.parametrize(
    ("edge", "kept", "at_ns"),
    [
        (Edge.RISING, [0, 3, 4, 1], 10),
        (Edge.FALLING, [4, 1, 5, 0], 30),
        (Edge.ANY, [0, 3, 4, 1], 10),
    ],
)
def test_a_trigger_keeps_samples_before_it_and_stops_when_full(edge: Edge, kept: list[float], at_ns: int) -> None:
    recorder = Recorder(1, depth=4, trigger=Trigger(0, edge, level=2.0, before=1))
    record(recorder, [0, 3, 4, 1, 5, 0, 9, 9])
    assert [values[0] for _, values in recorder.samples()] == kept
    assert recorder.state is RecorderState.FULL
    assert recorder.triggered_ns == at_ns


def test_a_value_that_is_above_from_the_start_is_no_edge() -> None:
    recorder = Recorder(1, depth=4, trigger=Trigger(0, Edge.RISING, level=2.0))
    record(recorder, [5, 5, 5])
    assert recorder.state is RecorderState.WAITING
    assert recorder.samples() == []


@pytest.mark.parametrize(
    ("count", "every", "depth", "before", "expected"),
    [
        (0, 1, 10, 0, "expected 1 to 32 values"),
        (33, 1, 10, 0, "expected 1 to 32 values"),
        (1, 0, 10, 0, "expected a sample in every cycle"),
        (1, 1, 0, 0, "expected a depth of 1 to 100000"),
        (1, 1, 100_001, 0, "expected a depth of 1 to 100000"),
        (1, 1, 10, 10, "expected 0 to 9 samples before"),
    ],
)
def test_numbers_out_of_range_are_refused(count: int, every: int, depth: int, before: int, expected: str) -> None:
    trigger = Trigger(0, Edge.ANY, before=before)
    with pytest.raises(ValueError, match=expected):
        Recorder(count, every=every, depth=depth, trigger=trigger)


def test_a_value_that_is_gone_leaves_a_gap_and_is_no_edge() -> None:
    recorder = Recorder(1, depth=10, trigger=Trigger(1, Edge.RISING, level=3.5))
    for cycle, row in enumerate([(1, 1), (None, None), (3, 3), (None, None), (4, 10**400)]):
        recorder.take(cycle, row)
    assert (recorder.state, recorder.triggered_ns, recorder.samples()) == (RecorderState.RECORDING, 4, [(4, (4,))])
    plain = Recorder(1)
    plain.take(0, [None])
    assert plain.samples() == [(0, (None,))]
