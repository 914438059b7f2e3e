"""SDO block transfer, CiA 301 7.2.4.3.9 to 7.2.4.3.16, byte by byte.

31C3h is the check of "123456789" in 7.2.4.3.16 (CRC-16 CCITT, initial value 0).
"""

from pathlib import Path
from typing import Any

import pytest
from canopen_bench import CanopenBench, Script
from eds_oddities import DEVICE_TYPE

OBJECTS = f"""
{DEVICE_TYPE}[1017]
ParameterName=Producer heartbeat time
DataType=0x0006
AccessType=rw
[2000]
ParameterName=Text
DataType=0x0009
AccessType=rw
DefaultValue=123456789
[2001]
ParameterName=Write only
DataType=0x0005
AccessType=wo
[2002]
ParameterName=Limited
DataType=0x0003
AccessType=rw
HighLimit=10
[2003]
ParameterName=Empty
DataType=0x0009
AccessType=rw
[2004]
ParameterName=Anything
ObjectType=2
"""


def make(folder: Path, **settings: Any) -> CanopenBench:
    (folder / "block.eds").write_text(OBJECTS)
    bench = CanopenBench(folder / "block.eds", **settings)
    bench.take()
    return bench


@pytest.fixture
def block(tmp_path: Path) -> CanopenBench:
    return make(tmp_path)


def say(bench: CanopenBench, request: str) -> list[str]:
    """Return all answers of the server to one request."""
    return [frame.removeprefix("585#") for frame in bench.send(f"605#{request}")]


HEARTBEAT_TIME = ("40 17 10 00 00 00 00 00", "4b 17 10 00 00 00 00 00")
"""An expedited upload of 1017h, which shows that the server has no transfer open."""

