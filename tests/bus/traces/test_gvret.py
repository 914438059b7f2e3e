"""SavvyCAN's CSV: lines as its `saveNativeCSVFile` writes them, and those of its first version."""

import io
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import US
from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read, write
from fieldrig_bus.can.codec import decode, encode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.traces import gvret

FIRST = "Time Stamp,ID,Extended,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n"
SECOND = f"{gvret.HEAD}\n"


def messages(text: str, odd: Oddities | None = None) -> list[tuple[int, str, object]]:
    found = gvret.read(io.BytesIO(text.encode()), odd)
    return [(one.time_ns // US, one.bus, decode(one.data)) for one in found]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (FIRST + "166064000,0000027A,false,0,3,30,30,0D,\n", (166064000, "can0", CanFrame(0x27A, b"\x30\x30\x0d"))),
        (SECOND + "39747,000005EB,false,Rx,0,2,E8,45,00,00,00,\n", (39747, "can0", CanFrame(0x5EB, b"\xe8\x45"))),
        (SECOND + "5,18FF0233,true,Tx,1,1,7,\r\n", (5, "can1", CanFrame(0x18FF0233, b"\x07", is_extended=True))),
        (SECOND + "5,00000800,false,Rx,0,0\n", (5, "can0", CanFrame(0x800, is_extended=True))),
    ],
)  # fmt: skip
def test_lines_of_both_versions_are_frames(text: str, message: object, tmp_path: Path) -> None:
    assert messages(text) == [message]
    path = tmp_path / "log.csv"  # the ending is also that of python-can
    path.write_text(text)
    assert len(list(read(path))) == 1


def test_a_line_that_goes_on_without_commas_is_refused_at_once() -> None:
    """Ways to divide its digits are as many as 2 to the power of their number, and they were tried one by one."""
    odd = Oddities()
    assert messages(f"{FIRST}1,000005EB,false,0,1,E8\n2,000005EB,false,0,8,{'AB' * 1000}!\n", odd) == [
        (1, "can0", CanFrame(0x5EB, b"\xe8"))
    ]
    assert [each.place for each in odd] == ["line 3"]


def test_a_log_is_written_as_savvycan_writes_it(tmp_path: Path) -> None:
    odd, path = Oddities(), tmp_path / "x.gvret"
    frames = [CanFrame(0x5EB, b"\xe8\x45"), CanFrame(0x1, b"\x07", is_extended=True), CanFrame(0x1, is_remote=True)]
    entries = [TraceEntry(39747828 * US, f"can{n}", "can", "", encode(frame)) for n, frame in enumerate(frames)]
    assert write([*entries, entries[0]._replace(bus="axis")], path, odd) == 3
    assert path.read_text() == (
        "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n"
        "39747828,000005EB,false,Rx,0,2,E8,45,00,00,00,00,00,00,\n"
        "39747828,00000001,true,Rx,1,1,07,00,00,00,00,00,00,00,\n"
        "39747828,000005EB,false,Rx,2,2,E8,45,00,00,00,00,00,00,\n"
    )
    assert [str(one) for one in odd] == ["buses have only numbers in the format: axis is 2"]
    assert list(read(path))[:2] == entries[:2]


def test_lines_that_are_none_are_reported() -> None:
    odd = Oddities()
    text = SECOND + "5,100,false,Rx,0,9,01\n5,FFFFFFFF,true,Rx,0,0\n5,100,perhaps,Rx,0,0\n6,100,false,Rx,0,0\n"
    assert messages(text, odd) == [(6, "can0", CanFrame(0x100))]
    assert [(one.place, one.count) for one in odd] == [("line 2", 3)]
    with pytest.raises(UsageError, match="line 2 is no line of SavvyCAN's CSV"):
        messages(SECOND + "nothing,\n")


@given(st.text("0123456789ABCDEFtruefalsRx,.-\n", max_size=200))
def test_any_text_is_a_log_or_refused(text: str) -> None:
    with suppress(UsageError):
        messages(SECOND + text)
