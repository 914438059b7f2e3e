"""Logs of CANHacker and of the CARBUS Analyzer: lines as their documents have them, with any ends of lines."""

import io
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS, US
from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read
from fieldrig_bus.can.codec import decode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.traces import trc

OLD = "Time   ID     DLC Data                    Comment\r\n"
SECOND = "@ TEXT @ 2 @ 64 @ 0 @ 55 @ 10078 @ 00:00:10.078 @\r"
THIRD = "@ TEXT @ 3 @ 64 @ 0 @ 3008 @ 82453 @ 00:01:22.453 @\n# $LocalTime=12:05:10.123\n"
GLOW = "26,678369\t1\t80000004\t001\t8\t00 00 00 00 00 00 00 00\t00000000\t        \t\n"


def messages(text: str, odd: Oddities | None = None) -> list[tuple[int, str, object]]:
    found = trc.read(io.BytesIO(text.encode("latin-1")), odd)
    return [(one.time_ns, one.bus, decode(one.data)) for one in found]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (OLD + "00,012 0C7 3 00 D0 04 doors\r\n", (12 * MS, "can0", CanFrame(0x0C7, b"\x00\xd0\x04"))),
        (OLD + "1,5 00D00422 1 AB CD no data\r\n", (1500 * MS, "can0", CanFrame(0xD00422, b"\xab", is_extended=True))),
        (SECOND + "46,016\t1\t0004\t45A\t2\t5A 04  \t00000000\tZ\t\r", (46016 * MS, "can0", CanFrame(0x45A, b"Z\x04"))),
        (THIRD + GLOW, (26678369 * US, "can0", CanFrame(0x001, bytes(8)))),
        (THIRD + "0,000001\t2\t0004\t18FEF100\t0\t\t0\n", (US, "can1", CanFrame(0x18FEF100, b"", is_extended=True))),
        (THIRD + "0,000001\t1\t0004\t440\t2\t01\tFF\n", (US, "can0", CanFrame(0x440, b"\x01\xff"))),
    ],
)  # fmt: skip
def test_a_line_is_a_frame(text: str, message: object, tmp_path: Path) -> None:
    assert messages(text) == [message]
    for name in ("log.trc", "log.txt"):
        (tmp_path / name).write_bytes(text.encode())
        assert len(list(read(tmp_path / name))) == 1


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("x\t1\t0004\t440\t1\t01\n", "'x' is not a time in seconds"),
        ("0,1\t1\t0004\t440\t8\t01 02\n", "2 bytes of data, and 8 are announced"),
        ("0,1\t1\t0004\t440\t99\t01 02\n", "identifier 440 with 99 bytes"),
        ("0,1\t1\t0004\tFFFFFFFF\t0\n", "identifier FFFFFFFF with 0 bytes"),
        ("0,1\t1\n", "expected time, identifier, length and data"),
    ],
)
def test_a_line_that_is_none_is_left_out_and_said_with_its_place(line: str, reason: str) -> None:
    odd = Oddities()
    assert len(messages(THIRD + line + GLOW, odd)) == 1
    [said] = map(str, odd)
    assert said.startswith("line 3: lines that cannot be read are left out: ")
    assert reason in said
    with pytest.raises(UsageError, match="line 3 is not a frame of a log of CANHacker"):
        messages(THIRD + line)


def test_ends_of_lines_may_be_cut_apart_by_the_reads_of_a_file() -> None:
    class Slow(io.BytesIO):
        def read1(self, size: int | None = -1) -> bytes:
            return super().read1(1)

    text = (OLD + "".join(f"00,{n:03} 123 1 {n:02X}\r\n" for n in range(200))).encode()
    odd = Oddities()
    entries: list[TraceEntry] = list(trc.read(Slow(text), odd))
    assert [entry.data[-1] for entry in entries] == list(range(200))
    assert (list(odd), odd.number) == ([], 201)


@given(st.sampled_from([OLD, SECOND, THIRD]), st.text("0123456789ABCDEFx,.\t\r\n @#", max_size=200))
def test_any_lines_are_read_or_refused_in_words(head: str, text: str) -> None:
    with suppress(UsageError):
        messages(head + text)
