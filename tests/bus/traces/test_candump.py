"""Log files of candump.  The lines are from `candump -L` and the manual page of can-utils' log formats."""

import contextlib
import io
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.errors import RigError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read as read_file
from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.codec import decode, encode
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


def test_error_frames_are_read_as_notices() -> None:
    error = CanError(ErrorKind.BIT, Place.DATA, 0, 0, True, False, 8, 0)
    text = "(0.000000) can0 20000288#0000810A00000800\n(0.000000) can0 20000240#000000000000FF00\n"
    assert read(text) == [
        TraceEntry(0, "can0", "can", "", encode(error)),
        TraceEntry(0, "can0", "can", "", encode(BusState(CanState.BUS_OFF, 256, 0))),
    ]
    assert read("(1.5) can0 20000080#0000000000000000\n") == []  # of a class that no notice stands for


@given(st.integers(0, 0x1FFF_FFFF), st.binary(max_size=8))
def test_every_identifier_with_the_error_flag_is_an_error_frame(kind: int, data: bytes) -> None:
    """linux/can.h: CAN_ERR_FLAG alone marks an error frame, of whatever class."""
    found = read(f"(1.0) can0 {0x2000_0000 | kind:08X}#{data.hex()}\n")
    assert not any(isinstance(decode(entry.data), CanFrame) for entry in found)


VIEWS = [
    ("  can0  123   [2]  11 22\n", CanFrame(0x123, b"\x11\x22")),
    (" (1.500000)  can0  00000123   [1]  AB\n", CanFrame(0x123, b"\xab", is_extended=True)),
    ("  can0  7FF   [0] \n", CanFrame(0x7FF)),
    ("  vcan0       123   [2]  11 22\n", CanFrame(0x123, b"\x11\x22")),
    ("  can0  123   [3]  remote request\n", CanFrame(0x123, is_remote=True, remote_length=3)),
    ("  can0  123  [08]  11 22 33 44 55 66 77 88\n", CanFrame(0x123, bytes.fromhex("1122334455667788"), is_fd=True)),
    ("  can0  TX - -  123   [2]  11 22\n", CanFrame(0x123, b"\x11\x22")),
    ("  can0  RX B -  123  [01]  11\n", CanFrame(0x123, b"\x11", is_fd=True, is_bit_rate_switched=True)),
    ("  can0  123   [3]  11 27 22   '.'.'\n", CanFrame(0x123, b"\x11\x27\x22")),
    ("  can0  123   [2]  22`11\n", CanFrame(0x123, b"\x11\x22")),
]


@pytest.mark.parametrize(("line", "frame"), VIEWS)
def test_plain_candump_is_read(line: str, frame: CanFrame) -> None:
    (found,) = read(line)
    assert (found.bus[-4:], decode(found.data)) == ("can0", frame)


def test_a_line_without_a_time_has_that_of_the_line_before() -> None:
    text = "  can0  123   [1]  01\n (2.000000)  can0  123   [1]  02\n  can0  123   [1]  03\n"
    assert [found.time_ns for found in read(text)] == [0, 2_000_000_000, 2_000_000_000]


def test_a_time_may_be_a_date() -> None:
    (first, second) = read(
        " (2024-05-17 09:12:01.250000)  can0  123   [1]  01\n (2024-05-17 09:12:02.000000)  can0  123   [1]  02\n"
    )
    assert second.time_ns - first.time_ns == 750_000_000


def test_comments_empty_lines_and_explanations_say_nothing() -> None:
    text = (
        "# bench 4, motor off\n\n(1.0) can0 123#01\n"
        " (1.000000)  can0  20000004   [8]  00 08 00 00 00 00 00 00   ERRORFRAME\n"
        "\tcontroller-problem{tx-error-warning}\n"
    )
    assert [decode(found.data) for found in read(text)] == [
        CanFrame(0x123, b"\x01"),
        BusState(CanState.WARNING, 0, 0),
    ]


@pytest.mark.parametrize(
    "command",
    [
        "candump can0",
        "$ candump -ta can0,500:7ff",
        "# candump any",
        "pi@rover:~/logs $ candump can0 -e",
        "sudo candump can0",
    ],
)
def test_what_a_terminal_has_around_a_log_says_nothing(command: str) -> None:
    text = f"{command}\n  can0  701   [1]  00\n^Cpi@rover:~/logs $ \n"
    assert [decode(found.data) for found in read(text)] == [CanFrame(0x701, b"\x00")]
    assert candump.recognises(text.encode())


