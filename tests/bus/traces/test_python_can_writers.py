"""The writers of CAN logs write byte for byte what those of python-can write, but for what each test names."""

import re
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import can
import pytest

from fieldrig.clock import MS, S
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import write
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.traces.blf_objects import chunks, read_head

T = 1_700_000_000_250_000_000
PLAIN = [
    CanFrame(0x605, bytes.fromhex("40 00 10 00 00 00 00 00")),
    CanFrame(0x7FF),
    CanFrame(0x1ABCDEF0, b"\x01\x02", is_extended=True),
    CanFrame(0x0, b"\xff"),
]
REMOTE = [CanFrame(0x123, is_remote=True, remote_length=4), CanFrame(0x1F, is_remote=True, is_extended=True)]
FD = [
    CanFrame(0x124, bytes(range(12)), is_fd=True, is_bit_rate_switched=True),
    CanFrame(0x1FFFFFFF, bytes(range(64)), is_extended=True, is_fd=True),
]


def message(frame: CanFrame, time_ns: int) -> can.Message:
    return can.Message(
        timestamp=time_ns / S,
        arbitration_id=frame.identifier,
        is_extended_id=frame.is_extended,
        is_remote_frame=frame.is_remote,
        is_fd=frame.is_fd,
        bitrate_switch=frame.is_bit_rate_switched,
        dlc=frame.remote_length if frame.is_remote else len(frame.data),
        data=frame.data,
        channel=0,
        is_rx=True,
    )


def both(frames: list[CanFrame], ending: str, folder: Path) -> tuple[Path, Path]:
    """Return what is written here and by python-can.  Times are quarters of a second, which a float has exactly."""
    ours, theirs = folder / f"ours{ending}", folder / f"theirs{ending}"
    times_ns = [T + number * 250 * MS for number in range(len(frames))]
    pairs = list(zip(times_ns, frames, strict=True))
    write([TraceEntry(time_ns, "can0", "can", "", encode(frame)) for time_ns, frame in pairs], ours)
    with can.Logger(theirs) as logger:
        for time_ns, frame in pairs:
            logger.on_message_received(message(frame, time_ns))
    return ours, theirs


def without_comments(text: str) -> str:
    return re.sub(r"(?m)^(;|//|date|Begin Trigger|\s*0\.0+ Start of).*\n", "", text.replace("\r\n", "\n"))


def same(text: str) -> str:
    return text


def log_of_python_can(text: str) -> str:
    """It appends the direction, which `candump -L` does not, and leaves out the length of a remote frame."""
    return text.replace(" R\n", "\n").replace("123#R\n", "123#R4\n")


def asc_of_python_can(text: str) -> str:
    """It pads the time to 9 characters, and CANoe to 11; a line without data ends with a space."""
    return re.sub(r"(?m)^ (\d+\.\d+)(?= )", lambda line: f"{line[1]:>11}", without_comments(text)).replace(" \n", "\n")


def trc_of_python_can(text: str) -> str:
    """It counts from 0, and aligns channel and identifier to the right, where PEAK has 2 and 8 characters for them."""
    lines = re.findall(r"(?m)^ *(\d+) ( *[\d.]+) DT  1 +([0-9A-F]+) (.*)$", text)
    return "".join(f"{int(number) + 1:>7} {time} DT 1  {word:>8} {rest}\n" for number, time, word, rest in lines)


def csv_of_python_can(text: str) -> str:
    """It writes a time as Python shows a float, and here it has nine digits."""
    return re.sub(r"(?m)^(\d+\.\d+),", lambda line: f"{line[1].partition('.')[0]}.{line[1][11:]:0<9},", text)


@pytest.mark.parametrize(
    ("ending", "frames", "known"),
    [
        (".log", PLAIN + REMOTE + FD, log_of_python_can),
        (".asc", PLAIN + REMOTE + FD, asc_of_python_can),
        (".trc", PLAIN, trc_of_python_can),
        (".csv", PLAIN + REMOTE, csv_of_python_can),
    ],
)
def test_lines_are_those_of_python_can(
    ending: str, frames: list[CanFrame], known: Callable[[str], str], tmp_path: Path
) -> None:
    ours, theirs = both(frames, ending, tmp_path)
    expected = known(theirs.read_bytes().decode().replace("\r\n", "\n"))
    assert without_comments(ours.read_bytes().decode()) == expected
    assert len(expected.splitlines()) >= len(frames)


def test_objects_of_a_blf_are_those_of_python_can(tmp_path: Path) -> None:
    """The text that names the bus comes before them; python-can's second flag of a header says nothing."""
    inside = []
    for path in both(PLAIN + REMOTE + FD, ".blf", tmp_path):
        with path.open("rb") as file:
            head = read_head(file, Oddities())
            inside.append((head, b"".join(chunks(file, Oddities()))))
    (our_head, ours), (their_head, theirs) = inside
    assert our_head == their_head
    assert ours[-len(theirs) :] == theirs
    assert b"fieldrig: channel 1" in ours[: -len(theirs)]


def test_rows_of_a_database_are_those_of_python_can(tmp_path: Path) -> None:
    rows = []
    for path in both(PLAIN + REMOTE, ".db", tmp_path):
        with closing(sqlite3.connect(path)) as database:
            rows.append(
                [database.execute(ask).fetchall() for ask in ("SELECT * FROM messages", "PRAGMA table_info(messages)")]
            )
    assert rows[0] == rows[1]
    assert len(rows[0][0]) == len(PLAIN + REMOTE)