SCRIPTS: dict[str, Script] = {
    "download with size and CRC": [
        ("c6 00 20 00 09 00 00 00", "a4 00 20 00 7f 00 00 00"),
        ("01 31 32 33 34 35 36 37", ""),
        ("82 38 39 00 00 00 00 00", "a2 02 7f 00 00 00 00 00"),
        ("d5 c3 31 00 00 00 00 00", "a1 00 00 00 00 00 00 00"),
    ],
    "download without size and CRC": [
        ("c0 17 10 00 00 00 00 00", "a0 17 10 00 7f 00 00 00"),
        ("81 e8 03 00 00 00 00 00", "a2 01 7f 00 00 00 00 00"),
        ("d5 ff ff 00 00 00 00 00", "a1 00 00 00 00 00 00 00"),
        ("40 17 10 00 00 00 00 00", "4b 17 10 00 e8 03 00 00"),
    ],
    "download of nothing": [
        ("c6 00 20 00 00 00 00 00", "a4 00 20 00 7f 00 00 00"),
        ("81 00 00 00 00 00 00 00", "a2 01 7f 00 00 00 00 00"),
        ("dd 00 00 00 00 00 00 00", "a1 00 00 00 00 00 00 00"),
    ],
    "download with a wrong CRC": [
        ("c6 00 20 00 09 00 00 00", "a4 00 20 00 7f 00 00 00"),
        ("01 31 32 33 34 35 36 37", ""),
        ("82 38 39 00 00 00 00 00", "a2 02 7f 00 00 00 00 00"),
        ("d5 c3 32 00 00 00 00 00", "80 00 20 00 04 00 04 05"),
        ("d5 c3 31 00 00 00 00 00", "80 00 00 00 01 00 04 05"),
    ],
    "sequence number 0, and one beyond the block": [
        ("c2 00 20 00 09 00 00 00", "a0 00 20 00 7f 00 00 00"),
        ("00 31 32 33 34 35 36 37", "80 00 20 00 03 00 04 05"),
    ],
    "a gap is reported at the end of the block and filled": [
        ("c6 00 20 00 09 00 00 00", "a4 00 20 00 7f 00 00 00"),
        ("82 38 39 00 00 00 00 00", "a2 00 7f 00 00 00 00 00"),
        ("01 31 32 33 34 35 36 37", ""),
        ("83 38 39 00 00 00 00 00", "a2 01 7f 00 00 00 00 00"),
        ("81 38 39 00 00 00 00 00", "a2 01 7f 00 00 00 00 00"),
        ("d5 c3 31 00 00 00 00 00", "a1 00 00 00 00 00 00 00"),
    ],
    "a segment that comes twice counts once": [
        ("c6 00 20 00 09 00 00 00", "a4 00 20 00 7f 00 00 00"),
        ("01 31 32 33 34 35 36 37", ""),
        ("01 31 32 33 34 35 36 37", ""),
        ("82 38 39 00 00 00 00 00", "a2 02 7f 00 00 00 00 00"),
        ("d5 c3 31 00 00 00 00 00", "a1 00 00 00 00 00 00 00"),
    ],
    "wrong command specifier at the end": [
        ("c6 00 20 00 09 00 00 00", "a4 00 20 00 7f 00 00 00"),
        ("01 31 32 33 34 35 36 37", ""),
        ("82 38 39 00 00 00 00 00", "a2 02 7f 00 00 00 00 00"),
        ("40 00 10 00 00 00 00 00", "80 00 20 00 01 00 04 05"),
    ],
    "more and less than announced": [
        ("c2 00 20 00 09 00 00 00", "a0 00 20 00 7f 00 00 00"),
        ("01 31 32 33 34 35 36 37", ""),
        ("82 38 39 41 00 00 00 00", "a2 02 7f 00 00 00 00 00"),
        ("d1 00 00 00 00 00 00 00", "80 00 20 00 12 00 07 06"),
        ("c2 00 20 00 09 00 00 00", "a0 00 20 00 7f 00 00 00"),
        ("81 31 32 33 34 35 36 37", "a2 01 7f 00 00 00 00 00"),
        ("c1 00 00 00 00 00 00 00", "80 00 20 00 13 00 07 06"),
        ("c2 00 20 00 01 00 00 00", "a0 00 20 00 7f 00 00 00"),
        ("01 31 32 33 34 35 36 37", ""),
        ("02 31 32 33 34 35 36 37", "80 00 20 00 12 00 07 06"),
    ],
    "too much and too little for the type": [
        ("c2 17 10 00 04 00 00 00", "80 17 10 00 12 00 07 06"),
        ("c2 17 10 00 01 00 00 00", "80 17 10 00 13 00 07 06"),
        ("c0 17 10 00 00 00 00 00", "a0 17 10 00 7f 00 00 00"),
        ("81 01 00 00 00 00 00 00", "a2 01 7f 00 00 00 00 00"),
        ("d9 00 00 00 00 00 00 00", "80 17 10 00 13 00 07 06"),
        ("c0 17 10 00 00 00 00 00", "a0 17 10 00 7f 00 00 00"),
        ("01 01 00 00 00 00 00 00", ""),
        ("02 01 00 00 00 00 00 00", "80 17 10 00 12 00 07 06"),
        ("c2 04 20 00 01 00 10 00", "80 04 20 00 05 00 04 05"),
    ],
    "beyond the limit, at the end": [
        ("c2 02 20 00 02 00 00 00", "a0 02 20 00 7f 00 00 00"),
        ("81 0b 00 00 00 00 00 00", "a2 01 7f 00 00 00 00 00"),
        ("d5 00 00 00 00 00 00 00", "80 02 20 00 31 00 09 06"),
    ],
    "no access, no object, no sub-index": [
        ("c2 00 10 00 04 00 00 00", "80 00 10 00 02 00 01 06"),
        ("c2 00 30 00 04 00 00 00", "80 00 30 00 00 00 02 06"),
        ("c2 00 20 01 04 00 00 00", "80 00 20 01 11 00 09 06"),
        ("a4 01 20 00 7f 00 00 00", "80 01 20 00 01 00 01 06"),
        ("a4 00 30 00 7f 00 00 00", "80 00 30 00 00 00 02 06"),
        ("a4 00 10 01 7f 00 00 00", "80 00 10 01 11 00 09 06"),
    ],
    "wrong block sizes": [
        ("a4 00 20 00 00 00 00 00", "80 00 20 00 02 00 04 05"),
        ("a4 00 20 00 80 00 00 00", "80 00 20 00 02 00 04 05"),
        ("a4 00 20 00 ff 00 00 00", "80 00 20 00 02 00 04 05"),
    ],
    "so little that the client wants it the other way": [
        ("a4 17 10 00 7f 02 00 00", "4b 17 10 00 00 00 00 00"),
        ("a4 00 20 00 7f 09 00 00", "41 00 20 00 09 00 00 00"),
        ("60 00 00 00 00 00 00 00", "00 31 32 33 34 35 36 37"),
        ("70 00 00 00 00 00 00 00", "1b 38 39 00 00 00 00 00"),
        ("a4 00 20 00 7f 08 00 00", "c6 00 20 00 09 00 00 00"),
    ],
    "upload that is not started": [
        ("a4 00 20 00 7f 00 00 00", "c6 00 20 00 09 00 00 00"),
        ("a2 00 7f 00 00 00 00 00", "80 00 20 00 01 00 04 05"),
    ],
    "commands of blocks at the wrong time": [
        ("a1 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"),
        ("a2 01 7f 00 00 00 00 00", "80 00 00 00 01 00 04 05"),
        ("a3 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"),
        ("c1 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"),
    ],
    "abort of the client ends a download among its segments": [
        ("c6 00 20 00 09 00 00 00", "a4 00 20 00 7f 00 00 00"),
        ("01 31 32 33 34 35 36 37", ""),
        ("80 00 20 00 00 00 00 08", ""),
        HEARTBEAT_TIME,
    ],
    "abort of the client ends a download at its end": [
        ("c6 00 20 00 09 00 00 00", "a4 00 20 00 7f 00 00 00"),
        ("01 31 32 33 34 35 36 37", ""),
        ("82 38 39 00 00 00 00 00", "a2 02 7f 00 00 00 00 00"),
        ("80 00 20 00 00 00 00 08", ""),
        HEARTBEAT_TIME,
    ],
}


