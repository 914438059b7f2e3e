"""EDS and DCF files, CiA 306-1: the dictionaries made from them, and the findings in wrong files."""

import re
from configparser import RawConfigParser
from pathlib import Path

import canopen
import pytest
from canopen_bench import IO32, LEVEL_SENSOR, CanopenBench
from eds_oddities import DEVICE_TYPE, ODD, WRONG
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.canopen.abort import Abort
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds.check import check_eds
from fieldrig_devices.canopen.eds.reader import load, oddities
from fieldrig_devices.canopen.eds.source import parse_number
from fieldrig_devices.canopen.eds.text import EdsError

OURS = [IO32, LEVEL_SENSOR]


def eds(folder: Path, text: str) -> Path:
    path = folder / "device.eds"
    path.write_text(DEVICE_TYPE + text)
    return path


def describe(folder: Path, text: str, node_id: int = 5) -> Dictionary:
    return load(eds(folder, text), node_id)


# Our files are complete.


@pytest.mark.parametrize("path", OURS, ids=lambda path: path.name)
def test_our_files_have_what_the_standard_asks_for(path: Path) -> None:
    file = RawConfigParser()
    file.read(path)
    asked = {
        "FileInfo": "FileName FileVersion FileRevision EDSVersion Description CreationTime CreationDate CreatedBy "
        "ModificationTime ModificationDate ModifiedBy",
        "DeviceInfo": "VendorName VendorNumber ProductName ProductNumber RevisionNumber OrderCode BaudRate_10 "
        "BaudRate_20 BaudRate_50 BaudRate_125 BaudRate_250 BaudRate_500 BaudRate_800 BaudRate_1000 SimpleBootUpMaster "
        "SimpleBootUpSlave Granularity DynamicChannelsSupported GroupMessaging NrOfRXPDO NrOfTXPDO LSS_Supported",
        "DummyUsage": "Dummy0001 Dummy0002 Dummy0003 Dummy0004 Dummy0005 Dummy0006 Dummy0007",
        "Comments": "Lines",
    }
    for section, keys in asked.items():
        assert [key for key in keys.split() if not file.has_option(section, key)] == []
    assert file["FileInfo"]["FileName"] == path.name


@pytest.mark.parametrize("path", OURS, ids=lambda path: path.name)
def test_our_files_list_exactly_the_objects_they_describe(path: Path) -> None:
    file = RawConfigParser()
    file.read(path)
    listed: list[int] = []
    for section in ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects"):
        count = int(file[section]["SupportedObjects"])
        assert len(file[section]) == count + 1
        listed += [int(file[section][str(number)], 16) for number in range(1, count + 1)]
    described = [int(name, 16) for name in file.sections() if re.fullmatch("[0-9A-F]{4}", name)]
    assert sorted(listed) == sorted(described)
    for name in described:
        subs = [section for section in file.sections() if section.startswith(f"{name:04X}sub")]
        assert file.getint(f"{name:04X}", "SubNumber", fallback=0) == len(subs)


@pytest.mark.parametrize("path", OURS, ids=lambda path: path.name)
def test_our_dictionary_is_what_canopen_reads(path: Path) -> None:
    theirs = canopen.import_od(str(path), 5)
    for ours in load(path, 5):
        their = theirs.get_variable(ours.index, ours.subindex)
        assert their is not None
        assert (ours.name, ours.access.value, ours.is_mappable) == (their.name, their.access_type, their.pdo_mappable)
        if their.default is not None:
            assert ours.value == their.default


# Files of other makers.


def test_node_id_expressions(tmp_path: Path) -> None:
    text = "".join(
        f"[2{number:03}]\nDataType=7\nAccessType=rw\nDefaultValue={value}\n"
        for number, value in enumerate(["$NODEID+0x180", "0x180 + $nodeid", "$NODEID", "0x10", "10", "010"])
    )
    dictionary = describe(tmp_path, text)
    assert [dictionary.number(0x2000 + number, 0) for number in range(6)] == [0x185, 0x185, 5, 16, 10, 8]


