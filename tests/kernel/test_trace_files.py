"""Traces in files: our own format, those of others by the ending, and what was missed."""

import io
import json
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig import trace_jsonl
from fieldrig.errors import RigError
from fieldrig.trace import TraceEntry
from fieldrig.trace_files import Recorder, read, write

ENTRIES = st.builds(
    TraceEntry,
    time_ns=st.integers(0, 2**63),
    bus=st.text(),
    family=st.text(),
    sender=st.text(),
    data=st.binary(max_size=64),
)


@given(st.lists(ENTRIES))
@settings(max_examples=50, deadline=None)
def test_every_message_comes_back(entries: list[TraceEntry]) -> None:
    file = io.BytesIO()
    assert trace_jsonl.write(entries, file, 0) == len(entries)
    file.seek(0)
    assert list(trace_jsonl.read(file)) == entries


@given(st.binary())
@settings(max_examples=200, deadline=None)
def test_no_bytes_do_more_than_be_refused(data: bytes) -> None:
    with suppress(RigError):
        list(trace_jsonl.read(io.BytesIO(data)))


@pytest.mark.parametrize("line", [b"\xff", b"[", b"{}", b'{"time_ns":"1"}', b"[" * 100_000])
def test_a_line_that_is_no_message_is_named(line: bytes) -> None:
    good = io.BytesIO()
    trace_jsonl.write([TraceEntry(5, "can0", "can", "io", b"")], good, 0)
    with pytest.raises(RigError, match="line 2 is no message of a trace"):
        list(trace_jsonl.read(io.BytesIO(good.getvalue() + line)))


def test_a_line_is_as_documented() -> None:
    file = io.BytesIO()
    trace_jsonl.write([TraceEntry(5, "can0", "can", "io", bytes.fromhex("0501"))], file, 1_000)
    assert json.loads(file.getvalue()) == {
        "time_ns": 1005,
        "bus": "can0",
        "family": "can",
        "sender": "io",
        "data": "0501",
    }


def test_an_unknown_ending_is_refused_with_those_that_are_known(tmp_path: Path) -> None:
    with pytest.raises(RigError, match="no format of traces ends in") as refused:
        write([], tmp_path / "x.doc")
    assert ".jsonl" in refused.value.remedy
    with pytest.raises(RigError, match="can't be read"):
        list(read(tmp_path / "missing.jsonl"))


def batch(first: int, *data: str) -> dict[str, object]:
    entries = [[10 + index, "tank", one] for index, one in enumerate(data)]
    return {"family": "wires", "process": "w", "first": first, "epoch_ns": 100, "entries": entries}


def test_a_recorder_writes_the_time_of_day_and_counts_what_it_missed(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "x.jsonl")
    recorder.take("wires", batch(7, "01", "02"))
    recorder.take("wires", batch(12, "03"))
    assert recorder.close() == f"{tmp_path}/x.jsonl: 3 messages; 3 were lost: this computer is too slow"
    assert [(entry.time_ns, entry.data.hex()) for entry in read(tmp_path / "x.jsonl")] == [
        (110, "01"),
        (111, "02"),
        (110, "03"),
    ]


def test_a_recorder_takes_no_more_than_it_was_asked_for(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "x.jsonl", most=3)
    recorder.take("wires", batch(0, "01", "02"))
    assert recorder.taken == 2
    recorder.take("wires", batch(2, "03", "04", "05"))
    assert recorder.is_full
    assert recorder.close() == f"{tmp_path}/x.jsonl: 3 messages"


def test_a_format_says_what_it_does_not_know(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "x.log")  # candump: CAN only
    recorder.take("wires", batch(0, "01"))
    assert "0 messages; 1 are of kinds that this format doesn't know" in recorder.close()