@pytest.mark.parametrize("name", SCRIPTS)
def test_answers(block: CanopenBench, name: str) -> None:
    block.play(SCRIPTS[name])


def test_download_arrives(block: CanopenBench) -> None:
    block.play(SCRIPTS["download with size and CRC"])
    assert block.point("2000:00") == "123456789"


UPLOADED = ["01 31 32 33 34 35 36 37", "82 38 39 00 00 00 00 00"]


@pytest.mark.parametrize(
    ("initiate", "initiated", "end"),
    [("a4", "c6", "d5 c3 31 00 00 00 00 00"), ("a0", "c2", "d5 00 00 00 00 00 00 00")],
    ids=["crc", "no crc"],
)
def test_upload(block: CanopenBench, initiate: str, initiated: str, end: str) -> None:
    assert say(block, f"{initiate} 00 20 00 7f 00 00 00") == [f"{initiated} 00 20 00 09 00 00 00"]
    assert say(block, "a3 00 00 00 00 00 00 00") == UPLOADED
    assert say(block, "a2 02 7f 00 00 00 00 00") == [end]
    assert say(block, "a1 00 00 00 00 00 00 00") == []
    assert say(block, "a1 00 00 00 00 00 00 00") == ["80 00 00 00 01 00 04 05"]


def test_upload_of_nothing(block: CanopenBench) -> None:
    assert say(block, "a4 03 20 00 7f 00 00 00") == ["c6 03 20 00 00 00 00 00"]
    assert say(block, "a3 00 00 00 00 00 00 00") == ["81 00 00 00 00 00 00 00"]
    assert say(block, "a2 01 7f 00 00 00 00 00") == ["dd 00 00 00 00 00 00 00"]


def test_upload_changes_its_block_size_with_each_confirmation(block: CanopenBench) -> None:
    block.set("2000:00", "aaaaaaabbbbbbbcccccccdddddddeee")
    say(block, "a4 00 20 00 01 00 00 00")
    a, b, c, d = (" ".join([f"{ord(letter):02x}"] * 7) for letter in "abcd")
    assert say(block, "a3 00 00 00 00 00 00 00") == [f"01 {a}"]
    assert say(block, "a2 01 02 00 00 00 00 00") == [f"01 {b}", f"02 {c}"]
    assert say(block, "a2 02 7f 00 00 00 00 00") == [f"01 {d}", "82 65 65 65 00 00 00 00"]


@pytest.mark.parametrize(
    ("confirmed", "again"),
    [
        ("00", UPLOADED),
        ("01", ["81 38 39 00 00 00 00 00"]),
    ],
)
def test_upload_goes_on_after_what_was_confirmed(block: CanopenBench, confirmed: str, again: list[str]) -> None:
    say(block, "a4 00 20 00 7f 00 00 00")
    say(block, "a3 00 00 00 00 00 00 00")
    assert say(block, f"a2 {confirmed} 7f 00 00 00 00 00") == again


