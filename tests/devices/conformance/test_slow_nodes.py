"""Nodes that answer late: no answer is taken for the answer to another request, and the report says what came late."""

import pytest
from broken_nodes import FAULTS, REQUEST, RESPONSE, Fault, Frames
from conform_bench import conformed, failures

from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.conformance.suite import Verdict


class Slow(Fault):
    """Answers to the requests in `which`, counted from 1, come so much later; each answer on its own."""

    which: range = range(0)
    delay_ms = 0

    def __init__(self) -> None:
        super().__init__()
        self._count = 0

    def to_node(self, frame: CanFrame) -> Frames:
        self._count += frame.identifier == REQUEST
        yield frame

    def from_node(self, frame: CanFrame) -> Frames:
        if frame.identifier == RESPONSE and self._count in self.which:
            self.say_after(self.delay_ms, frame)
        else:
            yield frame


@pytest.fixture
def slow(monkeypatch: pytest.MonkeyPatch) -> type[Slow]:
    monkeypatch.setitem(FAULTS, "Slow", Slow)
    monkeypatch.setattr(Slow, "which", range(0))
    return Slow


EVERY = range(1, 1_000_000)


@pytest.mark.parametrize("request_number", [900, 901, 905, 950])
@pytest.mark.parametrize("delay_ms", [600, 1400])
def test_one_late_answer_spoils_no_other_case(
    slow: type[Slow], monkeypatch: pytest.MonkeyPatch, request_number: int, delay_ms: int
) -> None:
    monkeypatch.setattr(Slow, "which", range(request_number, request_number + 1))
    monkeypatch.setattr(Slow, "delay_ms", delay_ms)
    report = conformed("SDO", "OD 01", "OD 03", fault="Slow")
    assert len(failures(report)) == 1
    notes = [note for result in report.results for note in result.notes]
    assert f"an answer came {delay_ms}" in notes[0]
    assert "the time-out was 500 ms and is" in notes[0]
    assert len(notes) <= 2, "besides the answer, at most the abort of a transfer that was left open"


@pytest.mark.parametrize("delay_ms", [100, 800, 950])
def test_node_that_is_always_slow_passes(slow: type[Slow], monkeypatch: pytest.MonkeyPatch, delay_ms: int) -> None:
    """The first time-out is 2 s, and later ones follow the node, whose own time-out is 1 s."""
    monkeypatch.setattr(Slow, "which", EVERY)
    monkeypatch.setattr(Slow, "delay_ms", delay_ms)
    assert failures(conformed("SDO 0*", "Emergency 0[1-3]", fault="Slow")) == {}


def test_node_that_grows_slow_is_waited_for(slow: type[Slow], monkeypatch: pytest.MonkeyPatch) -> None:
    """One case fails over the first late answer; from then on the time-out fits the node."""
    monkeypatch.setattr(Slow, "which", range(900, 1_000_000))
    monkeypatch.setattr(Slow, "delay_ms", 700)
    report = conformed("OD 01", "OD 03", "SDO", fault="Slow")
    assert len(report.of(Verdict.FAILED)) <= 1
    assert len(report.of(Verdict.PASSED)) >= 28
