"""MF4 files: what asammdf makes of them, and what happens without it or with damaged ones."""

import struct
import sys
import tracemalloc
import zlib
from contextlib import suppress
from pathlib import Path
from typing import Any

import can  # before asammdf, or its reader of MF4 does not work
import numpy
import pytest
from asammdf import MDF, Signal
from asammdf.blocks.v4_blocks import ChannelConversion, SourceInformation
from asammdf.blocks.v4_constants import BUS_TYPE_CAN, SOURCE_BUS

from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.recorder import Recorder
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read, write
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import CanFrame

pytestmark = pytest.mark.long

MIB = 1 << 20
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


@pytest.mark.parametrize("kind", ["<u8", "<i8"])
def test_instants_that_are_whole_numbers_are_exact(tmp_path: Path, kind: str) -> None:
    """Other tools have whole nanoseconds and a factor, and a start with nanoseconds: floats would round them."""
    name, start_ns = "CAN_DataFrame", 1_700_000_000_123_456_789
    fields = [
        (f"{name}.{field}", form) for field, form in (("ID", "<u4"), ("DataLength", "u1"), ("DataBytes", "(8,)u1"))
    ]
    times_ns = [0, 1, 999_999_999, 10_000_000_000_000_001, 41_536_000_000_000_002]
    source = SourceInformation(source_type=SOURCE_BUS, bus_type=BUS_TYPE_CAN)
    with MDF(version="4.10") as mdf:
        samples = numpy.zeros(len(times_ns), dtype=fields)
        mdf.append(Signal(samples, numpy.array(times_ns, dtype=kind), name=name, source=source))
        mdf.groups[0].channels[mdf.masters_db[0]].conversion = ChannelConversion(conversion_type=1, a=1e-9, b=0.0)
        header: Any = mdf.header
        header.abs_time, header.time_flags = start_ns, 0
        mdf.save(tmp_path / "x.mf4")
    assert [entry.time_ns - start_ns for entry in read(tmp_path / "x.mf4")] == times_ns


def test_instants_that_are_decades_apart_are_written_exactly(tmp_path: Path) -> None:
    times_ns = [1_000_000_001, T, T + 1, T + 456_789]
    sent = [SENT[0]._replace(time_ns=time_ns) for time_ns in times_ns]
    write(sent, tmp_path / "x.mf4")
    assert list(read(tmp_path / "x.mf4")) == sent
    with can.MF4Reader(tmp_path / "x.mf4") as reader:
        assert [round(message.timestamp, 6) for message in reader] == [
            1.0,
            1_700_000_000.123,
            1_700_000_000.123,
            1_700_000_000.123457,
        ]


def test_a_long_file_needs_no_more_memory_than_a_short_one(tmp_path: Path) -> None:
    file = tmp_path / "long.mf4"
    peaks = []
    for count in (30_000, 120_000):
        write((SENT[0]._replace(time_ns=T + n * 100_000) for n in range(count)), file)
        tracemalloc.start()
        try:
            assert sum(1 for _ in read(file)) == count
            peaks.append(tracemalloc.get_traced_memory()[1])
        finally:
            tracemalloc.stop()
    assert peaks[1] < peaks[0] + 3 * MIB  # a block of 4 MiB is read as a whole, and the short file has less


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


def test_a_file_that_cannot_be_finished_is_refused_without_a_word_of_the_library(
    recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Bit 2 of its flags: the length of the last data block is open, and this one is packed."""
    data = bytearray(recording.read_bytes())
    data[:8], data[60:62] = b"UnFinMF ", (1 << 2).to_bytes(2, "little")
    recording.write_bytes(data)
    with pytest.raises(UsageError, match="not a file of MDF 4"):
        list(read(recording))
    assert capsys.readouterr().out == ""


def test_a_recording_of_other_things_has_no_messages(tmp_path: Path) -> None:
    import numpy
    from asammdf import Signal

    path, odd = tmp_path / "other.mf4", Oddities()
    with MDF() as mdf:
        mdf.append(Signal(samples=numpy.array([1.0]), timestamps=numpy.array([0.0]), name="level"))
        mdf.save(path)
    assert list(read(path, odd=odd)) == []
    assert [oddity.what for oddity in odd] == ["groups that are no CAN frames are left out"]


def places(data: bytes | bytearray, kind: bytes) -> list[int]:
    return [at for at in range(0, len(data), 8) if data[at : at + 8] == kind + bytes(4)]


@pytest.mark.parametrize(
    ("kind", "offset", "value", "words"),
    [
        (b"##CG", 8, 255, "claims to have 255 bytes and 6 links"),
        (b"##CG", 80, 1 << 40, "claims to have 1099511627776 records"),
        (b"##CG", 88, 1, "has records with a length each, and channels"),
        (b"##CG", 8, 1 << 62, "claims to have 4611686018427387904 bytes"),
        (b"##DG", 24, 64, "leads to byte 64, which is a part of another one"),
        (b"##DG", 24, 1 << 40, "a block is said to be at byte 1099511627776"),
        (b"##DG", 16, 1 << 60, "links"),
        (b"##CN", 92, 1 << 30, "bits at byte"),
        (b"##DZ", 32, 1 << 60, "for 1152921504606846976"),
        (b"##DZ", 8, 1 << 60, "claims to have 1152921504606846976 bytes"),
    ],
)
def test_a_block_that_lies_is_refused_with_its_place(
    recording: Path, kind: bytes, offset: int, value: int, words: str
) -> None:
    """asammdf would allocate what it says, or read without an end."""
    data = bytearray(recording.read_bytes())
    at = places(data, kind)[0] + offset
    size = 4 if kind == b"##CN" else 8
    data[at : at + size] = value.to_bytes(size, "little")
    recording.write_bytes(data)
    with pytest.raises(UsageError, match=words) as refused:
        list(read(recording))
    assert "at byte" in refused.value.what


def test_a_small_block_that_becomes_gigabytes_is_refused(recording: Path) -> None:
    data = recording.read_bytes()
    (group,) = [at for at in places(data, b"##DG") if int.from_bytes(data[at + 40 : at + 48], "little")][:1]
    bomb = zlib.compress(bytes(1 << 27), 9)
    head = struct.pack("<4s4xQQ2sBxLQQ", b"##DZ", 48 + len(bomb), 0, b"DT", 0, 0, 1000, len(bomb))
    end = len(data) + -len(data) % 8
    lying = bytearray(data.ljust(end, b"\0") + head + bomb)
    lying[group + 40 : group + 48] = end.to_bytes(8, "little")
    recording.write_bytes(lying)
    with pytest.raises(UsageError, match="has more than the 1000 bytes that it claims"):
        list(read(recording))


@pytest.mark.parametrize("version", ["4.00", "4.11", "4.20"])
@pytest.mark.parametrize("compression", [0, 1, 2])
def test_files_of_asammdf_have_true_blocks(version: str, compression: Any, tmp_path: Path) -> None:
    import numpy
    from asammdf import Signal

    path, odd = tmp_path / "other.mf4", Oddities()
    times, texts = numpy.arange(5000) / 100, numpy.array([b"a", b"bcd", b"e"] * 1666 + [b"f", b"g"])
    with MDF(version=version) as mdf:
        mdf.append([Signal(times * 2, times, name="level"), Signal(times.astype("u1"), times, name="state")])
        mdf.append([Signal(texts, times, name="text", encoding="utf-8")])
        mdf.save(path, compression=compression)
    assert list(read(path, odd=odd)) == []
    assert [oddity.what for oddity in odd] == ["groups that are no CAN frames are left out"]
