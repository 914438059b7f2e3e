"""Nodes that answer late: no answer is mistaken for that to another request, and the report lists late answers."""

import random
from pathlib import Path
from typing import ClassVar

import pytest
from broken_nodes import FAULTS, REQUEST, RESPONSE, Fault, Frames
from canopen_bench import IO32, LEVEL_SENSOR
from conform_bench import conformed, failures

from fieldrig.clock import MS
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.conformance.report import Report
from fieldrig_devices.conformance.suite import Verdict


class Slow(Fault):
    """Delays the answers to the requests in `which`, counted from 1, by `delay_ms` each."""

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
    assert f"an answer arrived {delay_ms}" in notes[0]
    assert "the time-out was 500 ms and is" in notes[0]
    assert len(notes) <= 2, "besides the answer, at most the abort of a transfer that was left open"


@pytest.mark.parametrize("delay_ms", [100, 800, 950])
def test_node_that_is_always_slow_passes(slow: type[Slow], monkeypatch: pytest.MonkeyPatch, delay_ms: int) -> None:
    """The first time-out is 2 s, and later ones adapt to the node, whose own time-out is 1 s."""
    monkeypatch.setattr(Slow, "which", EVERY)
    monkeypatch.setattr(Slow, "delay_ms", delay_ms)
    assert failures(conformed("SDO 0*", "Emergency 0[1-3]", fault="Slow")) == {}


@pytest.mark.long
def test_node_that_grows_slow_is_waited_for(slow: type[Slow], monkeypatch: pytest.MonkeyPatch) -> None:
    """One case fails because of the first late answer; after that, the time-out fits the node."""
    monkeypatch.setattr(Slow, "which", range(900, 1_000_000))
    monkeypatch.setattr(Slow, "delay_ms", 700)
    report = conformed("OD 01", "OD 03", "SDO", fault="Slow")
    assert len(report.of(Verdict.FAILED)) <= 1
    assert len(report.of(Verdict.PASSED)) >= 28


class Busy(Fault):
    """A node on a busy host: everything that it sends is 100 to 400 ms late, in order, with varying delays."""

    random: ClassVar[random.Random]
    least_ms, most_ms = 100, 400

    def __init__(self) -> None:
        super().__init__()
        self._free_ns = 0

    def from_node(self, frame: CanFrame) -> Frames:
        now_ns = self.clock.now_ns()
        late_ns = now_ns + self.random.randint(self.least_ms * MS, self.most_ms * MS)
        self._free_ns = max(self._free_ns, late_ns)
        self.clock.call_at(self._free_ns, lambda: self.say(frame))
        yield from ()


class BusyAndSilent(Busy):
    """Sends no PDOs."""

    def from_node(self, frame: CanFrame) -> Frames:
        if not 0x180 <= frame.identifier < 0x580:
            yield from super().from_node(frame)


class BusyAndTooFast(Busy):
    """Sends each heartbeat, SYNC and TPDO twice, as if its timers ran at double speed."""

    def from_node(self, frame: CanFrame) -> Frames:
        yield from super().from_node(frame)
        if frame.identifier in (0x080, 0x185, 0x705):
            yield from super().from_node(frame)


def verdicts(report: Report) -> dict[str, tuple[str, str]]:
    return {result.case.number: (result.verdict.value, result.reason) for result in report.results}


def busy(monkeypatch: pytest.MonkeyPatch, cls: type[Busy], seed: int) -> str:
    monkeypatch.setitem(FAULTS, cls.__name__, cls)
    monkeypatch.setattr(Busy, "random", random.Random(seed), raising=False)
    return cls.__name__


@pytest.mark.parametrize("eds", [IO32, LEVEL_SENSOR], ids=lambda eds: eds.stem)
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.long
def test_no_verdict_depends_on_how_late_the_node_is(monkeypatch: pytest.MonkeyPatch, eds: Path, seed: int) -> None:
    late = conformed(eds=eds, fault=busy(monkeypatch, Busy, seed))
    assert verdicts(late) == verdicts(conformed(eds=eds))
    assert [note for result in late.results for note in result.notes] == []


@pytest.mark.parametrize(
    ("cls", "failing"),
    [
        (BusyAndSilent, {"3.3", "3.5", "3.6", "3.8", "6.3", "9.3"}),
        (BusyAndTooFast, {"3.5", "3.6", "3.8", "6.2", "6.6", "6.7", "7.102", "7.204", "9.1"}),
    ],
)
@pytest.mark.long
def test_faults_of_a_node_that_is_late_are_found_all_the_same(
    monkeypatch: pytest.MonkeyPatch, cls: type[Busy], failing: set[str]
) -> None:
    assert failing <= set(failures(conformed(fault=busy(monkeypatch, cls, 1))))