def test_values_of_every_type(tmp_path: Path) -> None:
    values = {
        (0x01, "1"): True,
        (0x02, "0xFF"): -1,
        (0x03, "-5"): -5,
        (0x04, "0x80000000"): -(1 << 31),
        (0x10, "0xFFFFFE"): -2,
        (0x15, "0xFFFFFFFFFFFFFFFF"): -1,
        (0x16, "0xFFFFFF"): 0xFFFFFF,
        (0x1B, "0xFFFFFFFFFFFFFFFF"): (1 << 64) - 1,
        (0x08, "1.5"): 1.5,
        (0x11, "-1e3"): -1000.0,
        (0x09, "Hallo 5"): "Hallo 5",
        (0x0B, "Hällo"): "Hällo",
        (0x0A, "01 af"): "01 af",
        (0x0F, "whatever.bin"): "",
        (0x0C, "0x123456789ABC"): 0x1234_5678_9ABC,
    }
    text = "".join(
        f"[20{data_type:02X}]\nDataType=0x{data_type:04X}\nAccessType=rw\nDefaultValue={value}\n"
        for data_type, value in values
    )
    dictionary = describe(tmp_path, text)
    found = [dictionary.by_key(f"20{data_type:02X}:00").value for data_type, _ in values]
    assert found == list(values.values())


def test_parameter_value_of_a_dcf_goes_before_the_default(tmp_path: Path) -> None:
    dictionary = describe(tmp_path, "[1017]\nDataType=6\nAccessType=rw\nDefaultValue=0\nParameterValue=500\n")
    assert dictionary.number(0x1017, 0) == 500


def test_the_first_sdo_server_is_where_every_master_looks_for_it(tmp_path: Path) -> None:
    """Its COB-IDs are 600h and 580h plus the node-ID even in a file for another node (CiA 301 7.5.2.33)."""
    text = """
[1200]
ObjectType=9
SubNumber=3
[1200sub0]
DataType=5
AccessType=const
DefaultValue=2
[1200sub1]
DataType=7
AccessType=ro
DefaultValue=$NODEID+0x600
ParameterValue=0x620
[1200sub2]
DataType=7
AccessType=ro
DefaultValue=0x5A0
"""
    dictionary = describe(tmp_path, text)
    assert [dictionary.number(0x1200, sub) for sub in (1, 2)] == [0x605, 0x585]


COMPACT = """
[2000]
ParameterName=Speed
ObjectType=8
DataType=0x0006
AccessType=rw
DefaultValue=7
PDOMapping=1
CompactSubObj=3
[2000Name]
NrOfEntries=1
2=Fast
[2000Value]
NrOfEntries=1
3=9
"""


def test_compact_sub_objects_are_written_out(tmp_path: Path) -> None:
    dictionary = describe(tmp_path, COMPACT)
    assert dictionary.number(0x2000, 0) == 3
    found = [(variable.name, variable.value, variable.is_mappable) for variable in dictionary.members(0x2000)]
    assert found == [("Speed 1", 7, True), ("Fast", 7, True), ("Speed 3", 9, True)]


def test_limits_in_all_forms(tmp_path: Path) -> None:
    text = "".join(
        f"[200{number}]\nDataType={data_type}\nAccessType=rw\nLowLimit={low}\nHighLimit={high}\n"
        for number, (data_type, low, high) in enumerate(
            [(3, "0xFFF6", "0x000A"), (5, "", ""), (8, "-0.5", "0.5"), (0x10, "-3", "0xFF"), (5, "0", "255")]
        )
    )
    dictionary = describe(tmp_path, text)
    found = [(variable.low, variable.high) for variable in dictionary if variable.index >= 0x2000]
    assert found == [(-10, 10), (None, None), (-0.5, 0.5), (-3, 255), (None, None)]


def test_value_that_is_left_out_lies_within_the_limits(tmp_path: Path) -> None:
    assert describe(tmp_path, "[2000]\nDataType=5\nAccessType=rw\nLowLimit=3\n").number(0x2000, 0) == 3
    above = describe(tmp_path, "[2000]\nDataType=7\nAccessType=rw\nLowLimit=-255\nHighLimit=1000\n").find(0x2000, 0)
    assert (above.low, above.high) == (None, 1_000)
    below = describe(tmp_path, "[2000]\nDataType=4\nAccessType=rw\nLowLimit=0x80000000\nHighLimit=0xFFFFFFFE\n")
    assert below.by_key("2000:00").value == -2