@pytest.mark.parametrize(
    ("confirmation", "code"),
    [
        ("a2 03 7f", "03 00 04 05"),
        ("a2 80 7f", "03 00 04 05"),
        ("a2 02 00", "02 00 04 05"),
        ("a2 02 80", "02 00 04 05"),
        ("a1 02 7f", "01 00 04 05"),
        ("40 00 10", "01 00 04 05"),
    ],
)
def test_wrong_confirmation_ends_an_upload(block: CanopenBench, confirmation: str, code: str) -> None:
    say(block, "a4 00 20 00 7f 00 00 00")
    say(block, "a3 00 00 00 00 00 00 00")
    assert say(block, f"{confirmation} 00 00 00 00 00") == [f"80 00 20 00 {code}"]


def test_wrong_end_of_an_upload(block: CanopenBench) -> None:
    for request in ("a4 00 20 00 7f 00 00 00", "a3 00 00 00 00 00 00 00", "a2 02 7f 00 00 00 00 00"):
        say(block, request)
    assert say(block, "a2 02 7f 00 00 00 00 00") == ["80 00 20 00 01 00 04 05"]


def test_abort_ends_an_upload(block: CanopenBench) -> None:
    say(block, "a4 00 20 00 7f 00 00 00")
    assert say(block, "80 00 20 00 00 00 00 08") == []
    assert say(block, "a3 00 00 00 00 00 00 00") == ["80 00 00 00 01 00 04 05"]


def test_upload_times_out(block: CanopenBench) -> None:
    say(block, "a4 00 20 00 7f 00 00 00")
    say(block, "a3 00 00 00 00 00 00 00")
    assert block.after(999) == []
    assert block.after(1) == ["585#80 00 20 00 00 00 04 05"]
    assert block.after(5000) == []


def test_download_tells_how_far_it_came_when_the_end_of_a_block_is_lost(block: CanopenBench) -> None:
    say(block, "c6 00 20 00 09 00 00 00")
    say(block, "01 31 32 33 34 35 36 37")
    assert block.after(499) == []
    assert block.after(1) == ["585#a2 01 7f 00 00 00 00 00"]
    block.play(
        [
            ("81 38 39 00 00 00 00 00", "a2 01 7f 00 00 00 00 00"),
            ("d5 c3 31 00 00 00 00 00", "a1 00 00 00 00 00 00 00"),
        ]
    )
    assert block.point("2000:00") == "123456789"


def test_download_times_out_all_the_same(block: CanopenBench) -> None:
    say(block, "c6 00 20 00 09 00 00 00")
    assert block.after(999) == ["585#a2 00 7f 00 00 00 00 00"]
    assert block.after(1) == ["585#80 00 20 00 00 00 04 05"]


def test_block_size_of_downloads_is_a_setting(tmp_path: Path) -> None:
    bench = make(tmp_path, sdo_block_size=2)
    bench.play(
        [
            ("c6 00 20 00 10 00 00 00", "a4 00 20 00 02 00 00 00"),
            ("01 31 32 33 34 35 36 37", ""),
            ("02 38 39 31 32 33 34 35", "a2 02 02 00 00 00 00 00"),
            ("03 36 37 00 00 00 00 00", "80 00 20 00 03 00 04 05"),
        ]
    )


def test_value_is_written_only_when_all_is_right(block: CanopenBench) -> None:
    block.play(SCRIPTS["download with a wrong CRC"])
    block.play(SCRIPTS["more and less than announced"])
    assert block.point("2000:00") == "123456789"
    block.play(
        [
            ("c6 17 10 00 02 00 00 00", "a4 17 10 00 7f 00 00 00"),
            ("81 e8 03 00 00 00 00 00", "a2 01 7f 00 00 00 00 00"),
        ]
    )
    assert block.point("1017:00") == 0


def test_reset_ends_a_block(block: CanopenBench) -> None:
    say(block, "c6 00 20 00 09 00 00 00")
    block.send("000#82 05")
    assert say(block, "40 17 10 00 00 00 00 00") == ["4b 17 10 00 00 00 00 00"]
