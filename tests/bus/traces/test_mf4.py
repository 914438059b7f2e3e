"""MF4 files: what asammdf makes of them, and what happens without it or with damaged ones."""

import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import can  # noqa: F401  before asammdf, or its reader of MF4 does not work
import pytest
from asammdf import MDF

from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.recorder import Recorder
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read, write
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import CanFrame

pytestmark = pytest.mark.long

T = 1_700_000_000_123_000_000
FRAMES = [
    CanFrame(0x123, b"\x01\x02"),
    CanFrame(0x1ABCDEF0, bytes(range(12)), is_extended=True, is_fd=True, is_bit_rate_switched=True),
]
SENT = [TraceEntry(T + n * 1_000_000, f"can{n}", "can", "", encode(frame)) for n, frame in enumerate(FRAMES)]


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    write(SENT, tmp_path / "x.mf4")
    return tmp_path / "x.mf4"


def test_asammdf_finds_the_frames_as_bus_logging(recording: Path) -> None:
    with MDF(recording) as mdf:
        found: Any = mdf.get("CAN_DataFrame", 0)
        assert round(mdf.header.start_time.timestamp(), 6) == 1_700_000_000.123
        assert found.timestamps.tolist() == [0.0, 0.001]
        assert found.samples["CAN_DataFrame.ID"].tolist() == [0x123, 0x1ABCDEF0]
        assert found.samples["CAN_DataFrame.DLC"].tolist() == [2, 9]
        assert found.samples["CAN_DataFrame.EDL"].tolist() == [0, 1]
        assert found.samples["CAN_DataFrame.DataBytes"][1][:12].tolist() == list(range(12))
        assert [int(channel) for channel in mdf.bus_logging_map["CAN"]] == [0, 1]


def test_the_extra_is_named_where_it_is_missing(recording: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "asammdf", None)
    target = recording.with_name("y.mf4")
    for call in (lambda: list(read(recording)), lambda: write(SENT, target), lambda: Recorder(target)):
        with pytest.raises(UsageError, match="MF4 needs the package asammdf") as refused:
            call()
        assert refused.value.remedy == "pip install 'fieldrig[mf4]'"


def test_a_damaged_file_is_refused_or_read(recording: Path) -> None:
    data = recording.read_bytes()
    for size in range(80, len(data), 997):
        recording.write_bytes(data[:size])
        with suppress(UsageError):
            list(read(recording))
    recording.write_bytes(data)
    assert list(read(recording, odd=Oddities())) == SENT


def test_a_recording_of_other_things_has_no_messages(tmp_path: Path) -> None:
    import numpy
    from asammdf import Signal

    path, odd = tmp_path / "other.mf4", Oddities()
    with MDF() as mdf:
        mdf.append(Signal(samples=numpy.array([1.0]), timestamps=numpy.array([0.0]), name="level"))
        mdf.save(path)
    assert list(read(path, odd=odd)) == []
    assert [oddity.what for oddity in odd] == ["groups that are no CAN frames are left out"]