@pytest.mark.parametrize(
    ("limits", "told"),
    [
        ("LowLimit=1\n", "2000:00: expected a number of at least 1, got 0"),
        ("HighLimit=-1\n", "2000:00: expected a number of at most -1, got 0"),
        ("LowLimit=1\nHighLimit=9\n", "2000:00: expected a number from 1 to 9, got 0"),
    ],
)
def test_a_value_of_the_user_beyond_one_limit_or_two_is_refused(tmp_path: Path, limits: str, told: str) -> None:
    dictionary = describe(tmp_path, f"[2000]\nDataType=3\nAccessType=rw\nDefaultValue=5\n{limits}")
    with pytest.raises(ValueError, match=told):
        dictionary.by_key("2000:00").put(0)


def test_count_that_is_left_out_is_the_highest_sub_index(tmp_path: Path) -> None:
    text = "[2000]\nObjectType=9\n" + "".join(f"[2000sub{n}]\nDataType=5\nAccessType=ro\n" for n in (0, 1, 4))
    assert describe(tmp_path, text).number(0x2000, 0) == 4


@pytest.mark.parametrize(
    "text",
    [
        "[2000]\nPARAMETERNAME=a\ndatatype=0x0005\nACCESSTYPE=RW\n",
        "[2000]\nDataType=5 ; UNSIGNED8\nAccessType=rw\n",
        "[2000]  ; the speed\nDataType=5\nAccessType=rw\n",
        "[2000]\nAccessType=rw\nDataType=6\n[2000]\nDataType=5\n",
        "[2000SUB0]\nDataType=5\nAccessType=rw\n[2000]\nObjectType=9\n",
        "[Comments]\nLines=3\nLine1=only one\n[DeviceInfo]\nVendorNumber=\n[2000]\nDataType=5\nAccessType=rw\n",
        "[DeviceComissioning]\nNodeID=\n[2000]\nDataType=5\nAccessType=RW\n",
        "[2000]\nDataType=05\nAccessType=rw\nDefaultValue=\nLowLimit=\nPDOMapping=\n",
        "[DUMMYUSAGE]\nDUMMY0005=1\n[2000]\nDataType=5\nAccessType=rw\n",
        "[0040]\nObjectType=6\n[0040sub0]\nDataType=5\n[2000]\nDataType=5\nAccessType=rw\n",
        "[2000]\nDataType=0xA0\nAccessType=rw\n[A0]\nObjectType=5\n[A0sub1]\nDefaultValue=0x0005\n",
    ],
)
def test_ways_of_writing_that_are_understood(tmp_path: Path, text: str) -> None:
    variable = describe(tmp_path, text).by_key("2000:00")
    assert (variable.type.name, variable.access.value) == ("UNSIGNED8", "rw")


def test_other_encodings_are_read(tmp_path: Path) -> None:
    path = tmp_path / "latin.eds"
    path.write_bytes((DEVICE_TYPE + "[2000]\nParameterName=Motor 90°C\nDataType=5\nAccessType=rw\n").encode("latin-1"))
    assert load(path, 5).by_key("2000:00").name == "Motor 90°C"
    path.write_bytes(b"\xef\xbb\xbf" + DEVICE_TYPE.encode())
    assert 0x1000 in load(path, 6)
    path.write_bytes(DEVICE_TYPE.encode("utf-16"))
    assert 0x1000 in load(path, 7)


# Odd files are accepted, and each oddity is reported with its line, its key and what was expected.


def start(folder: Path, data_type: int, value: str) -> str:
    """Return the power-on value of object 2000h, as bytes in hex."""
    text = f"[2000]\nDataType={data_type:#06x}\nAccessType=rw\nDefaultValue={value}\n"
    return describe(folder, text).find(0x2000, 0).start.hex(" ")


