"""Log files of candump.  The lines are from `candump -L` and the manual page of can-utils' log formats."""

import contextlib
import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.errors import RigError
from fieldrig.trace import TraceEntry
from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import FD_LENGTHS, CanFrame
from fieldrig_bus.can.notices import BitRate, BusState, CanControl, CanError, CanState, ErrorKind, FaultNote, Notice
from fieldrig_bus.traces import candump

START_UNIX_NS = 1_700_000_000_000_000_000

FRAMES = [
    (CanFrame(0x123, bytes.fromhex("1122334455667788")), "123#1122334455667788"),
    (CanFrame(0x7FF), "7FF#"),
    (CanFrame(0x5, b"\x01", is_extended=True), "00000005#01"),
    (CanFrame(0x123, is_remote=True), "123#R"),
    (CanFrame(0x123, is_remote=True, remote_length=8), "123#R8"),
    (CanFrame(0x1FFFFFFF, bytes(12), is_extended=True, is_fd=True), "1FFFFFFF##0" + "00" * 12),
    (CanFrame(0x10, b"\xab", is_fd=True, is_bit_rate_switched=True), "010##1AB"),
]


def entry(frame: CanFrame, time_ns: int = 0, bus: str = "can0", sender: str = "") -> TraceEntry:
    return TraceEntry(time_ns, bus, "can", sender, encode(frame))


def written(*entries: TraceEntry, start_unix_ns: int = START_UNIX_NS) -> str:
    file = io.BytesIO()
    candump.write(entries, file, start_unix_ns)
    return file.getvalue().decode()


def read(text: str) -> list[TraceEntry]:
    return list(candump.read(io.BytesIO(text.encode())))


@pytest.mark.parametrize(("frame", "text"), FRAMES)
def test_frame_is_a_line(frame: CanFrame, text: str) -> None:
    line = f"(1700000000.000250) can0 {text}\n"
    assert written(entry(frame, 250_999)) == line
    assert read(line) == [entry(frame, START_UNIX_NS + 250_000)]


def test_other_families_are_left_out_and_not_counted() -> None:
    file = io.BytesIO()
    serial = TraceEntry(0, "com1", "serial", "a", b"\x00x")
    assert candump.write([serial, entry(CanFrame(1)), serial], file, 0) == 1


@pytest.mark.parametrize("text", ["(1.5) can0 123#01 R\n", "(1.5) can0 123#01 T\n", "\n(1.5) can0 123#01\n\n"])
def test_lines_of_other_programs_are_read(text: str) -> None:
    assert read(text) == [entry(CanFrame(0x123, b"\x01"), 1_500_000_000)]


def test_errors_are_written_as_error_frames_and_faults_left_out() -> None:
    """linux/can/error.h: PROT | BUSERROR | CNT, then bit error while sending, in the data section, TEC 8."""
    error = CanError(ErrorKind.BIT, Place.DATA, 20, 0x123, True, False, 8, 0)
    notices: list[Notice] = [error, BusState(CanState.BUS_OFF, 256, 0), FaultNote(1, "dropped")]
    notices += [CanControl(), BitRate(250_000)]
    entries = [TraceEntry(0, "can0", "can", "io", encode(notice)) for notice in notices]
    assert written(*entries, start_unix_ns=0).splitlines() == [
        "(0.000000) can0 20000288#0000810A00000800",
        "(0.000000) can0 20000240#000000000000FF00",
    ]


def test_error_frames_are_skipped() -> None:
    assert read("(1.5) can0 20000080#0000000000000000\n") == []


@pytest.mark.parametrize("line", ["hello", "(x) can0 123#", "(1.0) can0 123#zz", "(1.0) can0 123", "(1) can0 FFF#01"])
def test_wrong_line_is_named(line: str) -> None:
    with pytest.raises(RigError, match="line 2 is not a line of candump"):
        read(f"(1.0) can0 123#01\n{line}\n")


@given(st.binary(max_size=60) | st.text("(1.0) can#R_\n", max_size=60).map(str.encode))
def test_no_bytes_are_a_fault_of_ours(data: bytes) -> None:
    with contextlib.suppress(RigError):
        list(candump.read(io.BytesIO(data)))


CAN_FRAMES = st.one_of(
    st.builds(CanFrame, st.integers(0, 0x7FF), st.binary(max_size=8)),
    st.builds(CanFrame, st.integers(0, 0x1FFFFFFF), st.binary(max_size=8), st.just(True)),
    st.builds(CanFrame, st.integers(0, 0x7FF), is_remote=st.just(True), remote_length=st.integers(0, 8)),
    st.builds(
        CanFrame,
        st.integers(0, 0x1FFFFFFF),
        st.sampled_from(FD_LENGTHS).map(bytes),
        is_extended=st.just(True),
        is_fd=st.just(True),
        is_bit_rate_switched=st.booleans(),
    ),
)


@given(st.lists(st.tuples(CAN_FRAMES, st.integers(0, 2_000_000_000_000_000)), max_size=10))
def test_every_frame_comes_back_to_the_microsecond(frames: list[tuple[CanFrame, int]]) -> None:
    entries = [entry(frame, microseconds * 1000) for frame, microseconds in frames]
    assert read(written(*entries, start_unix_ns=0)) == entries
