# ruff: noqa: E501  lines of logs are long
"""Lines of TRC logs, from PEAK's document of the format and the files of PCAN-View as python-can's own tests have them."""

import io
from pathlib import Path

import pytest

from fieldrig.clock import MS
from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace_files import read
from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.codec import decode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import BusState, CanError, CanState, ErrorKind, Notice
from fieldrig_bus.traces import trc

TRC_LINES = [
    ("", "     1)     17535  00000100  2  01 02\n", CanFrame(0x100, b"\x01\x02", True)),
    ("", "     1)     17535      0704  1  RTR\n", CanFrame(0x704, is_remote=True, remote_length=1)),
    ("", "     1)     17535      0008  4  ERROR 00 19 08 08\n", CanError(ErrorKind.ACK, Place.ACK, 0, 0, True, False, 8, 8)),
    ("", "     1)     17535  FFFFFFFF  4  00 00 00 04  BUSLIGHT\n", BusState(CanState.WARNING, 0, 0)),
    (";$FILEVERSION=1.1\n", "     1)     17535.4  Rx         0000  2  01 02 \n", CanFrame(0, b"\x01\x02")),
    (";$FILEVERSION=1.1\n", "     1)     17540.3  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY \n", BusState(CanState.PASSIVE, 0, 0)),
    (";$FILEVERSION=1.2\n", "     1)     17535.400 1  Rx         0000  2  01 02\n", CanFrame(0, b"\x01\x02")),
    (";$FILEVERSION=1.3\n", "     1)     17535.400 1  Tx    00000100 -  2    01 02\n", CanFrame(0x100, b"\x01\x02", True)),
    (";$FILEVERSION=2.0\n;$COLUMNS=N,O,T,I,d,l,D\n", "      1     17535.400 FB     0704 Rx 12 " + "01 " * 12 + "\n", CanFrame(0x704, b"\x01" * 12, is_fd=True, is_bit_rate_switched=True)),
    (";$FILEVERSION=2.0\n;$COLUMNS=N,O,T,I,d,l,D\n", "      2     17540.300 ST          Rx    00 00 00 08\n", BusState(CanState.PASSIVE, 0, 0)),
    (";$FILEVERSION=2.0\n;$COLUMNS=N,O,T,I,d,l,D\n", "      6     17535.400 ER          Rx    04 00 02 00 00 \n", CanError(ErrorKind.STUFF, Place.ID_28_21, 0, 0, True, False, 0, 0)),
    (";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n", "      6     17535.400 ER 1         - Rx -  5    04 01 02 08 05 \n", CanError(ErrorKind.STUFF, Place.ID_28_21, 0, 0, False, False, 5, 8)),
    (";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n", "      9     17535.400 ST 1         - Rx -  4    00 00 00 08 \n", BusState(CanState.PASSIVE, 0, 0)),
    (";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n", "      1     17535.400 FD 1      0704 Rx -  9    " + "01 " * 12 + "\n", CanFrame(0x704, b"\x01" * 12, is_fd=True)),
    (";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n", "     12     48937.600 RR 1      0704 Rx -  1\n", CanFrame(0x704, is_remote=True, remote_length=1)),
]  # fmt: skip


