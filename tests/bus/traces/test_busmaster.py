"""Logs of BUSMASTER: lines as its own logs have them; the times agree with Wireshark's reading of the same lines."""

import io
from contextlib import suppress
from datetime import datetime
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS, US, S
from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace_files import read
from fieldrig_bus.can.codec import decode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import CanError
from fieldrig_bus.traces import candump

HEAD = (
    "***BUSMASTER Ver 3.2.2***\r\n***PROTOCOL CAN***\r\n***NOTE: PLEASE DO NOT EDIT THIS DOCUMENT***\r\n"
    "***[START LOGGING SESSION]***\r\n***START DATE AND TIME 8:8:2014 23:59:50:500***\r\n***{base}***\r\n"
    "***{mode} MODE***\r\n***START CHANNEL BAUD RATE***\r\n***CHANNEL 1 - Kvaser - 500000 bps***\r\n"
    "***END CHANNEL BAUD RATE***\r\n***<Time><Tx/Rx><Channel><CAN ID><Type><DLC><DataBytes>***\r\n"
)
END = "***END DATE AND TIME 9:8:2014 0:0:20:0***\r\n***[STOP LOGGING SESSION]***\r\n"
START_NS = int(datetime(2014, 8, 8, 23, 59, 50).astimezone().timestamp()) * S + 500 * MS


def messages(
    text: str, mode: str = "SYSTEM", base: str = "HEX", odd: Oddities | None = None
) -> list[tuple[int, str, object]]:
    found = candump.read(io.BytesIO((HEAD.format(mode=mode, base=base) + text + END).encode()), odd)
    return [(one.time_ns - START_NS, one.bus, decode(one.data)) for one in found]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("23:59:51:0020 Rx 1 0x023 s 1 40 ", CanFrame(0x23, b"\x40")),
        ("23:59:51:0020 Tx 1 0x18FEF100 x 2 03 E0", CanFrame(0x18FEF100, b"\x03\xe0", is_extended=True)),
        ("23:59:51:0020 Rx 1 0x7FF sr 8 ", CanFrame(0x7FF, is_remote=True, remote_length=8)),
        ("23:59:51:0020 Rx 1 0x1 xr 0 ", CanFrame(1, is_extended=True, is_remote=True)),
        ("23:59:51:002 Rx 1 0000021A s 0", CanFrame(0x21A)),  # as SavvyCAN writes it
        (f"23:59:51:0020 Rx 1 0x100 s-fd 12 {'01 ' * 12}", CanFrame(0x100, b"\x01" * 12, is_fd=True)),
        (f"23:59:51:0020 Rx 1 0x100 s-fd C {'01 ' * 12}", CanFrame(0x100, b"\x01" * 12, is_fd=True)),
    ],
)
def test_a_line_is_a_frame(line: str, message: CanFrame, tmp_path: Path) -> None:
    assert messages(line + "\r\n") == [(502 * MS, "can0", message)]
    for name in ("x.log", "x.txt"):
        (tmp_path / name).write_text(HEAD.format(mode="SYSTEM", base="HEX") + line + "\n")
        assert len(list(read(tmp_path / name))) == 1


def test_numbers_are_decimal_where_the_head_says_so() -> None:
    assert messages("23:59:51:0 Rx 2 291 s 2 10 255\n", base="DEC") == [
        (500 * MS, "can1", CanFrame(0x123, b"\x0a\xff"))
    ]


def test_an_error_frame_is_one() -> None:
    [found] = messages("23:59:51:0020 Rx 1 ERR Stuff Error\n")
    assert isinstance(found[2], CanError)


@pytest.mark.parametrize(
    ("mode", "clocks", "at_ms"),
    [
        ("SYSTEM", ["23:59:51:0000", "00:00:01:0005", "00:00:01:0000"], [500, 10_500.5, 10_500]),
        ("ABSOLUTE", ["00:00:00:0010", "00:00:10:0000", "25:00:00:0000"], [1, 10_000, 90_000_000]),
        ("RELATIVE", ["00:00:00:0010", "00:00:10:0000", "00:00:00:0000"], [1, 10_001, 10_001]),
    ],
)
def test_times_are_those_of_the_mode(mode: str, clocks: list[str], at_ms: list[float]) -> None:
    text = "".join(f"{clock} Rx 1 0x1 s 0\n" for clock in clocks)
    found = messages(text, mode)
    assert [one[0] for one in found] == [round(ms * MS) for ms in at_ms]


def test_a_second_session_begins_at_its_own_time() -> None:
    line = "00:00:01:0000 Rx 1 0x1 s 0\n"
    second = HEAD.format(mode="ABSOLUTE", base="HEX").replace("23:59:50:500", "23:59:55:500")
    found = messages(line + END + second + line, "ABSOLUTE")
    assert [one[0] // S for one in found] == [1, 6]


def test_lines_that_are_none_are_left_out_and_said_with_their_place() -> None:
    odd = Oddities()
    wrong = "23:59:51:0000 Rx 1 0x1 s 2 01\n23:59:51:0000 Rx 1 0x3FFFFFFF x 0\nnothing\n"
    assert len(messages(wrong + "23:59:51:0000 Rx 1 0x1 s 0\n", odd=odd)) == 1
    assert [(one.place, one.count) for one in odd] == [("line 12", 3)]
    with pytest.raises(UsageError, match="line 12 is not a frame of BUSMASTER: 1 bytes of data"):
        messages(wrong)


def test_a_log_of_another_protocol_is_refused() -> None:
    with pytest.raises(UsageError, match=r"line 2: a log of J1939, of BUSMASTER, is not read"):
        list(candump.read(io.BytesIO(b"***BUSMASTER Ver 3.2.2***\n***PROTOCOL J1939***\n")))


def test_a_wrong_date_is_said() -> None:
    odd = Oddities()
    text = HEAD.format(mode="ABSOLUTE", base="HEX").replace("8:8:2014", "31:2:2014") + "0:0:0:5 Rx 1 0x1 s 0\n"
    assert [one.time_ns for one in candump.read(io.BytesIO(text.encode()), odd)] == [500 * US]
    assert [one.what for one in odd] == ["the date is none, and times count from 0"]


@given(st.text("0123456789ABCDEFRTxsr-fd:* \n", max_size=200), st.sampled_from(["SYSTEM", "ABSOLUTE", "RELATIVE"]))
def test_any_text_is_a_log_or_refused(text: str, mode: str) -> None:
    with suppress(UsageError):
        messages(text, mode)
