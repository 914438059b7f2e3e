"""Traces in files: our own format, those of others by the ending, and what was missed."""

import io
import json
import os
from contextlib import suppress
from errno import ENOSPC
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.errors import RigError
from fieldrig.storage import record_file
from fieldrig.storage.record_file import RecordFile
from fieldrig.traces import recorder as recording
from fieldrig.traces import trace_jsonl
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.recorder import Recorder
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read, write
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import CanFrame

ENTRIES = st.builds(
    TraceEntry,
    time_ns=st.integers(0, 2**63),
    bus=st.text(),
    family=st.text(),
    sender=st.text(),
    data=st.binary(max_size=64),
)


@pytest.mark.long
@given(st.lists(ENTRIES))
@settings(max_examples=50, deadline=None)
def test_every_message_comes_back(entries: list[TraceEntry]) -> None:
    file = io.BytesIO()
    assert trace_jsonl.write(entries, file, 0) == len(entries)
    file.seek(0)
    assert list(trace_jsonl.read(file)) == entries


@pytest.mark.long
@given(st.binary())
@settings(max_examples=200, deadline=None)
def test_no_bytes_do_more_than_be_refused(data: bytes) -> None:
    with suppress(RigError):
        list(trace_jsonl.read(io.BytesIO(data)))


@pytest.mark.parametrize("line", [b"\xff", b"[", b"{}", b'{"time_ns":"1"}', b"[" * 100_000])
def test_a_line_that_is_no_message_is_named(line: bytes) -> None:
    good = io.BytesIO()
    trace_jsonl.write([TraceEntry(5, "can0", "can", "io", b"")], good, 0)
    with pytest.raises(RigError, match="line 2 is not a message of a trace"):
        list(trace_jsonl.read(io.BytesIO(good.getvalue() + line + b"\n")))


def test_a_last_line_that_is_cut_off_is_left_out_and_told(tmp_path: Path) -> None:
    path, odd = tmp_path / "x.jsonl", Oddities()
    write([TraceEntry(5, "can0", "can", "io", b""), TraceEntry(6, "can0", "can", "io", b"")], path)
    path.write_bytes(path.read_bytes()[:-20])
    assert [entry.time_ns for entry in read(path, odd=odd)] == [5]
    assert [str(oddity) for oddity in odd] == ["line 2: the last line has no end, and may be cut off"]


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
    with pytest.raises(RigError, match="cannot be read"):
        list(read(tmp_path / "missing.jsonl"))


def batch(first: int, *data: str) -> dict[str, object]:
    entries = [[10 + index, "tank", entry] for index, entry in enumerate(data)]
    return {"family": "wires", "process": "w", "first": first, "epoch_ns": 100, "entries": entries}


def test_a_recorder_writes_the_time_of_day_and_counts_what_it_missed(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "x.jsonl")
    recorder.take("wires", batch(7, "01", "02"))
    recorder.take("wires", batch(12, "03"))
    assert recorder.close() == f"{tmp_path}/x.jsonl: 3 messages; 3 were lost: this host is too slow"
    assert [(entry.time_ns, entry.data.hex()) for entry in read(tmp_path / "x.jsonl")] == [
        (110, "01"),
        (111, "02"),
        (110, "03"),
    ]


def test_a_process_that_was_restarted_counts_anew_and_nothing_of_it_is_lost(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "x.jsonl")
    recorder.take("wires", batch(7, "01", "02"))
    recorder.take("wires", batch(0, "03"))
    recorder.take("wires", batch(1, "04"))
    assert recorder.close() == f"{tmp_path}/x.jsonl: 4 messages"
    assert recorder.is_whole


def went_back(backs: int, back_ns: int, *entries: tuple[int, str]) -> dict[str, object]:
    """Return the first batch of a rig in virtual time that went back."""
    rows = [[time_ns, "tank", data] for time_ns, data in entries]
    return {**batch(0), "epoch_ns": 0, "backs": backs, "back_ns": back_ns, "entries": rows}


@pytest.mark.parametrize("name", ["x.jsonl", "x.pcapng"])
def test_a_trace_goes_back_with_its_rig(tmp_path: Path, name: str) -> None:
    recorder = Recorder(tmp_path / name)
    recorder.take("wires", {**batch(0, "00", "01", "02", "03"), "epoch_ns": 0})  # at 10 to 13 ns
    recorder.take("wires", went_back(1, 12_000, (13_000, "aa"), (14_000, "bb")))
    recorder.take("wires", {**went_back(1, 12_000, (15_000, "cc")), "first": 2})
    recorder.take("other", went_back(1, 12_000, (15_000, "dd")))  # of the same time, so nothing more is removed
    recorder.take("wires", went_back(2, 13_500))
    recorder.take("wires", went_back(3, 13_000, (20_000, "ee")))
    assert recorder.close() == f"{tmp_path / name}: 6 messages"
    found = [(entry.time_ns, entry.data.hex()) for entry in read(tmp_path / name)]
    assert found == [(10, "00"), (11, "01"), (12, "02"), (13, "03"), (13_000, "aa"), (20_000, "ee")]
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize(
    "odd", [{"backs": "x", "back_ns": 1}, {"backs": 1}, {"back_ns": 1}, {"backs": [], "back_ns": 0}]
)
def test_a_batch_that_says_wrongly_how_its_rig_went_back_is_none(tmp_path: Path, odd: dict[str, object]) -> None:
    recorder = Recorder(tmp_path / "x.jsonl")
    recorder.take("wires", {**batch(0, "01"), **odd})
    assert recorder.close() == f"{tmp_path}/x.jsonl: 0 messages"


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
    assert "0 messages; 1 are of kinds that this format cannot hold" in recorder.close()


