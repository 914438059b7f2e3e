"""Replays with odd options and odd frames, of a log in which the nodes of the lab are started and then left alone."""

from pathlib import Path

import pytest
from recorded_logs import MS, recorded

from fieldrig import Rig, S
from fieldrig.errors import UsageError
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can import CanFrame
from fieldrig_bus.can.codec import encode
from fieldrig_devices.replay import replay

LAB = Path(__file__).parents[3] / "configs" / "lab.yaml"


def master(rig: Rig) -> None:
    can = rig.attach("plc").link("can0")
    rig.run_until(100 * MS)
    can.send(CanFrame(0, b"\x01\x00"))
    rig.run_for(2 * S)


@pytest.fixture(scope="module")
def lab() -> list[TraceEntry]:
    return recorded(LAB, master)


def test_a_rig_that_is_awaited_after_the_end_of_the_log_sends_nothing_more(lab: list[TraceEntry]) -> None:
    """A tolerance of 31 years ended after 31 years, and what the rig sent after the log was more than the log has."""
    for tolerance_ns in (5 * S, 10**9 * S):
        assert replay(lab, LAB, time_tolerance_ns=tolerance_ns).differences == []


def test_an_answer_has_to_be_awaited(lab: list[TraceEntry]) -> None:
    with pytest.raises(UsageError, match="an answer is awaited for less than 1 ms"):
        replay(lab, LAB, timeout_ns=0)


def test_frames_of_can_fd_are_played_and_compared_as_others_are(lab: list[TraceEntry]) -> None:
    """They were left out."""
    played_fd, expected_fd = (
        TraceEntry(1200 * MS, "can0", "can", "", encode(CanFrame(identifier, bytes(4), is_fd=True)))
        for identifier in (0x123, 0x185)
    )
    log = sorted([*lab, played_fd], key=lambda entry: entry.time_ns)
    result = replay(log, LAB)
    assert (result.played, result.left_out) == (replay(lab, LAB).played + 1, [])
    log = sorted([*lab, expected_fd], key=lambda entry: entry.time_ns)
    [only] = replay(log, LAB).differences
    assert "io did not send TPDO 1" in only.words


@pytest.mark.parametrize(
    ("side", "words"),
    [("id=zz", "an identifier in hexadecimal digits, got 'zz'"), ("node=x", "a whole number, got 'x'")],
)
def test_a_side_that_is_no_number_is_refused_in_words(side: str, words: str, lab: list[TraceEntry]) -> None:
    with pytest.raises(UsageError, match=words):
        replay(lab, LAB, play=[side])
