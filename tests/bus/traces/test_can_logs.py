"""The formats of CAN logs, each against python-can: what it writes is read here, and what is written here it reads.

Python-can's way to say things is the judge here; lines of other programs are in the test of each format.
"""

import io
from contextlib import suppress
from pathlib import Path

import can
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fieldrig.clock import MS, S
from fieldrig.errors import RigError
from fieldrig.traces.formats import Format, format_of, formats
from fieldrig.traces.oddities import LATEST_NS, Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read, write
from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.codec import decode, encode
from fieldrig_bus.can.frame import FD_LENGTHS, CanFrame
from fieldrig_bus.can.notices import BusState, CanError, CanState, ErrorKind, FaultNote, Notice
from fieldrig_bus.traces import can_csv

T = 1_700_000_000_123_456_000
ALL = [".asc", ".blf", ".trc", ".csv", ".db", ".mf4"]
WITH_BUSES = [".asc", ".blf", ".trc", ".mf4"]


def entry(frame: CanFrame | Notice, time_ns: int = T, bus: str = "can0") -> TraceEntry:
    return TraceEntry(time_ns, bus, "can", "", encode(frame))


CLASSICAL = [
    CanFrame(0x605, bytes.fromhex("40 00 10 00 00 00 00 00")),
    CanFrame(0x7FF),
    CanFrame(0x1ABCDEF0, b"\x01\x02", is_extended=True),
    CanFrame(0x5, b"\x00\xff", is_extended=True),
    CanFrame(0x123, is_remote=True, remote_length=4),
    CanFrame(0x123, is_remote=True, is_extended=True),
]
FD = [
    CanFrame(0x124, bytes(range(12)), is_fd=True, is_bit_rate_switched=True),
    CanFrame(0x1FFFFFFF, bytes(range(64)), is_extended=True, is_fd=True),
    CanFrame(0x10, b"\xab", is_fd=True, is_bit_rate_switched=True),
    CanFrame(0x11, is_fd=True),
]


def read_back(path: Path) -> list[TraceEntry]:
    odd = Oddities()
    found = list(read(path, odd=odd))
    assert not len(odd)
    return found


@pytest.mark.parametrize("ending", WITH_BUSES)
def test_every_frame_comes_back_with_its_bus(ending: str, tmp_path: Path) -> None:
    buses = ["can0", "axis", "can1", 'the "old" one', "vcan0"]
    sent = [
        entry(frame, T + number * 1_234_000, buses[number % 5]) for number, frame in enumerate([*CLASSICAL, *FD] * 2)
    ]
    assert write(sent, tmp_path / f"x{ending}") == len(sent)
    assert read_back(tmp_path / f"x{ending}") == sent


@pytest.mark.parametrize("ending", [".csv", ".db"])
def test_what_a_table_cannot_say_is_reported(ending: str, tmp_path: Path) -> None:
    path, odd = tmp_path / f"x{ending}", Oddities()
    sent = [entry(frame, T + number * MS) for number, frame in enumerate([*CLASSICAL, FD[1]])]
    assert write(sent, path, odd) == len(sent)
    assert read_back(path) == sent
    assert not len(odd)
    write([entry(CLASSICAL[0]), entry(FD[0]), entry(FD[2], bus="can1")], path, odd)
    assert [str(oddity) for oddity in odd] == [
        "the format does not say which FD frames switch the bit rate",
        "the format has no buses, so their frames are mixed",
        "the format has no FD frames, so those of at most 8 bytes become classical ones",
    ]