# Notations of CiA 306-1, without a finding, and those of various makers, with their finding.
VALUES = [
    # OCTET_STRING: hex digits, whatever a number of these digits would be
    (0x0A, "0102", "01 02", ""),
    (0x0A, "00000000000000000000", "00 00 00 00 00 00 00 00 00 00", ""),
    (0x0A, "00 00 0a", "00 00 0a", ""),
    (0x0A, "0x01 0x02", "01 02", ""),
    (0x0A, "DE-AD:be,ef", "de ad be ef", ""),
    (0x0A, "1", "01", "two hex digits for each octet, 01"),
    (0x0A, "a text", "", "two hex digits for each octet"),
    # REAL32 and REAL64: decimal, or the bits of IEEE 754
    (0x08, "0x3FC00000", "00 00 c0 3f", ""),
    (0x08, "1.5", "00 00 c0 3f", ""),
    (0x08, "0x7FC00001", "01 00 c0 7f", ""),
    (0x08, "0x00000000", "00 00 00 00", ""),
    (0x11, "0x3FF8000000000000", "00 00 00 00 00 00 f8 3f", ""),
    (0x11, "0xC000000000000000", "00 00 00 00 00 00 00 c0", ""),
    (0x08, "1,5", "00 00 c0 3f", "1.5"),
    (0x08, "0x3FF8000000000000", "00 00 00 00", "a decimal number for REAL32, such as 0.5, or its bit pattern in hex"),
    (0x08, "1e39", "00 00 00 00", "a decimal number for REAL32"),
    (0x08, "fast", "00 00 00 00", "a decimal number for REAL32"),
    # texts, among them such as look like numbers
    (0x09, "010", "30 31 30", ""),
    (0x09, "$NODEID", "24 4e 4f 44 45 49 44", ""),
    (0x09, "30 °C", "33 30 20 b0 43", "ASCII characters only"),
    (0x09, "5 €", "35 20 e2 82 ac", "ASCII characters only"),
    (0x0B, "5 €", "35 00 20 00 ac 20", ""),
    # numbers
    (0x07, "$NODEID + 0x600", "05 06 00 00", ""),
    (0x07, "0x80000200+$nodeid", "05 02 00 80", ""),
    (0x06, "80h", "80 00", "0x80: hexadecimal numbers start with 0x"),
    (0x06, "09", "09 00", "9: a leading 0 makes a number octal"),
    (0x06, "10.0", "0a 00", "10, a whole number"),
    (0x05, "TRUE", "01", "1"),
    (0x01, "false", "00", "0"),
    (0x05, "-1", "ff", "0xFF, the same value in 8 bits"),
    (0x03, "-0x10", "f0 ff", "-16: hexadecimal numbers have no sign"),
    (0x04, "-0x80000000", "00 00 00 80", "-2147483648: hexadecimal numbers have no sign"),
    (0x05, "-0x1", "ff", "0xFF, the same value in 8 bits"),
    (0x03, "-0x8001", "00 00", "-32768 to 32767, the range of INTEGER16"),
    (0x03, "0xFFFF8000", "00 80", "0x8000, the same value in 16 bits"),
    (0x03, "0x8000", "00 80", ""),
    (0x05, "256", "00", "0 to 255, the range of UNSIGNED8"),
    (0x03, "0x12345678", "00 00", "-32768 to 32767, the range of INTEGER16"),
    (0x05, "abc", "00", "a number, such as 10 or 0x0A"),
]  # fmt: skip


@pytest.mark.parametrize(("data_type", "text", "data", "odd"), VALUES)
def test_default_values_in_all_ways_of_writing(tmp_path: Path, data_type: int, text: str, data: str, odd: str) -> None:
    assert start(tmp_path, data_type, text) == data
    found = [finding for finding in oddities(tmp_path / "device.eds") if finding.key == "DefaultValue"]
    assert [(finding.line, finding.what, finding.is_refused) for finding in found] == (
        [(8, text, False)] if odd else []
    )
    assert all(finding.remedy.startswith(f"expected {odd}") for finding in found)


@pytest.mark.parametrize(
    ("said", "access", "is_odd"),
    [
        ("RW", "rw", False), ("Const", "const", False), ("rwr", "rwr", False),
        ("r", "ro", True), ("W", "wo", True), ("r/w", "rw", True), ("Read Only", "ro", True),
        ("read-write", "rw", True),
        ("constant", "const", True), ("always", "rw", True), ("", "rw", True),
    ],
)  # fmt: skip
def test_access_types_in_all_ways_of_writing(tmp_path: Path, said: str, access: str, is_odd: bool) -> None:
    dictionary = describe(tmp_path, f"[2000]\nDataType=5\nAccessType={said}\n")
    assert dictionary.find(0x2000, 0).access.value == access
    found = [finding for finding in oddities(tmp_path / "device.eds") if finding.key == "AccessType"]
    assert [(finding.line, f"read as {access}" in finding.remedy) for finding in found] == (
        [(7 if said else 5, True)] if is_odd else []
    )


