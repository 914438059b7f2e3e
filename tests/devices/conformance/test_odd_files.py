"""Any file that a node can be made from can be conformed: one reader for all, whatever tool wrote the file."""

import re
from pathlib import Path

import pytest
from broken_nodes import NODE_ID
from canopen_bench import IO32
from conform_bench import conformed, failures
from eds_oddities import DEVICE_TYPE, MISTAKES, ODD, WRONG

from fieldrig.errors import UsageError
from fieldrig_devices.canopen.eds.reader import load
from fieldrig_devices.conformance.description import Description
from fieldrig_devices.conformance.objects import is_live

COMPACT = """[2100]
ObjectType=8
DataType=6
AccessType=rw
CompactSubObj=3
DefaultValue=7
[2100Value]
NrOfEntries=1
2=9
"""
FOREIGN = "[2100]\nDataType=0x0A\nAccessType=ro\nDefaultValue=00000000000000000001\n"
"""Ten octets, which the reader of the canopen package refuses."""


def file_of(folder: Path, text: str) -> Path:
    path = folder / "device.eds"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    "text", [*(DEVICE_TYPE + text for text, _, _ in ODD), DEVICE_TYPE + COMPACT, DEVICE_TYPE + FOREIGN]
)
def test_node_made_from_an_odd_file_is_conformed_by_the_same_file(tmp_path: Path, text: str) -> None:
    eds = file_of(tmp_path, text)
    report = conformed("OD", "SDO 0*", eds=eds)
    assert failures(report) == {}
    assert report.executed >= 8


def test_a_mapping_with_a_single_entry_is_written_with_one_object(tmp_path: Path) -> None:
    """A public file of a drive has 1A00h with the sub-indices 0 and 1 only."""
    blocks = IO32.read_text().replace("[1A00sub0]\n", "[1A00sub0]\nHighLimit=1\n").split("\n\n")
    further = re.compile(r"\[1A00sub[2-9A-F]+\]")
    eds = file_of(tmp_path, "\n\n".join(block for block in blocks if not further.match(block)))
    report = conformed("PDO 22", eds=eds)
    assert (failures(report), report.executed) == ({}, 1)


@pytest.mark.long
def test_odd_files_mean_the_same_to_node_and_suite(tmp_path: Path) -> None:
    texts = [DEVICE_TYPE + text for text, _, _ in ODD] + [
        IO32.read_text().replace(right, odd, 1) for right, odd, _ in MISTAKES
    ]
    for text in texts:
        eds = file_of(tmp_path, text)
        node, described = load(eds, NODE_ID), Description(eds, NODE_ID)
        of_node = [(found.index, found.subindex, found.type.size, found.access.value) for found in node]
        assert of_node == [(entry.index, entry.sub, entry.size, entry.access) for entry in described]
        for entry in described:
            assert entry.default in (None, node.find(entry.index, entry.sub).start)


def test_exceptions_of_a_compact_array_are_promised(tmp_path: Path) -> None:
    described = Description(file_of(tmp_path, DEVICE_TYPE + COMPACT), NODE_ID)
    promised = [(entry.sub, entry.default) for entry in described if entry.index == 0x2100]
    assert promised == [(0, b"\x03"), (1, b"\x07\x00"), (2, b"\x09\x00"), (3, b"\x07\x00")]


def test_value_that_the_file_does_not_give_is_no_promise(tmp_path: Path) -> None:
    described = Description(file_of(tmp_path, DEVICE_TYPE), NODE_ID)
    assert [entry.default for entry in described] == [None]


def test_an_actual_value_of_a_drive_is_none_that_a_file_can_promise(tmp_path: Path) -> None:
    """A public file has 6079h, the voltage of the DC link, with the default 0 and without PDOs."""
    objects = "".join(
        f"[{index:04X}]\nDataType=7\nAccessType={access}\nDefaultValue=0\nPDOMapping=0\n"
        for index, access in ((0x6079, "ro"), (0x607F, "rw"), (0x6502, "ro"))
    )
    described = Description(file_of(tmp_path, DEVICE_TYPE + objects), NODE_ID)
    assert [entry.index for entry in described if is_live(entry)] == [0x6079]


@pytest.mark.parametrize("text", [text for text, _ in WRONG])
def test_an_object_without_a_type_is_left_out_by_node_and_suite(tmp_path: Path, text: str) -> None:
    eds = file_of(tmp_path, DEVICE_TYPE + text)
    assert [entry.index for entry in Description(eds, NODE_ID)] == [0x1000]
    assert failures(conformed("OD", eds=eds)) == {}


def test_a_file_without_objects_is_refused_with_the_line(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"device\.eds:1: error: the file has no object"):
        Description(file_of(tmp_path, "[2000]\nAccessType=rw\n"), NODE_ID)


LIMITED = [
    ("1016sub1", "0", "0xFFFF"),
    ("1017", "0", "50"),
    ("1014", "1", "0xFFFFFFFE"),
    ("1005", "1", "0x7FF"),
    ("1006", "0", "100"),
    ("1400sub1", "1", "0xFFFFFFFE"),
    ("1800sub1", "1", "0xFFFFFFFE"),
    ("1800sub5", "0", "1"),
    ("1A00sub1", "0", "0xFFFFFFFE"),
    ("100C", "0", "10"),
]
"""Sections of the file of our I/O module, with limits that keep a case from what it would write."""


@pytest.mark.long
@pytest.mark.parametrize(("section", "low", "high"), LIMITED)
def test_cases_write_only_what_the_file_allows(tmp_path: Path, section: str, low: str, high: str) -> None:
    """A maker's HighLimit of 1016h:01h allowed no node at all, and other limits were those of identifiers."""
    text = IO32.read_text()
    assert f"[{section}]\n" in text
    text = text.replace(f"[{section}]\n", f"[{section}]\nLowLimit={low}\nHighLimit={high}\n")
    found = failures(conformed(eds=file_of(tmp_path, text)))
    found.pop("1.0", None)  # the name of the file, which is another one here
    assert found == {}
