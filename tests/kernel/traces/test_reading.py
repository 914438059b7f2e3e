"""Reading a recording: its format by its content, a part of its time, the order of time, and what is odd in it."""

import re
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

import fieldrig
from fieldrig.cli.app import app
from fieldrig.clock import S
from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities, with_jumps_reported
from fieldrig.traces.order import in_order
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read
from fieldrig.traces.window import DISORDER_NS, within

T = 1_700_000_000
LINES = [f"({T + second}.000000) can0 123#{second:02X}\n" for second in range(10)]


def entry(time_ns: int, bus: str = "can0") -> TraceEntry:
    return TraceEntry(time_ns, bus, "can", "", bytes.fromhex("2301000000"))


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "machine.log"
    path.write_text("".join(LINES))
    return path


def test_a_public_function_reads_a_part_of_a_recording(log: Path) -> None:
    found = list(fieldrig.read_trace(log, begin=2 * S, duration=3 * S))
    assert [one.time_ns - T * S for one in found] == [2 * S, 3 * S, 4 * S]
    assert [one.data[-1] for one in fieldrig.read_trace(str(log), duration=2 * S)] == [0, 1]
    assert [one.data[-1] for one in fieldrig.read_trace(log, begin=8 * S)] == [8, 9]


@pytest.mark.parametrize("name", ["machine.txt", "machine", "machine.jsonl", "machine.blf"])
def test_a_format_is_recognised_by_its_content(log: Path, name: str) -> None:
    other = log.rename(log.with_name(name))
    assert len(list(read(other))) == 10


