# ruff: noqa: E501  lines of logs are long
"""Lines of ASC logs, from CANoe's and CANalyzer's files as python-can's own tests have them."""

import io
import time
from collections.abc import Iterator

import pytest

from fieldrig.clock import MS, US, S
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.codec import decode, encode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import BusState, CanError, CanState, ErrorKind, Notice
from fieldrig_bus.traces import asc

ASC_HEAD = (
    "date Sam Sep 30 15:06:13.191 2017\nbase hex  timestamps absolute\ninternal events logged\n// version 9.0.0\n"
)
ASC_FRAMES = [
    ("   2.501000 1  123x            Rx   d 2 01 02  Length = 240015 BitCount = 124 ID = 291x", CanFrame(0x123, b"\x01\x02", True)),
    ("   2.501000 1  C8              Tx   d 0", CanFrame(0xC8)),
    ("   2.501000 1 200 Tx r Length = 1704000 BitCount = 145 ID = 88888888x", CanFrame(0x200, is_remote=True)),
    ("   2.501000 1 300 Rx r 8 Length = 1704000", CanFrame(0x300, is_remote=True, remote_length=8)),
    ("   2.501000 1 3FF Tx d D 55 AA 01 02 03 04 05 06  Length = 1", CanFrame(0x3FF, bytes.fromhex("55aa010203040506"))),
    ("   2.501000 CANFD   1 Rx  30a  Name_12  1 1 9  12 " + "01 " * 12 + "  102203  133   303000 e0006659", CanFrame(0x30A, b"\x01" * 12, is_fd=True, is_bit_rate_switched=True)),
    ("   2.501000 CANFD   1 Tx  1C4D80A7x   0 1 8  8 12 c2 03 04 05 06 07 08   102203  133   301000 e0006659", CanFrame(0x1C4D80A7, bytes.fromhex("12c2030405060708"), True, is_fd=True)),
    ("   2.501000 CANFD   1 Tx  C4   0 0 2  2 12 c2   102203  133   200000 e0006659", CanFrame(0xC4, b"\x12\xc2")),
    ("   2.501000 CANFD   1 Tx  50005x  0 1 5 0 140000 73 200050 7a60", CanFrame(0x50005, is_extended=True, is_remote=True, remote_length=5)),
]  # fmt: skip


def asc_of(text: str, odd: Oddities | None = None) -> list[TraceEntry]:
    return list(asc.read(io.BytesIO(text.encode()), odd))