def test_what_other_programs_add_to_data_is_read() -> None:
    """cansend puts dots between bytes, and candump adds the raw DLC of a frame of 8 bytes."""
    assert read("(1.5) can0 123#11.22.33\n") == [entry(CanFrame(0x123, b"\x11\x22\x33"), 1_500_000_000)]
    assert read("(1.5) can0 123#1122334455667788_E\n") == [
        entry(CanFrame(0x123, bytes.fromhex("1122334455667788")), 1_500_000_000)
    ]


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("hello", "expected (TIME) BUS IDENTIFIER#DATA"),
        ("(x) can0 123#", "'x' is not a time"),
        ("(1.0) can0 123#zz", "'zz' is not data"),
        ("(1.0) can0 123", "expected (TIME) BUS IDENTIFIER#DATA"),
        ("(1.0) can0 FFF#01", "identifier 0xfff: expected at most 0x7ff"),
        ("(1.0) can0 12#01", "'12' is not an identifier: expected 3 digits"),
        ("(1.0) can0 80000123#01", "expected at most 0x1fffffff"),
        ("(1.0) can0 123#112", "the data 112 ends with half a byte"),
        ("(1.0) can0 123##0112", "the data 112 ends with half a byte"),
        ("(1.0) can0 123##", "an FD frame has a digit with its flags after ##"),
        ("(1.0) can0 123#112233445566778899", "9 bytes of data"),
        ("(1.0) can0 123#R9", "remote_length 9"),
        ("  can0  123   [2]  11", "the data has 1 byte, and [2] says 2: the line may be cut off"),
        ("  can0  123   [2]  11 2", "the data 112 ends with half a byte"),
    ],
)
def test_wrong_line_is_named_with_the_reason(line: str, reason: str) -> None:
    with pytest.raises(RigError) as wrong:
        read(f"(1.0) can0 123#01\n{line}\n")
    assert wrong.value.what.startswith("line 2 is not a line of candump: ")
    assert reason in wrong.value.what


@pytest.mark.parametrize("line", ["(1.0) can0 12", "(1.0) can0 123#1", "(1.0) ca", "  can0  123   [2]  11"])
def test_a_last_line_that_is_cut_off_is_left_out_and_told(line: str) -> None:
    odd = Oddities()
    found = list(candump.read(io.BytesIO(f"(1.0) can0 123#01\n{line}".encode()), odd))
    assert found == [entry(CanFrame(0x123, b"\x01"), 1_000_000_000)]
    assert [str(oddity) for oddity in odd] == ["line 2: the last line has no end, and may be cut off"]
    with pytest.raises(RigError, match="line 1 is cut off: "):
        read(line)


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        (
            "(1.0) can0 123#\n(1.0) vcan1 123#\n(1.0) can2 123#\n",
            "line 2: another interface begins, vcan1; the lines before are of can0 (2 times in all)",
        ),
        (
            " (2024-02-30 09:12:01.250000)  can0  123   [1]  01\n",
            "line 1: the time is not one, and the message has that of the line before",
        ),
        (
            "can0  123   [1]  01\ncan0  123   [1]  02\n",
            "line 1: lines are without a time (candump -t), and get that of the line before (2 times in all)",
        ),
        (
            "(1.0) can0 123#\n(1.0) can0 20000080#0000000000000000\n",
            "line 2: error frames that report no error and no state of a controller are left out",
        ),
    ],
)
def test_what_is_odd_is_read_and_told_once(lines: str, told: str) -> None:
    odd = Oddities()
    assert list(candump.read(io.BytesIO(lines.encode()), odd))
    assert [str(oddity) for oddity in odd] == [told]


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


def test_times_since_the_line_before_are_added_up(tmp_path: Path) -> None:
    """As in the tutorial of CANopenNode about SDO: `candump -td -a vcan0`."""
    path, odd = tmp_path / "x.txt", Oddities()
    lines = (
        " (000.000000)  vcan0  604   [8]  77 9B FA 36 21 0F 09 2E   'w..6!...'",
        " (000.000006)  vcan0  604   [8]  78 C2 6F 97 DC 1D 97 9E   'x.o.....'",
        " (000.000003)  vcan0  583   [8]  02 E0 B9 97 47 8D 37 E6   '....G.7.'",
        " (000.000001)  vcan0  583   [8]  03 07 B6 88 68 0B 6A 8C   '....h.j.'",
        " (000.500008)  vcan0  604   [8]  79 4E 6B 8D 2B 02 F5 9E   'yNk.+...'",
    )
    path.write_text("\n".join(lines) + "\n")
    assert [one.time_ns // 1000 for one in read_file(path, odd=odd)] == [0, 6, 9, 10, 500_018]
    assert [str(one) for one in odd] == [
        "line 1: times are those since the line before (candump -t d), and are added up"
    ]


def test_times_from_the_first_line_stay(tmp_path: Path) -> None:
    path = tmp_path / "x.txt"
    path.write_text("".join(f" (00{second}.000000)  can0  604   [0]\n" for second in (0, 1, 2, 1, 2, 3)))
    assert [one.time_ns for one in read_file(path)] == [0, 10**9, 2 * 10**9, 10**9, 2 * 10**9, 3 * 10**9]
