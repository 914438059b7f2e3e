"""Multiplexed PDOs, CiA 301 7.2.2.4: node 5 with scanner list, dispatching list and two PDOs of each direction."""

from pathlib import Path

import pytest
from canopen_bench import CanopenBench

START = "000#01 05"
DEVICE = """
[DeviceInfo]
GroupMessaging={group}
[1000]
DataType=7
AccessType=ro
[1001]
DataType=5
AccessType=ro
[1014]
DataType=7
AccessType=rw
DefaultValue=$NODEID+0x80
[1400]
ObjectType=9
[1400sub1]
DataType=7
AccessType=rw
DefaultValue=0x300
[1400sub2]
DataType=5
AccessType=rw
DefaultValue=255
[1600]
ObjectType=9
[1600sub0]
DataType=5
AccessType=rw
DefaultValue={rpdo}
[1600sub1]
DataType=7
AccessType=rw
[1800]
ObjectType=9
[1800sub1]
DataType=7
AccessType=rw
DefaultValue=0x40000185
[1800sub2]
DataType=5
AccessType=rw
DefaultValue=255
[1800sub3]
DataType=6
AccessType=rw
DefaultValue={inhibit}
[1A00]
ObjectType=9
[1A00sub0]
DataType=5
AccessType=rw
DefaultValue={tpdo}
[1A00sub1]
DataType=7
AccessType=rw
DefaultValue=0x20000108
[1FA0]
ObjectType=8
[1FA0sub0]
DataType=5
AccessType=rw
DefaultValue=2
[1FA0sub1]
DataType=7
AccessType=rw
DefaultValue=0x02200001
[1FA0sub2]
DataType=7
AccessType=rw
DefaultValue=0x01200100
[1FD0]
ObjectType=8
[1FD0sub0]
DataType=5
AccessType=rw
DefaultValue=1
[1FD0sub1]
DataType=0x1B
AccessType=rw
DefaultValue=0x0220000160000109
[2000]
ObjectType=8
[2000sub0]
DataType=5
AccessType=ro
DefaultValue=2
[2000sub1]
DataType=5
AccessType=rw
PDOMapping=1
[2000sub2]
DataType=5
AccessType=rw
PDOMapping=1
[2001]
DataType=7
AccessType=rw
PDOMapping=1
HighLimit=0x1000
[2002]
DataType=0x1B
AccessType=rw
PDOMapping=1
"""


def make(folder: Path, *, rpdo: int = 0, tpdo: int = 0, inhibit: int = 0, group: int = 1) -> CanopenBench:
    path = folder / "mpdo.eds"
    path.write_text(DEVICE.format(rpdo=rpdo, tpdo=tpdo, inhibit=inhibit, group=group))
    bench = CanopenBench(path)
    bench.send(START)
    return bench


# Source address mode: the scanner list selects the objects to send, the dispatching list their destinations.


def test_changes_of_scanned_objects_are_told_with_their_source(tmp_path: Path) -> None:
    bench = make(tmp_path, tpdo=254)
    bench.set("2000:02", 0xAA)
    bench.set("2001:00", 0x123)
    bench.set("2000:02", 0xBB)
    assert bench.after(0) == ["185#05 00 20 02 bb 00 00 00", "185#05 01 20 00 23 01 00 00"]
    bench.set("2002:00", 1)
    assert bench.after(100) == []


def test_inhibit_time_is_between_two_of_them(tmp_path: Path) -> None:
    bench = make(tmp_path, tpdo=254, inhibit=100)
    bench.set("2000:01", 1)
    bench.set("2000:02", 2)
    assert bench.after(9.9) == ["185#05 00 20 01 01 00 00 00"]
    assert bench.after(0.1) == ["185#05 00 20 02 02 00 00 00"]
    assert bench.after(100) == []