@pytest.mark.parametrize("name", ["lab.yaml", "lab.yml"])
def test_a_rig_file_is_not_taken_for_a_log(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("time: real\nbuses: {}\n")
    with pytest.raises(UsageError, match="perhaps a rig file") as refused:
        list(read(tmp_path / name))
    assert "`fieldrig draw --rig`" in refused.value.remedy


def test_what_is_no_log_is_named_with_the_formats_that_are_known(tmp_path: Path) -> None:
    path = tmp_path / "letter.txt"
    path.write_text("Dear Sir or Madam,\n")
    with pytest.raises(UsageError, match=r"letter\.txt: no log of a known format") as refused:
        list(read(path))
    assert "candump (.log, .candump)" in refused.value.remedy


def test_a_mistake_is_named_with_its_file_and_line(log: Path) -> None:
    log.write_text(f"{LINES[0]}hello\n{LINES[1]}", encoding="utf-8")
    with pytest.raises(UsageError, match=r"machine\.log: line 2 is not a line of candump"):
        list(read(log))


def test_a_line_without_an_end_takes_no_memory(tmp_path: Path) -> None:
    path = tmp_path / "x.log"
    path.write_bytes(LINES[0].encode() + b"x" * 3_000_000)
    with pytest.raises(UsageError, match=r"x\.log: line 2 has more than 65536 bytes"):
        list(read(path))


def test_show_and_convert_take_a_part_of_the_time(log: Path) -> None:
    shown = CliRunner().invoke(app, ["trace", "show", str(log), "--from", "7s", "--for", "2s"])
    assert [line.split()[-1] for line in shown.stdout.splitlines()] == ["07", "08"]
    target = log.with_name("part.log")
    done = CliRunner().invoke(app, ["trace", "convert", str(log), str(target), "--from", "8s"])
    assert done.exit_code == 0
    assert target.read_text() == "".join(LINES[8:])
    done = CliRunner().invoke(app, ["trace", "convert", str(log), str(target), "--from", "2min"])
    assert f"{log}: no message is in this part of the time" in done.stderr


def test_what_is_odd_is_said_once_on_the_error_output(log: Path) -> None:
    log.write_text("".join(LINES[:3] + LINES[1:2] + LINES[:1] + LINES[3:]) + "(17000000", encoding="utf-8")
    shown = CliRunner().invoke(app, ["trace", "show", str(log)])
    assert len(shown.stdout.splitlines()) == 12
    assert shown.stderr.splitlines() == [
        f"{log}: line 4: the time jumps back by 1 s (2 times in all)",
        f"{log}: line 13: the last line has no end, and may be cut off",
    ]


def test_a_clock_that_was_wrong_is_told() -> None:
    odd = Oddities()
    sent = [entry(5 * S), entry(T * S), entry(T * S + 1, "can1"), entry(T * S), entry(9 * 10**18)]
    assert list(with_jumps_reported(sent, odd)) == sent
    assert [oddity.what for oddity in odd] == [
        "the time jumps forward by more than a day",
        "the time is in the future",
    ]


def test_virtual_time_counts_from_the_start_of_the_rig() -> None:
    sent = [entry(second * S) for second in (3, 4, 5)]
    assert list(within(sent, 4 * S, S)) == sent[1:2]


def test_reading_ends_soon_after_the_end_of_a_part() -> None:
    sent = iter([entry(time_ns * S) for time_ns in (0, 1, 20, 21)])
    assert len(list(within(sent, None, 2 * S))) == 2
    assert next(sent).time_ns == 21 * S


@given(st.lists(st.integers(0, DISORDER_NS), max_size=50), st.integers(1, 60))
def test_messages_come_in_the_order_of_time(times_ns: list[int], most: int) -> None:
    sent = [TraceEntry(time_ns, f"b{number}", "can", "", b"") for number, time_ns in enumerate(times_ns)]
    found = list(in_order(sent, most))
    assert sorted(found) == sorted(sent)
    if most >= len(sent):
        assert found == sorted(sent, key=lambda one: one.time_ns)


def test_a_clock_that_was_set_back_does_not_fill_the_memory() -> None:
    found = list(in_order([entry(100 * S), entry(50 * S), entry(60 * S), entry(101 * S)]))
    assert [one.time_ns // S for one in found] == [50, 60, 100, 101]
    late = list(in_order([entry(100 * S), entry(200 * S), entry(50 * S)]))
    assert [later.time_ns >= earlier.time_ns for earlier, later in pairwise(late)] == [False, True]


@pytest.mark.parametrize("ending", ["log", "asc", "trc", "csv", "jsonl"])
def test_an_empty_file_of_text_is_reported(ending: str, tmp_path: Path) -> None:
    (tmp_path / f"x.{ending}").touch()
    odd = Oddities()
    assert list(read(tmp_path / f"x.{ending}", odd=odd)) == []
    assert [str(oddity) for oddity in odd] == ["the file is empty"]


@pytest.mark.parametrize(
    "ending", ["log", "asc", "blf", "trc", "csv", "db", "mf4", "pcap", "pcapng", "jsonl", "vcd", "txt"]
)
def test_a_picture_is_no_log_whatever_its_name_says(ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"x.{ending}"
    path.write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\n\0\0\0\n\x08\x06\n1 2 3\n")
    with pytest.raises(UsageError) as refused:
        list(read(path))
    assert refused.value.what.startswith(f"{path}: ")


@pytest.mark.parametrize(("head", "name"), [(b"\x1f\x8b\x08", "gzip"), (b"PK\x03\x04", "zip")])
def test_a_packed_log_is_said_to_be_packed(head: bytes, name: str, tmp_path: Path) -> None:
    path = tmp_path / "x.asc"
    path.write_bytes(head + bytes(20))
    with pytest.raises(UsageError, match=f"it is packed \\({name}\\)"):
        list(read(path))


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("//-----\nMicrochip Technology Inc.\nCAN BUS Analyzer\n//-----\n1;RX;0x1;0;\n", "Microchip CAN BUS Analyzer"),
        ("166.064000 CXX GVRET-PC Output\n166.064000 R11 0000021A FE 36\n", "OVMS (CRTD)"),
        ("1320745424.002 2R29 18FEF100 FA 01\n", "OVMS (CRTD)"),
        ("ID,Data Bytes\n0000021A,FE 36 12\n", "SavvyCAN without times (Generic ID)"),
        ("Version,5\nLine,Abs Time(Sec),Rel Time (Sec),Status,Er,Tx\n", "Vehicle Spy"),
        ('"CANopen Magic Ultimate"\n', "CANopen Magic"),
        (";  CAN Logger trace file\n;\n", "CAN Logger"),
        ("time,addr,bus,data\n1.5,291,0,0x00\n", "Cabana"),
        ("# Logger type: CANLogger2000\n# HW rev: 7.1x\nTimestamp;Type;ID;Data\n", "CSS Electronics CLX000"),
        ("          Kvaser Memorator Log\n          ====\n", "Kvaser Memorator"),
        ('"No.","Time","Source","Destination","Protocol","Length","Info"\n', "Wireshark (packets as CSV)"),
        ("A000057.055 09FF7 1FF1A 3F9FDB\n", "Actisense (N2K ASCII)"),
        ("17:33:21.107 R 19F51323 01 2F 30\n", "Yacht Devices (RAW)"),
        ("2011-11-24-22:42:04.388,2,127251,36,255,8,7d,0b\n", "canboat"),
        ("t1232AABB\rT18FEF10010\r", "an adapter of Lawicel (SLCAN)"),
        ("   Chn Identifier Flg   DLC  D0...1...2...3...4...5...6..D7       Time     Dir\n", "Kvaser CANKing"),
        ("ASCII Trace IXXAT Minimon 3 Version: 3.4\n", "IXXAT"),
        ("[RTU]>Tx > 12:01:02:345 - 01  03  00  00  00  0A  C5  CD\n", "a serial line as text"),
        ("Tx:000001-01 03 00 00 00 0A C5 CD\n", "a serial line as text"),
        ("DEBUG transaction:140 SEND: 0x1 0x3 0x0 0x0 0x0 0x1 0x84 0xa\n", "a serial line as text"),
        ("12.11.2023 10:11:12.123 [TX] - 01 03 00 00 00 01 84 0A \n", "a serial line as text"),
    ],
)
@pytest.mark.parametrize("ending", ["txt", "log", "trc", "csv"])
def test_a_log_of_another_program_is_refused_by_its_name(text: str, name: str, ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"x.{ending}"
    path.write_text(text)
    with pytest.raises(UsageError, match=re.escape(f"it is a log of {name}, which is not read")):
        list(read(path))


def test_a_log_in_utf_16_and_one_with_semicolons_say_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "x.asc").write_text(" 0.1 1 123 Rx d 1 AA\n", encoding="utf-16")
    with pytest.raises(UsageError, match="it is a text in UTF-16"):
        list(read(tmp_path / "x.asc"))
    (tmp_path / "x.csv").write_text("timestamp;arbitration_id;extended;remote;error;dlc;data\n", encoding="utf-8")
    with pytest.raises(UsageError, match="saved with semicolons"):
        list(read(tmp_path / "x.csv"))


def test_a_log_whose_format_no_document_explains_is_refused_by_its_ending(tmp_path: Path) -> None:
    (tmp_path / "LOG00000.KMF").write_bytes(bytes(range(1, 200)))
    with pytest.raises(UsageError, match=r"LOG00000.KMF: it is a log of Kvaser Memorator, which is not read"):
        list(read(tmp_path / "LOG00000.KMF"))


def test_a_file_of_four_gigabytes_of_nothing_is_refused_at_once(tmp_path: Path) -> None:
    for ending in ("log", "blf", "pcap", "csv", "mf4", "db", "jsonl"):
        path = tmp_path / f"x.{ending}"
        with path.open("wb") as file:
            file.truncate(4 << 30)
        with pytest.raises(UsageError, match=f"x.{ending}: "):
            list(read(path))