@pytest.mark.parametrize(("text", "key", "said"), ODD)
def test_odd_file_becomes_a_node_and_what_is_odd_is_named(tmp_path: Path, text: str, key: str, said: str) -> None:
    assert describe(tmp_path, text).by_key(key).key == key
    assert said in "\n".join(map(str, check_eds(tmp_path / "device.eds"))).replace("8: ", "5: ")


def test_stored_eds_of_another_type_is_a_value_of_its_own(tmp_path: Path) -> None:
    """The node follows an EDS that has 1021h as UNSIGNED32, and returns four bytes."""
    bench = CanopenBench(eds(tmp_path, "[1021]\nDataType=7\nAccessType=ro\nDefaultValue=7\n"))
    assert bench.sdo("40 21 10 00 00 00 00 00") == "43 21 10 00 07 00 00 00"


# An object without a data type.


@pytest.mark.parametrize(("text", "message"), WRONG)
def test_an_object_of_an_unknown_type_is_left_out_and_the_others_stay(tmp_path: Path, text: str, message: str) -> None:
    dictionary = describe(tmp_path, text)
    assert dictionary.find(0x1000, 0) is not None
    with pytest.raises(Abort):
        dictionary.find(0x2000, 0)
    [found] = [finding for finding in oddities(tmp_path / "device.eds") if finding.key == "DataType"]
    assert re.match(message.removeprefix(":"), f"{found}")
    assert found.remedy.endswith("; the object is left out")


def test_a_file_is_refused_if_no_object_is_left(tmp_path: Path) -> None:
    path = tmp_path / "device.eds"
    path.write_text("[2000]\nAccessType=rw\n[2001]\nAccessType=rw\n")
    with pytest.raises(EdsError, match=r"device\.eds:1: error: the file has no object"):
        load(path, 5)


# Refused files.


@pytest.mark.parametrize("content", [b"", b"no section", b"[FileInfo]\nFileName=x\n", b"\x00\xff\xfe", b"[1000\n"])
def test_what_is_no_eds_is_said(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "no.eds"
    path.write_bytes(content)
    with pytest.raises(EdsError, match=r"no.eds:1: error: the file has no object"):
        load(path, 5)


KEYS = [
    "ParameterName",
    "ObjectType",
    "DataType",
    "AccessType",
    "DefaultValue",
    "LowLimit",
    "HighLimit",
    "CompactSubObj",
]
NAMES = [
    "1000",
    "1003",
    "1017",
    "1800",
    "1800sub1",
    "1A00",
    "2000",
    "2000sub0",
    "2000sub1",
    "2000Name",
    "A0",
    "DummyUsage",
]
TEXTS = st.one_of(
    st.sampled_from(["rw", "ro", "7", "8", "9", "0x0005", "0x0007", "$NODEID+1", "", "-1", "1.5", "0x0009", "2", "08"]),
    st.text(st.characters(exclude_categories=["Cs", "Cc"]), max_size=6),
)
SECTIONS = st.dictionaries(st.sampled_from(NAMES), st.dictionaries(st.sampled_from(KEYS), TEXTS))


def refusal(path: Path) -> str:
    try:
        load(path, 5)
    except EdsError as wrong:
        return str(wrong)
    return ""


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(SECTIONS)
def test_any_file_becomes_a_node_or_is_refused_in_words(
    tmp_path_factory: pytest.TempPathFactory, sections: dict[str, dict[str, str]]
) -> None:
    path = tmp_path_factory.mktemp("eds") / "any.eds"
    lines = [line for name, keys in sections.items() for line in (f"[{name}]", *(f"{k}={v}" for k, v in keys.items()))]
    path.write_text("\n".join(lines), encoding="utf-8")
    words = refusal(path)
    assert words.startswith("any.eds:") if words else CanopenBench(path).take() == ["705#00"]


@pytest.mark.parametrize(
    ("text", "number"), [("10", 10), ("0x1F", 31), ("010", 8), ("0", 0), ("-3", -3), (" 7 ", 7), ("-0x1F", -31)]
)
def test_numbers(text: str, number: int) -> None:
    assert parse_number(text) == number


@pytest.mark.parametrize("text", ["", "x", "1.5", "0x", "$NODEID", "08"])
def test_what_is_no_number(text: str) -> None:
    with pytest.raises(ValueError, match=r"not a number|invalid literal"):
        parse_number(text)
