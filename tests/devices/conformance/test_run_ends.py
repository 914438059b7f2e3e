"""A run ends whatever the node does: it never answers again, or it never comes to the end of a transfer."""

from typing import ClassVar

import pytest
from broken_nodes import FAULTS, NODE_ID, REQUEST, RESPONSE, Fault, Frames, sdo
from canopen_bench import IO32
from conform_bench import ALONE, HERE, rig_of

from fieldrig.clock import S
from fieldrig.config.rig_file import from_dict
from fieldrig.errors import RigError
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.conformance import sdo as sdo_client
from fieldrig_devices.conformance import sdo_block
from fieldrig_devices.conformance.description import Description
from fieldrig_devices.conformance.run import choose, conform_virtual
from fieldrig_devices.conformance.suite import Verdict

SNAPSHOT = 110
"""More requests than are made before the first case."""


class Dies(Fault):
    """Answers a number of requests, and then neither these nor anything else."""

    answers = 0

    def __init__(self) -> None:
        super().__init__()
        self._requests = 0

    def to_node(self, frame: CanFrame) -> Frames:
        self._requests += frame.identifier == REQUEST
        if self._requests <= self.answers:
            yield frame

    def from_node(self, frame: CanFrame) -> Frames:
        if self._requests <= self.answers:
            yield frame


class EndlessSegments(Fault):
    """Sends segments of an upload without an end; the size is announced, or not."""

    def from_node(self, frame: CanFrame) -> Frames:
        if frame.identifier == RESPONSE and self.request[0] & 0xE0 == 0x60:
            yield sdo(bytes((self.request[0] & 0x10,)) + b"endless")
        else:
            yield frame


class EndlessBlocks(Fault):
    """Sends blocks of an upload without an end."""

    def from_node(self, frame: CanFrame) -> Frames:
        data = frame.data
        if frame.identifier == RESPONSE and self.request[0] in (0xA2, 0xA3):
            for number in range(1, 128):
                yield sdo(bytes((number,)) + b"endless")
        elif frame.identifier == RESPONSE and data[0] & 0xF0 == 0xC0 and self.request[0] & 0xE0 != 0xA0:
            return
        else:
            yield frame


class AcknowledgesNothing(Fault):
    """Asks for the whole block of a download again and again."""

    is_open = False

    def to_node(self, frame: CanFrame) -> Frames:
        if frame.identifier == REQUEST and frame.data[0] & 0xE1 == 0xC0:
            self.is_open = True
        if frame.identifier == REQUEST and self.is_open and 0 < frame.data[0] & 0x7F < 0x41:
            if frame.data[0] & 0x80:
                self.answer(b"\xa2\x00\x7f")
        else:
            yield frame


class AnswersWithoutRequests(Fault):
    """Repeats each answer 499 times, so that there is always one before the next request."""

    def from_node(self, frame: CanFrame) -> Frames:
        yield frame
        if frame.identifier == RESPONSE:
            for ms in range(1, 500):
                self.say_after(ms, frame)


def ended(monkeypatch: pytest.MonkeyPatch, fault: type[Fault], *only: str) -> tuple[float, list[Verdict], list[str]]:
    """Return the seconds of the run in virtual time, the verdicts, and the notes."""
    monkeypatch.setitem(FAULTS, fault.__name__, fault)
    with Rig(from_dict(rig_of(IO32, fault.__name__), HERE)) as rig:
        report = conform_virtual(rig, "can0", Description(IO32, NODE_ID), choose(only), ALONE)
        return rig.now_ns / S, [result.verdict for result in report.results], list(report.notes)


@pytest.mark.parametrize("answers", [SNAPSHOT + 200, SNAPSHOT + 700])
def test_a_node_that_dies_fails_the_cases_that_remain_at_once(monkeypatch: pytest.MonkeyPatch, answers: int) -> None:
    monkeypatch.setattr(Dies, "answers", answers)
    seconds, verdicts, notes = ended(monkeypatch, Dies)
    assert len(verdicts) == len(choose(()))
    assert verdicts[-1] is Verdict.FAILED
    assert seconds < 100
    assert "has stopped answering in case" in notes[-1]


def test_a_node_that_dies_before_the_first_case_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Dies, "answers", 20)
    with pytest.raises(RigError, match="node 5 has stopped answering while its parameters were read"):
        ended(monkeypatch, Dies, "SDO 01")


@pytest.mark.parametrize(
    ("fault", "case"),
    [
        (EndlessSegments, "SDO 18"), (EndlessBlocks, "SDO 22"), (AcknowledgesNothing, "SDO 21"),
        (AnswersWithoutRequests, "SDO 01"),
    ],
)  # fmt: skip
def test_a_transfer_without_an_end_is_given_up(monkeypatch: pytest.MonkeyPatch, fault: type[Fault], case: str) -> None:
    monkeypatch.setattr(sdo_client, "LARGEST", 4096)
    monkeypatch.setattr(sdo_block, "LARGEST", 4096)
    seconds, verdicts, _ = ended(monkeypatch, fault, case)
    assert seconds < 100
    assert len(verdicts) == 1
    assert fault is AnswersWithoutRequests or verdicts == [Verdict.FAILED]


class NeverLast(Fault):
    """Answers each request after 100 ms, so that a case with all objects takes long."""

    delay_ms: ClassVar = 100

    def from_node(self, frame: CanFrame) -> Frames:
        if frame.identifier == RESPONSE:
            self.say_after(self.delay_ms, frame)
        else:
            yield frame


@pytest.mark.long
def test_a_case_that_takes_long_says_what_it_waits_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FAULTS, "NeverLast", NeverLast)
    told: list[str] = []
    with Rig(from_dict(rig_of(IO32, "NeverLast"), HERE)) as rig:
        eds = Description(IO32, NODE_ID)
        report = conform_virtual(rig, "can0", eds, choose(["OD 01", "OD 07"]), ALONE, on_progress=told.append)
        took_s = rig.now_ns / S
    assert report.of(Verdict.FAILED) == []
    assert any(text.startswith("reading the parameters to restore: ") for text in told)
    assert any(text.startswith("4.1 OD 01: ") and "the last one is reading " in text for text in told)
    assert len(told) <= took_s / 10


def test_a_short_run_says_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[str] = []
    with Rig(from_dict(rig_of(), HERE)) as rig:
        conform_virtual(rig, "can0", Description(IO32, NODE_ID), choose(["State"]), ALONE, on_progress=told.append)
    assert told == []
