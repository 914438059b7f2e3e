"""SDO server, CiA 301 7.2.4.3: requests of a client and the server's answers, byte by byte."""

from pathlib import Path

import pytest
from canopen_bench import CanopenBench, Script
from eds_oddities import DEVICE_TYPE

SCRIPTS: dict[str, Script] = {
    "expedited upload of 4, 2 and 1 bytes": [
        ("40 00 10 00 00 00 00 00", "43 00 10 00 91 01 0f 00"),
        ("40 17 10 00 00 00 00 00", "4b 17 10 00 00 00 00 00"),
        ("40 01 10 00 00 00 00 00", "4f 01 10 00 00 00 00 00"),
    ],
    "expedited upload of a text of 4 bytes": [
        ("40 08 10 00 00 00 00 00", "43 08 10 00 49 4f 33 32"),
    ],
    "expedited upload of a text of 3 bytes": [
        ("40 09 10 00 00 00 00 00", "47 09 10 00 31 2e 30 00"),
    ],
    "COB-IDs follow the node-ID": [
        ("40 00 14 01 00 00 00 00", "43 00 14 01 05 02 00 00"),
        ("40 00 18 01 00 00 00 00", "43 00 18 01 85 01 00 40"),
        ("40 14 10 00 00 00 00 00", "43 14 10 00 85 00 00 00"),
        ("40 00 12 01 00 00 00 00", "43 00 12 01 05 06 00 00"),
        ("40 00 12 02 00 00 00 00", "43 00 12 02 85 05 00 00"),
    ],
    "expedited download with and without size": [
        ("2b 17 10 00 e8 03 00 00", "60 17 10 00 00 00 00 00"),
        ("40 17 10 00 00 00 00 00", "4b 17 10 00 e8 03 00 00"),
        ("22 17 10 00 f4 01 00 00", "60 17 10 00 00 00 00 00"),
        ("40 17 10 00 00 00 00 00", "4b 17 10 00 f4 01 00 00"),
    ],
    "segmented download in one and two segments": [
        ("21 17 10 00 02 00 00 00", "60 17 10 00 00 00 00 00"),
        ("0b e8 03 00 00 00 00 00", "20 00 00 00 00 00 00 00"),
        ("40 17 10 00 00 00 00 00", "4b 17 10 00 e8 03 00 00"),
        ("20 17 10 00 00 00 00 00", "60 17 10 00 00 00 00 00"),
        ("0c f4 00 00 00 00 00 00", "20 00 00 00 00 00 00 00"),
        ("1d 01 00 00 00 00 00 00", "30 00 00 00 00 00 00 00"),
        ("40 17 10 00 00 00 00 00", "4b 17 10 00 f4 01 00 00"),
    ],
    "read-only, no object, no sub-index": [
        ("23 00 10 00 00 00 00 00", "80 00 10 00 02 00 01 06"),
        ("21 00 10 00 04 00 00 00", "80 00 10 00 02 00 01 06"),
        ("40 04 10 00 00 00 00 00", "80 04 10 00 00 00 02 06"),
        ("2f 04 10 00 00 00 00 00", "80 04 10 00 00 00 02 06"),
        ("40 00 10 01 00 00 00 00", "80 00 10 01 11 00 09 06"),
    ],
    "too long and too short for the type": [
        ("23 17 10 00 01 00 00 00", "80 17 10 00 12 00 07 06"),
        ("2f 17 10 00 01 00 00 00", "80 17 10 00 13 00 07 06"),
        ("21 17 10 00 03 00 00 00", "80 17 10 00 12 00 07 06"),
        ("21 17 10 00 01 00 00 00", "80 17 10 00 13 00 07 06"),
        ("21 17 10 00 ff ff ff ff", "80 17 10 00 12 00 07 06"),
    ],
    "more or less in segments than announced": [
        ("21 17 10 00 02 00 00 00", "60 17 10 00 00 00 00 00"),
        ("09 01 02 03 00 00 00 00", "80 17 10 00 12 00 07 06"),
        ("21 17 10 00 02 00 00 00", "60 17 10 00 00 00 00 00"),
        ("0d 01 00 00 00 00 00 00", "80 17 10 00 13 00 07 06"),
        ("20 17 10 00 00 00 00 00", "60 17 10 00 00 00 00 00"),
        ("00 01 02 03 04 05 06 07", "80 17 10 00 12 00 07 06"),
        ("20 17 10 00 00 00 00 00", "60 17 10 00 00 00 00 00"),
        ("0d 01 00 00 00 00 00 00", "80 17 10 00 13 00 07 06"),
    ],
    "beyond the limits": [
        ("2f 43 64 01 02 00 00 00", "80 43 64 01 31 00 09 06"),
        ("2f 05 60 00 02 00 00 00", "80 05 60 00 31 00 09 06"),
    ],
    "toggle bit not alternated in a download": [
        ("21 17 10 00 02 00 00 00", "60 17 10 00 00 00 00 00"),
        ("1b e8 03 00 00 00 00 00", "80 17 10 00 00 00 03 05"),
        ("0b e8 03 00 00 00 00 00", "80 00 00 00 01 00 04 05"),
    ],
    "command specifiers that are unknown or come at the wrong time": [
        ("e0 00 10 00 00 00 00 00", "80 00 10 00 01 00 04 05"),
        ("60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"),
        ("00 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"),
        ("21 17 10 00 02 00 00 00", "60 17 10 00 00 00 00 00"),
        ("60 00 00 00 00 00 00 00", "80 17 10 00 01 00 04 05"),
        ("21 17 10 00 02 00 00 00", "60 17 10 00 00 00 00 00"),
        ("40 00 10 00 00 00 00 00", "80 17 10 00 01 00 04 05"),
        ("40 00 10 00 00 00 00 00", "43 00 10 00 91 01 0f 00"),
    ],
    "abort of the client ends a transfer": [
        ("80 00 00 00 00 00 00 08", ""),
        ("21 17 10 00 02 00 00 00", "60 17 10 00 00 00 00 00"),
        ("80 17 10 00 00 00 00 08", ""),
        ("0b e8 03 00 00 00 00 00", "80 00 00 00 01 00 04 05"),
        ("40 17 10 00 00 00 00 00", "4b 17 10 00 00 00 00 00"),
    ],
    "error history can only be emptied": [
        ("40 03 10 01 00 00 00 00", "80 03 10 01 24 00 00 08"),
        ("2f 03 10 00 01 00 00 00", "80 03 10 00 30 00 09 06"),
        ("2f 03 10 00 00 00 00 00", "60 03 10 00 00 00 00 00"),
    ],
}