class Disk:
    """Replaces `os` in `record_file`: its files accept a number of bytes in total, and then no more."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, room: int) -> None:
        self.room = room
        self.is_roomy = False
        monkeypatch.setattr(record_file, "os", self)

    def __getattr__(self, name: str) -> Any:
        return getattr(os, name)

    def write(self, fd: int, data: bytes) -> int:
        if self.is_roomy:
            return os.write(fd, data)
        if self.room == 0:
            raise OSError(ENOSPC, "No space left on device")
        taken = os.write(fd, data[: self.room])
        self.room -= taken
        return taken

    def ftruncate(self, fd: int, length: int) -> None:
        self.room += os.fstat(fd).st_size - length
        os.ftruncate(fd, length)


@given(st.lists(st.tuples(st.binary(max_size=9), st.integers(0, 40)), max_size=20))
def test_a_file_of_records_holds_whole_records_whatever_the_disk_takes(records: list[tuple[bytes, int]]) -> None:
    with pytest.MonkeyPatch.context() as monkeypatch, TemporaryDirectory() as folder:
        path, disk = Path(folder) / "x", Disk(monkeypatch, 0)
        file = RecordFile(path)
        whole = [b""]
        for record, room in records:
            disk.room = room
            file.write(record)
            whole.append(whole[-1] + record)
            is_taken = file.put_out()
            assert path.read_bytes() == (whole[-1] if is_taken else path.read_bytes())
            assert path.read_bytes() in whole
            assert bool(file.trouble) is not is_taken
        disk.room = 1_000
        assert file.put_out()
        assert path.read_bytes() == whole[-1]
        file.close()


@pytest.mark.parametrize(("suffix", "size"), [(".jsonl", 90), (".log", 40), (".pcapng", 90)])
def test_a_trace_on_a_full_disk_ends_at_a_whole_message_and_goes_on_when_there_is_room(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    suffix: str,
    size: int,
) -> None:
    path, frame = tmp_path / f"x{suffix}", encode(CanFrame(0x123, b"\x01\x02")).hex()
    monkeypatch.setattr(recording, "FLUSH_S", 0.0)
    monkeypatch.setattr(recording, "CHUNK", 1)
    told = Event()
    monkeypatch.setattr(recording.log, "warning", lambda *_: told.set())
    disk = Disk(monkeypatch, 10 * size)
    recorder = Recorder(path)
    first = 0

    def take(count: int = 1) -> None:
        nonlocal first
        for _ in range(count):
            recorder.take("can0", {**batch(first, frame), "family": "can"})
            first += 1

    take(30)
    assert told.wait(60)  # it is full
    told.clear()
    disk.is_roomy = True
    assert told.wait(60)  # it goes on by itself
    take(5)
    words = recorder.close()
    kept = list(read(path))
    missing = int(words.partition(" messages; ")[2].partition(" are missing")[0])
    assert (len(kept) + missing, "No space left on device" in words) == (35, True)
    assert {entry.data.hex() for entry in kept} == {frame}


def test_a_trace_on_a_disk_that_stays_full_says_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    disk = Disk(monkeypatch, 0)
    recorder = Recorder(tmp_path / "x.jsonl")
    recorder.take("wires", batch(0, "01", "02"))
    assert recorder.close() == f"{tmp_path}/x.jsonl: 0 messages; 2 are missing: No space left on device"
    assert not recorder.is_whole
    assert (list(read(tmp_path / "x.jsonl")), disk.room) == ([], 0)


def test_a_format_that_writes_at_the_end_says_what_is_missing_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    level = b'["tank.level",0.5,"m"]'.hex()
    disk = Disk(monkeypatch, 0)
    recorder = Recorder(tmp_path / "x.vcd")
    recorder.take("wires", batch(0, level, level))
    assert recorder.close() == f"{tmp_path}/x.vcd: 0 messages; 2 are missing: No space left on device"
    disk.is_roomy = True
    recorder = Recorder(tmp_path / "x.vcd")
    recorder.take("wires", batch(0, level, level, "01"))
    assert recorder.close() == f"{tmp_path}/x.vcd: 2 messages; 1 are of kinds that this format cannot hold"


@pytest.mark.parametrize("suffix", [".blf", ".db"])
def test_a_format_that_is_complete_at_its_end_is_recorded_in_json_lines_beside_it(suffix: str, tmp_path: Path) -> None:
    path, frame = tmp_path / f"x{suffix}", encode(CanFrame(0x123, b"\x01\x02")).hex()
    recorder = Recorder(path)
    recorder.take("can0", {**batch(0, frame, frame), "family": "can"})
    recorder.take("wires", batch(0, "01"))
    assert recorder.close() == f"{path}: 2 messages; 1 are of kinds that this format cannot hold"
    assert [entry.data.hex() for entry in read(path)] == [frame, frame]
    assert [other.name for other in tmp_path.iterdir()] == [path.name]


def test_messages_stay_beside_a_file_that_cannot_be_made(tmp_path: Path) -> None:
    path, frame = tmp_path / "x.blf", encode(CanFrame(0x123, b"\x01\x02")).hex()
    recorder = Recorder(path)
    recorder.take("can0", {**batch(0, frame), "family": "can"})
    path.mkdir()
    with pytest.raises(RigError, match="cannot be written") as refused:
        recorder.close()
    assert str(tmp_path / "x.blf.jsonl") in refused.value.remedy
    assert len(list(read(tmp_path / "x.blf.jsonl"))) == 1