@pytest.mark.parametrize(("head", "line", "message"), TRC_LINES, ids=range(len(TRC_LINES)))
def test_a_line_of_pcan_view_is_read(head: str, line: str, message: CanFrame | Notice) -> None:
    (found,) = trc.read(io.BytesIO(f"{head};$STARTTIME=44548.6028595139\n;\n{line}".encode()))
    assert (found.bus, decode(found.data)) == ("can0", message)
    start_ns = 1_639_837_687_062_001_000  # 18.12.2021 14:28:07.062, as the comment of that file says
    assert (found.time_ns - start_ns) // MS in (17_535, 17_540, 48_937)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (";$FILEVERSION=3.0\n", "line 1: version '3.0' of the format is not known"),
        (";$FILEVERSION=2.0\n;$COLUMNS=N,O,T\n", "line 2: the columns 'N,O,T': expected at least"),
        (";$FILEVERSION=1.1\n 1) 2.0 Rx 0001 2 01\n", "line 2 is not a frame of a TRC log: 1 bytes of data, and 2"),
        (";$FILEVERSION=1.1\n 1) now Rx 0001 0\n", "line 2 is not a frame of a TRC log: 'now' is not a time"),
        # a line of another tool whose traces end in .trc: its words are no columns
        ('"00:02:20";"83";"Std";"";"00 00 00 01 20 00 00 "\n', "line 1 is not a frame of a TRC log: '\"00:02:20"),
    ],
)
def test_a_trc_log_that_cannot_be_read_is_named(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "x.trc"
    path.write_text(text)
    with pytest.raises(UsageError) as wrong:
        list(read(path))
    assert wrong.value.what.startswith(f"{path}: {message}")


def test_what_is_odd_in_a_trc_log_is_read_and_reported() -> None:
    odd = Oddities()
    text = ";$FILEVERSION=1.1\n;$STARTTIME=today\n 1) 1.0 Rx 0001 0\n 2) 2.0 Event 0001 0\n 3) 3.0 Rx 0001 z\n 4) 4.0 Rx 00"
    assert len(list(trc.read(io.BytesIO(text.encode()), odd))) == 1
    assert [str(oddity).partition(":")[0] for oddity in odd] == ["line 2", "line 4", "line 5", "line 6"]


@pytest.mark.parametrize("digits", ["-5", "-100", "123456789", "FFFFFFFF0"])
def test_an_identifier_that_no_frame_has_is_left_out(digits: str) -> None:
    odd = Oddities()
    text = f";$FILEVERSION=1.1\n     1)     17535.4  Rx     {digits}  1  01\n     2)     17535.5  Rx     0123  1  01\n"
    (found,) = trc.read(io.BytesIO(text.encode()), odd)
    assert decode(found.data) == CanFrame(0x123, b"\x01")
    assert [one.place for one in odd] == ["line 2"]


@pytest.mark.parametrize("days", ["today", "1e999000000", "-1e999999999", "nan"])
def test_a_start_that_is_none_is_odd(days: str) -> None:
    odd = Oddities()
    text = f";$FILEVERSION=2.1\n;$STARTTIME={days}\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n 1 1.000 DT 1 0123 Rx - 1 05\n"
    [found] = trc.read(io.BytesIO(text.encode()), odd)
    assert "the start is none, and times count from 0" in " ".join(map(str, odd))
    assert found.time_ns == 1_000_000


@pytest.mark.parametrize(
    "line",
    [
        "     1)     17535  0300  2  01 02\n",
        "     1)     17535.4  Rx         0300  2  01 02\n",
        "     1)     17535.400 1  Tx         0300  2  01 02\n",
        "     1)     17535.400 1  Rx         0300 -  2    01 02\n",
        "     1)     17535,4  Rx         0300  2  01 02\n",
    ],
)
def test_a_part_of_a_log_without_its_head_is_read_by_its_columns(line: str, tmp_path: Path) -> None:
    (tmp_path / "part.txt").write_text(line + line)
    first, _ = read(tmp_path / "part.txt")
    assert (decode(first.data), first.time_ns // MS) == (CanFrame(0x300, b"\x01\x02"), 17_535)


def test_a_start_with_a_decimal_comma_is_a_time() -> None:
    text = ";$FILEVERSION=1.1\n;$STARTTIME=44548,6028595139\n     1)     0.0  Rx         0300  0\n"
    [found] = trc.read(io.BytesIO(text.encode()))
    assert found.time_ns // MS == 1_639_837_687_062


def test_columns_that_are_not_said_are_asked_for() -> None:
    with pytest.raises(UsageError, match=r"line 2 is not a frame of a TRC log: no line before it says the columns"):
        list(trc.read(io.BytesIO(b";$FILEVERSION=2.0\n 1 1059.900 DT 0300 Rx 2 00 00\n")))