@pytest.mark.parametrize("name", SCRIPTS)
def test_answers(bench: CanopenBench, name: str) -> None:
    bench.play(SCRIPTS[name])


NAMED = f"""
{DEVICE_TYPE}[2000]
ParameterName=Text
DataType=0x0009
AccessType=rw
DefaultValue=fieldrig 12345
[2001]
ParameterName=Write only
DataType=0x0005
AccessType=wo
[2002]
ParameterName=Limited
DataType=0x0003
AccessType=rw
LowLimit=-10
HighLimit=0x000A
[2003]
ParameterName=Real with limits
DataType=0x0008
AccessType=rw
LowLimit=0.5
HighLimit=1.5
[2004]
ParameterName=Anything
ObjectType=2
"""


@pytest.fixture
def named(tmp_path: Path) -> CanopenBench:
    """A node with the objects above."""
    (tmp_path / "named.eds").write_text(NAMED)
    return CanopenBench(tmp_path / "named.eds")


NAMED_SCRIPTS: dict[str, Script] = {
    "segmented upload": [
        ("40 00 20 00 00 00 00 00", "41 00 20 00 0e 00 00 00"),
        ("60 00 00 00 00 00 00 00", "00 66 69 65 6c 64 72 69"),
        ("70 00 00 00 00 00 00 00", "11 67 20 31 32 33 34 35"),
        ("60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"),
    ],
    "toggle bit not alternated in an upload": [
        ("40 00 20 00 00 00 00 00", "41 00 20 00 0e 00 00 00"),
        ("70 00 00 00 00 00 00 00", "80 00 20 00 00 00 03 05"),
        ("40 00 20 00 00 00 00 00", "41 00 20 00 0e 00 00 00"),
        ("60 00 00 00 00 00 00 00", "00 66 69 65 6c 64 72 69"),
        ("60 00 00 00 00 00 00 00", "80 00 20 00 00 00 03 05"),
    ],
    "wrong command specifier in an upload": [
        ("40 00 20 00 00 00 00 00", "41 00 20 00 0e 00 00 00"),
        ("00 00 00 00 00 00 00 00", "80 00 20 00 01 00 04 05"),
    ],
    "an empty text": [
        ("21 00 20 00 00 00 00 00", "60 00 20 00 00 00 00 00"),
        ("0f 00 00 00 00 00 00 00", "20 00 00 00 00 00 00 00"),
        ("40 00 20 00 00 00 00 00", "41 00 20 00 00 00 00 00"),
        ("60 00 00 00 00 00 00 00", "0f 00 00 00 00 00 00 00"),
    ],
    "write-only": [
        ("40 01 20 00 00 00 00 00", "80 01 20 00 01 00 01 06"),
        ("2f 01 20 00 07 00 00 00", "60 01 20 00 00 00 00 00"),
    ],
    "too high and too low": [
        ("2b 02 20 00 0a 00 00 00", "60 02 20 00 00 00 00 00"),
        ("2b 02 20 00 0b 00 00 00", "80 02 20 00 31 00 09 06"),
        ("2b 02 20 00 f6 ff 00 00", "60 02 20 00 00 00 00 00"),
        ("2b 02 20 00 f5 ff 00 00", "80 02 20 00 32 00 09 06"),
    ],
    "reals within limits, 1.0, 2.0, 0.25, not a number": [
        ("23 03 20 00 00 00 80 3f", "60 03 20 00 00 00 00 00"),
        ("23 03 20 00 00 00 00 40", "80 03 20 00 31 00 09 06"),
        ("23 03 20 00 00 00 80 3e", "80 03 20 00 32 00 09 06"),
        ("23 03 20 00 00 00 c0 7f", "80 03 20 00 31 00 09 06"),
    ],
    "more than there is memory for": [
        ("21 04 20 00 01 00 10 00", "80 04 20 00 05 00 04 05"),
    ],
}