@pytest.fixture(autouse=True)
def utc(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """ASC has the local time, which is that of London in winter here."""
    monkeypatch.setenv("TZ", "UTC0")
    time.tzset()
    yield
    monkeypatch.undo()
    time.tzset()


@pytest.mark.parametrize(("line", "frame"), ASC_FRAMES, ids=range(len(ASC_FRAMES)))
def test_a_line_of_canoe_is_read(line: str, frame: CanFrame) -> None:
    (found,) = asc_of(f"{ASC_HEAD}Begin Triggerblock Sam Sep 30 15:06:13.191 2017\n{line}\n")
    assert (found.bus, decode(found.data)) == ("can0", frame)
    assert found.time_ns == 1_506_783_973_191 * MS + 2_501 * MS


@pytest.mark.parametrize(
    ("line", "notice"),
    [
        ("2.501 1 ErrorFrame", CanError(ErrorKind.BIT, Place.UNSPECIFIED, 0, 0, False, False, 0, 0)),
        ("2.501 1 ErrorFrame ECC: 10100010", CanError(ErrorKind.STUFF, Place.ID_28_21, 0, 0, False, False, 0, 0)),
        (
            "2.501 1 ErrorFrame Flags = 0xe CodeExt = 0x20a2 Code = 0xd9 ID = 0 DLC = 0 Position = 5",
            CanError(ErrorKind.ACK, Place.ACK, 0, 0, True, False, 0, 0),
        ),
        (
            "30.8 CANFD   1 Tx ErrorFrame Not Acknowledge error, dominant error flag fffe c7 31ca Arb. 556",
            CanError(ErrorKind.ACK, Place.UNSPECIFIED, 0, 0, False, False, 0, 0),
        ),
        ("0.015991 CAN 1 Status:chip status error passive - TxErr: 132 RxErr: 0", BusState(CanState.PASSIVE, 132, 0)),
        ("0.015991 CAN 1 Status:chip status bus off", BusState(CanState.BUS_OFF, 256, 0)),
    ],
)
def test_an_error_of_canoe_is_read(line: str, notice: Notice) -> None:
    assert [decode(found.data) for found in asc_of(f"{ASC_HEAD}{line}\n")] == [notice]


def test_a_controller_that_is_bus_off_has_counted_beyond_a_byte() -> None:
    line = "0.015991 CAN 1 Status:chip status bus off - TxErr: 255 RxErr: 3"
    assert [decode(found.data) for found in asc_of(f"{ASC_HEAD}{line}\n")] == [BusState(CanState.BUS_OFF, 256, 3)]


def test_a_local_time_that_comes_twice_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TZ", "Europe/Berlin")
    time.tzset()
    for hours, said in ((0, 0), (1, 1), (2, 0)):
        odd = Oddities()
        sent = [TraceEntry(0, "can0", "can", "", encode(CanFrame(1)))]
        assert asc.write(sent, io.BytesIO(), 1_729_989_000 * S + hours * 3600 * S, odd) == 1
        assert len(odd) == said


def test_relative_times_and_decimal_numbers_are_read() -> None:
    text = "date Sat Sep 30 03:06:13.191 pm 2017\nbase dec  timestamps relative\n 1.5 1 16 Rx d 2 1 255\n 0.25 2 17x Rx d 0\n"
    first, second = asc_of(text)
    assert (decode(first.data), decode(second.data)) == (CanFrame(16, b"\x01\xff"), CanFrame(17, is_extended=True))
    assert second.time_ns - first.time_ns == 250 * MS
    assert first.time_ns == 1_506_783_973_191 * MS + 1_500 * MS
    assert second.bus == "can1"


def test_a_relative_time_counts_from_the_line_before_whatever_it_is() -> None:
    head = "date Sat Sep 30 15:06:13.191 2017\nbase hex  timestamps relative\n"
    between = (
        " 0.5 1  Statistic: D 0 R 0\n 0.25 1 123 TxRq d 0\n 0.125 1 J1939TP FEE3p 6\n 1.0 1 123 Rx d 9 1\n// 7.0 x\n"
    )
    first, second = asc_of(f"{head} 0.0 Start of measurement\n 1.5 1 16 Rx d 0\n{between} 0.0625 1 17 Rx d 0\n")
    assert second.time_ns - first.time_ns == 1_937_500 * US


@pytest.mark.parametrize(
    ("date", "seconds"),
    [
        ("mar. déc. 5 15:06:13.191 2017", 1_512_486_373),
        ("jeu. août 24 15:06:13 2017", 1_503_587_173),
        ("mer. juin 7 01:00:00 2017", 1_496_797_200),
        ("ven. juil. 7 01:00:00 2017", 1_499_389_200),
        ("lun gen 15 15:06:13 2018", 1_516_028_773),
        ("Mit Mrz 3 10:15:00 2021", 1_614_766_500),
        ("周二 十二月 5 15:06:13 2017", 1_512_486_373),
        ("火 12月 5 15:06:13 2017", 1_512_486_373),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "cp1252"])
def test_a_date_is_read_in_the_language_of_the_computer(date: str, seconds: int, encoding: str) -> None:
    text = f"date {date}\nbase hex  timestamps absolute\n  0.5 1 123 Rx d 0\n"
    if encoding == "utf-8" or date.isascii() or "é" in date or "û" in date:
        [found] = asc.read(io.BytesIO(text.encode(encoding)))
        assert found.time_ns // S == seconds


def test_the_first_line_after_the_header_is_not_lost() -> None:
    assert len(asc_of("date Sat Sep 30 15:06:13.191 2017\nbase hex  timestamps absolute\n 0.1 1 123 Rx d 0\n")) == 1


@pytest.mark.parametrize(
    ("line", "report"),
    [
        (" 0.2 1 123 TxRq d 0", "line 5: requests to send (TxRq) are left out, as the frames follow them"),
        (" 0.2 1 J1939TP FEE3p 6 0 0 - Rx d 1 A0", "line 5: lines that are no CAN frames are left out"),
        (" 0.2 1 123 Rx d 4 01", "line 5: frames that cannot be read are left out: 1 bytes of data, and 4 are announced"),
        ("Begin Triggerblock Sam Sep 31 15:06:13.191 2017", "line 5: the date is none, and times count from 0: Sep 31 15:06:13.191 2017"),
        (" 0.2 1 12", "line 5: lines that are no CAN frames are left out"),
    ],
)  # fmt: skip
def test_what_is_odd_in_an_asc_log_is_read_and_reported(line: str, report: str) -> None:
    odd = Oddities()
    assert len(asc_of(f"{ASC_HEAD}{line}\n 0.3 1 123 Rx d 0\n", odd)) == 1
    assert [str(oddity) for oddity in odd] == [report]