@pytest.mark.parametrize("ending", ALL)
def test_virtual_time_and_an_empty_trace_come_back(ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"x{ending}"
    sent = [entry(CLASSICAL[0], 0), entry(CLASSICAL[1], 5 * MS), entry(CLASSICAL[2], 3600 * S)]
    assert write(sent, path) == 3
    assert read_back(path) == sent
    assert write([], path) == 0
    assert read_back(path) == []


@pytest.mark.parametrize("ending", ALL)
def test_virtual_time_that_begins_later_comes_back(ending: str, tmp_path: Path) -> None:
    sent = [entry(CLASSICAL[0], 5 * S), entry(CLASSICAL[1], 6 * S)]
    write(sent, tmp_path / f"x{ending}")
    assert read_back(tmp_path / f"x{ending}") == sent


WILD = f"{can_csv.HEAD}\n" + "".join(
    f"{time},0x123,0,0,0,0,\n" for time in ("-62135596801.5", "-1.500000000", "99999999999.0", "0.0")
)
TIMES_S = {
    ".asc": (0, 1 << 40),
    ".log": (0, 1 << 40),
    ".pcap": (0, 1 << 32),
    ".pcapng": (0, 1 << 40),
    ".blf": (0, 1 << 40),
}
"""The seconds since 1970 that a format can say, where it has not those of a trace."""


@pytest.mark.parametrize("ending", [*ALL, ".log", ".pcap", ".pcapng", ".jsonl"])
def test_times_of_no_calendar_are_bounded_and_written(ending: str, tmp_path: Path) -> None:
    """A CSV has any time.  One that the target cannot say becomes the nearest one, and is reported."""
    path, odd, saying = tmp_path / "wild.csv", Oddities(), Oddities()
    path.write_text(WILD)
    wild = list(read(path, odd=odd))
    assert [one.time_ns for one in wild] == [-LATEST_NS, -1_500_000_000, LATEST_NS, 0]
    assert ("line 2", "times beyond the year 2262 become the last one of a trace") in [
        (one.place, one.what) for one in odd
    ]
    write(wild, tmp_path / f"x{ending}", saying)
    least, most = TIMES_S.get(ending, (-1 << 40, 1 << 40))
    found = [one.time_ns / S for one in read(tmp_path / f"x{ending}")]
    assert found == pytest.approx([max(least, min(one.time_ns / S, most)) for one in wild], abs=1)
    assert bool(saying) == (ending in TIMES_S)


def test_a_bus_in_a_log_of_candump_is_one_word(tmp_path: Path) -> None:
    path, odd = tmp_path / "x.log", Oddities()
    write([entry(CLASSICAL[0], bus="the (old) one"), entry(CLASSICAL[1], bus="")], path, odd)
    assert [one.bus for one in read(path)] == ["the__old__one", "can"]
    assert [oddity.what for oddity in odd] == ["names of buses are one word in the format"]


@pytest.mark.parametrize("ending", ALL)
def test_a_clock_that_was_set_back_changes_no_time(ending: str, tmp_path: Path) -> None:
    path, odd = tmp_path / f"x{ending}", Oddities()
    sent = [entry(CLASSICAL[0], T), entry(CLASSICAL[1], T - 2 * S), entry(CLASSICAL[1], T + S)]
    write(sent, path)
    found = list(read(path, odd=odd))
    assert found == sent
    assert [oddity.what for oddity in odd] == ["the time jumps back"]


def test_a_blf_says_which_times_it_cannot_have(tmp_path: Path) -> None:
    odd = Oddities()
    write(
        [entry(CLASSICAL[0], T), entry(CLASSICAL[0], T + 60 * S), entry(CLASSICAL[1], T - S)], tmp_path / "x.blf", odd
    )
    assert [oddity.what for oddity in odd] == [
        "messages earlier than the first one get its time, as the format has no earlier"
    ]


ERROR = CanError(ErrorKind.STUFF, Place.DATA, 0, 0, False, False, 0, 0)
STATE = BusState(CanState.PASSIVE, 132, 5)


@pytest.mark.parametrize("ending", [".asc", ".blf", ".csv", ".db", ".mf4"])
def test_errors_and_states_come_back(ending: str, tmp_path: Path) -> None:
    sent = [
        entry(ERROR),
        entry(STATE),
        entry(BusState(CanState.BUS_OFF, 256, 0)),
        entry(BusState(CanState.ACTIVE, 0, 0)),
    ]
    path = tmp_path / f"x{ending}"
    assert write([*sent, entry(FaultNote(1, "dropped"))], path) == 4
    found = [decode(one.data) for one in read(path)]
    assert found[:2] == [ERROR, STATE]
    assert [one.state for one in found[1:] if isinstance(one, BusState)] == [
        CanState.PASSIVE,
        CanState.BUS_OFF,
        CanState.ACTIVE,
    ]
    assert sum(message.is_error_frame for message in messages_of(path)) == (1 if ending == ".asc" else 4)


# Against python-can


def message(frame: CanFrame, time_ns: int, channel: int = 0) -> can.Message:
    return can.Message(
        timestamp=time_ns / S,
        arbitration_id=frame.identifier,
        is_extended_id=frame.is_extended,
        is_remote_frame=frame.is_remote,
        is_fd=frame.is_fd,
        bitrate_switch=frame.is_bit_rate_switched,
        dlc=frame.remote_length if frame.is_remote else len(frame.data),
        data=frame.data,
        channel=channel,
    )


def seen(message: can.Message) -> tuple[object, ...]:
    kind = (message.arbitration_id, message.is_extended_id, message.is_remote_frame, message.is_fd)
    return (*kind, message.bitrate_switch, message.dlc, bytes(message.data), round(message.timestamp, 5))


def messages_of(path: Path) -> list[can.Message]:
    reader = can.ASCReader(path, relative_timestamp=False) if path.suffix == ".asc" else can.LogReader(path)
    with reader:
        return list(reader)


@pytest.mark.parametrize("ending", ALL)
def test_python_can_reads_what_is_written(ending: str, tmp_path: Path) -> None:
    frames = [*CLASSICAL, *FD] if ending in WITH_BUSES else CLASSICAL
    if ending == ".asc":
        frames = frames[:-1]  # it takes an FD frame without data for a remote one
    sent = [entry(frame, T + number * MS, f"can{number % 2}") for number, frame in enumerate(frames)]
    write(sent, tmp_path / f"x{ending}")
    found = messages_of(tmp_path / f"x{ending}")
    if ending == ".trc":  # it leaves the DLC of an FD frame as a code
        assert [one.dlc for one in found][-4:] == [9, 15, 1, 0]
        for one in found[-4:]:
            one.dlc = len(one.data)
    assert [seen(one) for one in found] == [
        seen(message(frame, T + number * MS)) for number, frame in enumerate(frames)
    ]
    if ending in (".asc", ".blf"):
        assert [one.channel for one in found] == [number % 2 for number in range(len(frames))]


@pytest.mark.parametrize("ending", ALL)
def test_what_python_can_writes_is_read(ending: str, tmp_path: Path) -> None:
    """Its writers of TRC, CSV and SQLite have no FD frames, and that of TRC has no remote frames."""
    path, begin_ns = tmp_path / f"x{ending}", 1_700_000_000 * S
    frames = [*CLASSICAL, *FD] if ending in (".asc", ".blf") else CLASSICAL[:4] if ending == ".trc" else CLASSICAL
    with can.Logger(path) as logger:
        for number, frame in enumerate(frames):
            logger.on_message_received(message(frame, begin_ns + number * MS, number % 2))
    found = list(read(path))
    assert [(one.time_ns + 500_000) // MS * MS for one in found] == [
        begin_ns + number * MS for number in range(len(frames))
    ]
    assert [decode(one.data) for one in found] == frames
    if ending in WITH_BUSES:
        assert [one.bus for one in found] == [f"can{number % 2}" for number in range(len(frames))]


FRAMES = st.one_of(
    st.builds(CanFrame, st.integers(0, 0x7FF), st.binary(max_size=8)),
    st.builds(CanFrame, st.integers(0, 0x1FFFFFFF), st.binary(max_size=8), st.just(True)),
    st.builds(CanFrame, st.integers(0, 0x7FF), is_remote=st.just(True), remote_length=st.integers(0, 8)),
    st.builds(
        CanFrame,
        st.integers(0, 0x1FFFFFFF),
        st.sampled_from(FD_LENGTHS).flatmap(lambda size: st.binary(min_size=size, max_size=size)),
        is_extended=st.just(True),
        is_fd=st.just(True),
        is_bit_rate_switched=st.booleans(),
    ),
)
MODULES = [format_of(Path(f"x{ending}")) for ending in (".asc", ".blf", ".trc")]


@pytest.mark.long
@given(st.lists(st.tuples(FRAMES, st.integers(0, 10 * MS), st.text(max_size=8)), max_size=12), st.sampled_from(MODULES))
@settings(deadline=None)
def test_any_frames_on_any_buses_come_back(frames: list[tuple[CanFrame, int, str]], form: Format) -> None:
    sent, time_ns = [], T
    for frame, wait_ns, bus in frames:
        time_ns += wait_ns - wait_ns % 1000
        sent.append(entry(frame, time_ns, bus or "can0"))
    file = io.BytesIO()
    assert form.write(sent, file, 0) == len(sent)
    file.seek(0)
    assert list(form.read(file)) == sent


@pytest.mark.long
@pytest.mark.parametrize("form", formats(), ids=lambda form: form.SUFFIXES[0])
@given(data=st.binary(max_size=300))
@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_no_bytes_do_more_than_be_refused(form: Format, data: bytes) -> None:
    for begin in (b"", b"LOGG", b"date Sat Sep 30 15:06:13 2017\n", b";$FILEVERSION=1.1\n", can_csv.HEAD.encode()):
        with suppress(RigError):
            list(form.read(io.BytesIO(begin + data)))


@pytest.mark.parametrize("ending", [".asc", ".blf", ".trc", ".csv", ".db", ".log", ".pcap", ".pcapng", ".vcd"])
@pytest.mark.parametrize("family", ["can", "modbus", "serial", "wires", "ring", "nonsense"])
def test_a_message_of_a_file_that_is_none_is_left_out(ending: str, family: str, tmp_path: Path) -> None:
    """JSON lines may have any bytes.  Only pcapng keeps them."""
    bad = [TraceEntry(T, "x", family, "", data) for data in (b"", b"\x01", b"\xff", b"c" * 9, b"\x23\x01\0\0\x09")]
    written = write(bad, tmp_path / f"x{ending}")
    assert written == (len(bad) if ending == ".pcapng" else 0)
    if ending == ".pcapng":
        assert read_back(tmp_path / "x.pcapng") == bad


@pytest.mark.parametrize("size", [5_000_000, 4 << 30])
@pytest.mark.parametrize("ending", [".log", ".asc", ".blf", ".trc", ".csv", ".gvret", ".jsonl", ".pcap"])
def test_room_on_the_disk_that_was_never_written_ends_a_log(ending: str, size: int, tmp_path: Path) -> None:
    """After a power failure, a file has its size, and zeros where its last bytes should be; 4 GB take no minutes."""
    path = tmp_path / f"night{ending}"
    entries = [entry(CanFrame(0x705, b"\x05"), T + number * S) for number in range(3)]
    write(entries, path)
    with path.open("ab") as file:
        file.truncate(path.stat().st_size + size)
    odd = Oddities()
    assert [each.data for each in read(path, odd=odd)] == [each.data for each in entries]
    assert any("zeros" in str(one) or "no objects" in str(one) for one in odd)


@pytest.mark.parametrize("ending", [".jsonl", ".log", ".asc", ".trc", ".csv", ".gvret"])
def test_lines_that_end_with_cr_alone_are_read_as_others(tmp_path: Path, ending: str) -> None:
    """Terminal programs and old Macs write them; a jump in time finds its lines, too."""
    file, old = tmp_path / f"new{ending}", tmp_path / f"old{ending}"
    write([entry(CanFrame(0x181, bytes((number,))), T + number * S) for number in range(50)], file)
    old.write_bytes(file.read_bytes().replace(b"\r\n", b"\n").replace(b"\n", b"\r"))
    assert list(read(old)) == list(read(file))
    assert list(read(old, 30 * S, 3 * S)) == list(read(file, 30 * S, 3 * S)) != []