@pytest.mark.parametrize("name", NAMED_SCRIPTS)
def test_answers_of_other_objects(named: CanopenBench, name: str) -> None:
    named.play(NAMED_SCRIPTS[name])


def test_upload_gives_the_value_at_its_start(named: CanopenBench) -> None:
    named.sdo("40 00 20 00 00 00 00 00")
    named.set("2000:00", "changed")
    assert named.sdo("60 00 00 00 00 00 00 00") == "00 66 69 65 6c 64 72 69"


def test_transfer_times_out_and_is_aborted(named: CanopenBench) -> None:
    named.sdo("40 00 20 00 00 00 00 00")
    assert named.after(999)[-1:] == []
    assert named.after(1) == ["585#80 00 20 00 00 00 04 05"]
    assert named.after(5000) == []


def test_each_segment_gives_the_client_new_time(named: CanopenBench) -> None:
    named.sdo("40 00 20 00 00 00 00 00")
    named.after(900)
    assert named.sdo("60 00 00 00 00 00 00 00") == "00 66 69 65 6c 64 72 69"
    assert named.after(900) == []
    assert named.after(100) == ["585#80 00 20 00 00 00 04 05"]


@pytest.mark.parametrize(
    "frame", ["605#40 00 10 00 00 00 00", "605#40", "605#", "605#R", "606#40 00 10 00 00 00 00 00"]
)
def test_what_is_no_sdo_for_the_node_gets_no_answer(bench: CanopenBench, frame: str) -> None:
    assert bench.send(frame) == []


def test_reset_ends_a_transfer(named: CanopenBench) -> None:
    named.sdo("40 00 20 00 00 00 00 00")
    named.send("000#82 05")
    assert named.sdo("60 00 00 00 00 00 00 00") == "80 00 00 00 01 00 04 05"


SECOND_SERVER = """
[1000]
ParameterName=Device type
DataType=0x0007
AccessType=ro
[1201]
ParameterName=SDO server parameter
ObjectType=9
[1201sub0]
DataType=5
AccessType=ro
DefaultValue=2
[1201sub1]
DataType=7
AccessType=rw
DefaultValue=0x80000000
[1201sub2]
DataType=7
AccessType=rw
DefaultValue=0x80000000
"""


def test_second_server_serves_once_it_has_its_cob_ids(tmp_path: Path) -> None:
    (tmp_path / "two.eds").write_text(SECOND_SERVER)
    bench = CanopenBench(tmp_path / "two.eds")
    assert bench.sdo("23 01 12 01 20 06 00 00") == "80 01 12 01 30 00 09 06"  # 620h is restricted
    bench.write("23 01 12 01 10 02 00 00")
    assert 0x210 not in bench.interest
    bench.write("23 01 12 02 10 03 00 00")
    assert 0x210 in bench.interest
    assert bench.send("210#40 00 10 00 00 00 00 00") == ["310#43 00 10 00 00 00 00 00"]
    assert bench.sdo("23 01 12 01 11 02 00 00") == "80 01 12 01 22 00 00 08"