def test_messages_of_a_listed_source_are_dispatched(tmp_path: Path) -> None:
    bench = make(tmp_path, rpdo=254)
    bench.send("300#09 00 60 01 11 22 33 44", "300#09 00 60 02 55 00 00 00")
    assert (bench.point("2000:01"), bench.point("2000:02")) == (0x11, 0x55)


@pytest.mark.parametrize(
    "frame",
    [
        "300#08 00 60 01 11 00 00 00",  # another node
        "300#09 01 60 01 11 00 00 00",  # another object
        "300#09 00 60 03 11 00 00 00",  # beyond the block
        "300#89 00 60 01 11 00 00 00",  # to a destination
        "300#85 00 20 01 11 00 00 00",
    ],
)
def test_messages_of_others_are_not(tmp_path: Path, frame: str) -> None:
    bench = make(tmp_path, rpdo=254)
    assert bench.send(frame) == []
    assert (bench.point("2000:01"), bench.point("2000:02")) == (0, 0)


# Destination address mode


@pytest.mark.parametrize("address", ["80", "85"])
def test_message_to_this_node_or_all_is_taken(tmp_path: Path, address: str) -> None:
    bench = make(tmp_path, rpdo=255)
    assert bench.send(f"300#{address} 01 20 00 00 10 00 00") == []
    assert bench.point("2001:00") == 0x1000


@pytest.mark.parametrize("address", ["86", "05", "00"])
def test_message_to_another_node_is_not(tmp_path: Path, address: str) -> None:
    bench = make(tmp_path, rpdo=255)
    assert bench.send(f"300#{address} 01 20 00 01 00 00 00") == []
    assert bench.point("2001:00") == 0


@pytest.mark.parametrize(
    ("multiplexer", "data"),
    [
        ("55 55 00", "00 00 00 00"),
        ("00 20 03", "00 00 00 00"),
        ("00 20 00", "00 00 00 00"),  # read-only
        ("00 10 00", "00 00 00 00"),  # not mappable
        ("02 20 00", "00 00 00 00"),  # too long
        ("01 20 00", "01 10 00 00"),  # too high
    ],
)
def test_message_that_can_t_be_taken_is_reported(tmp_path: Path, multiplexer: str, data: str) -> None:
    bench = make(tmp_path, rpdo=255)
    assert bench.send(f"300#85 {multiplexer} {data}") == [f"085#30 82 11 {multiplexer} 00 00"]
    assert bench.send("300#85 01 20 00 01 00 00 00") == ["085#00 00 00 00 00 00 00 00"]


@pytest.mark.parametrize("size", [0, 7])
def test_message_that_is_too_short_is_reported(tmp_path: Path, size: int) -> None:
    bench = make(tmp_path, rpdo=255)
    assert bench.send("300#" + "85 01 20 00 01 00 00"[: size * 3]) == [f"085#10 82 11 0{size} 08 00 00 00"]


def test_application_sends_what_is_mapped_to_a_destination(tmp_path: Path) -> None:
    bench = make(tmp_path, tpdo=255)
    bench.set("2000:01", 0x42)
    assert bench.after(0) == []
    bench.node.send_to(1, 7, 0x6200, 3)
    assert bench.after(0) == ["185#87 00 62 03 42 00 00 00"]
    bench.set("2000:01", 0x43)
    assert bench.after(0) == ["185#87 00 62 03 43 00 00 00"]


def test_modes_are_chosen_by_the_mapping_procedure(tmp_path: Path) -> None:
    bench = make(tmp_path)
    bench.write("23 00 18 01 85 01 00 c0", "2f 00 1a 00 fe 00 00 00", "23 00 18 01 85 01 00 40")
    bench.set("2000:01", 1)
    assert bench.after(0) == ["185#05 00 20 01 01 00 00 00"]


def test_without_group_messaging_there_is_none(tmp_path: Path) -> None:
    bench = make(tmp_path, group=0)
    bench.write("23 00 18 01 85 01 00 c0")
    assert bench.sdo("2f 00 1a 00 fe 00 00 00") == "80 00 1a 00 42 00 04 06"
