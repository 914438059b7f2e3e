"""The linter for EDS files: our files pass, each mistake is found, and said with what would be right."""

import json
from pathlib import Path

import pytest
from canopen_bench import IO32, LEVEL_SENSOR
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from fieldrig_devices.canopen.commands import app
from fieldrig_devices.canopen.eds_check import Severity, check_eds

TEXT = IO32.read_text()


@pytest.mark.parametrize("path", [IO32, LEVEL_SENSOR], ids=lambda path: path.name)
def test_our_files_pass(path: Path) -> None:
    assert check_eds(path) == []


# What stands in the file, what a maker might write instead, and what is said of it.
MISTAKES: list[tuple[str, str, str]] = [
    # lines and sections
    ("[Comments]", "nonsense\n[Comments]", "'nonsense' is neither section nor key; write [Section], key=value"),
    ("[Comments]", "[FileInfo]\nFileName=x\n[Comments]", "[FileInfo]: is there already, in line 1; put all keys"),
    ("OrderCode=IO32", "OrderCode=IO32\nOrderCode=IO33", "OrderCode: is there already, in line 20; keep one"),
    ("OrderCode=IO32", "OrderCode=" + "x" * 250, "a line of 260 characters; at most 255 are allowed"),
    # file info
    ("FileName=io32.eds", "FileName=other.eds", "FileName: other.eds; the file is io32.eds"),
    ("FileVersion=1\n", "", "[FileInfo] FileVersion: is missing; write FileVersion="),
    ("FileRevision=0", "FileRevision=300", "FileRevision: 300; a number from 0 to 255"),
    ("EDSVersion=4.0", "EDSVersion=4", "EDSVersion: 4; write it like 4.0"),
    ("CreationTime=10:00AM", "CreationTime=10:00", "CreationTime: 10:00; write it like 10:30AM"),
    ("CreationDate=11-21-2026", "CreationDate=21-11-2026", "write it like 11-21-2026 (month, day, year)"),
    # device info
    ("VendorName=fieldrig\n", "", "[DeviceInfo] VendorName: is missing"),
    ("BaudRate_50=1", "BaudRate_50=yes", "BaudRate_50: yes; 0 or 1 would be right"),
    ("Granularity=1", "Granularity=65", "Granularity: 65; 0 (no PDO mapping) to 64 bits"),
    ("NrOfRXPDO=2", "NrOfRXPDO=4", "NrOfRXPDO: 4; 2, as many as are described"),
    ("NrOfTXPDO=2", "NrOfTXPDO=0x3", "NrOfTXPDO: 0x3; 2, as many as are described"),
    ("ProductNumber=0x00000020", "ProductNumber=0x21", "ProductNumber: 0x21; [1018sub2] says 0x20: write the same"),
    ("ProductNumber=0x00000020", "ProductNumber=IO32", "ProductNumber: IO32; a number, such as 0x0000001F"),
    # dummies and comments
    ("Dummy0003=1\n", "", "[DummyUsage] Dummy0003: is missing"),
    ("Dummy0003=1", "Dummy0003=2", "Dummy0003: 2; 0 or 1"),
    ("Lines=2", "Lines=3", "[Comments] Lines: 3; 2, as many as are there"),
    # lists
    ("SupportedObjects=3", "SupportedObjects=4", "[MandatoryObjects] SupportedObjects: 4; 3, as many as are listed"),
    ("3=0x1018", "4=0x1018", "the numbers have gaps; number them from 1 to 3"),
    ("3=0x1018", "3=1018h", "[MandatoryObjects] 3: 1018h; an index would be right, such as 0x1018"),
    ("3=0x1018", "3=0x1017", "0x1017 is listed already in [MandatoryObjects]; list it once"),
    ("3=0x1018", "3=0x2222", "0x2222 has no section; describe it in [2222], or take it from the list"),
    ("3=0x1018", "3=0x2222", "[1018]: is in no list; add it to [MandatoryObjects]"),
    ("3=0x1018", "3=0x2000", "0x2000 belongs into another list; move it to [ManufacturerObjects]"),
    ("[1001]", "[5001]", "[1001]: the object is missing; CiA 301 asks for 1000h, 1001h and 1018h"),
    ("[OptionalObjects]", "[OptObjects]", "[OptionalObjects]: the section is missing"),
    # objects
    ("[1018sub4]", "[1019sub4]", "[1019] is no ARRAY or RECORD; set its ObjectType to 0x8 or 0x9"),
    ("[1018sub4]", "[3018sub4]", "[3018sub4]: belongs to no object; write a section [3018]"),
    ("[1018sub4]", "[1018sub04]", "sub-index with a leading zero; write it like [1018sub1]"),
    ("SubNumber=5", "SubNumber=4", "SubNumber: 4; 5, as many sub-indices as are described"),
    ("[1016sub0]", "[1016sub7]", "[1016]: has no sub-index 0; describe it in [1016sub0]"),
    ("AccessType=const\nDefaultValue=4\n", "AccessType=const\nDefaultValue=5\n",
     "DefaultValue: 5; 4, the highest sub-index"),
    ("ParameterName=Device type\n", "", "[1000] ParameterName: is missing"),
    ("ParameterName=Device type\nObjectType=0x7", "ParameterName=Device type\nObjectType=0x3",
     "0x7 (VAR), 0x8 (ARRAY)"),
    ("DataType=0x0009\nAccessType=rw", "DataType=0x0099\nAccessType=rw", "[2000] DataType: 0x0099; a type of CiA 301"),
    ("DataType=0x0009\nAccessType=rw", "DataType=0x0009\nAccessType=r/w", "AccessType: r/w; one of ro, wo, rw, rwr"),
    ("Producer heartbeat time\nObjectType=0x7\nDataType=0x0006", "T\nObjectType=0x7\nDataType=0x0007",
     "[1017] DataType: 0x0007; 0x0006 (UNSIGNED16), as CiA 301 has it"),
    ("DefaultValue=control cabinet 1\nPDOMapping=0", "PDOMapping=yes", "[2000] PDOMapping: yes; 0 or 1"),
    ("AccessType=const\nDefaultValue=IO32\n", "AccessType=const\n",
     "[1008] DefaultValue: is missing; a constant needs"),
    # values
    ("LowLimit=-100", "LowLimit=101", "[2002] LowLimit: 101; not more than HighLimit"),
    ("DefaultValue=0\nLowLimit=-100", "DefaultValue=-101\nLowLimit=-100", "-101; within the limits, -100 to 100"),
    ("HighLimit=100", "HighLimit=40000", "HighLimit: 40000; from -32768 to 32767, what INTEGER16 can hold"),
    ("DefaultValue=0x000F0191", "DefaultValue=000F0191h", "0x000F0191: hexadecimal numbers begin with 0x"),
    ("DefaultValue=0x000F0191", "DefaultValue=F0191", "a number, such as 10 or 0x0A, or one with $NODEID"),
    ("DefaultValue=control cabinet 1", "DefaultValue=x\nHighLimit=5", "VISIBLE_STRING has no limits: leave it out"),
    # PDOs and COB-IDs
    ("DefaultValue=0x62000108", "DefaultValue=0x62000508", "an object that is there: 6200h sub-index 5"),
    ("DefaultValue=0x62000108", "DefaultValue=0x62020108", "an object with PDOMapping=1: [6202sub1] has not"),
    ("DefaultValue=0x62000108", "DefaultValue=0x60000108", "AccessType=ro, which an RPDO can't carry"),
    ("DefaultValue=0x60000108", "DefaultValue=0x62000108", "AccessType=rww, which a TPDO can't carry"),
    ("DefaultValue=0x62000108", "DefaultValue=0x62000110", "0x62000108: [6200sub1] has 8 bits"),
    ("DefaultValue=0x60000108", "DefaultValue=0x00050008", "an object: dummies are for RPDOs only"),
    ("DefaultValue=0x62000108", "DefaultValue=0x00010001", "a dummy that [DummyUsage] allows: write Dummy0001=1"),
    ("DefaultValue=0x62000108", "DefaultValue=0x00050010", "the length of the dummy's data type"),
    ("[1A00]", "[1A05]", "[1800]: has no mapping; describe [1A00]"),
    ("[1400]", "[1405]", "[1600]: has no communication parameter; describe [1400]"),
    ("DefaultValue=$NODEID+0x200", "DefaultValue=0x205",
     "is the same for each node made from this file; $NODEID+0x200"),
    ("DefaultValue=$NODEID+0x200", "DefaultValue=$NODEID+0x201", "CiA 301 has $NODEID+0x200 here"),
    ("DefaultValue=0x80\n", "DefaultValue=0x601\n", "[1005] DefaultValue: 0x601; a CAN-ID that CiA 301 leaves free"),
]  # fmt: skip


@pytest.mark.parametrize(("right", "wrong", "said"), MISTAKES)
def test_mistake_is_said_with_what_would_be_right(tmp_path: Path, right: str, wrong: str, said: str) -> None:
    assert right in TEXT
    path = tmp_path / "io32.eds"
    path.write_text(TEXT.replace(right, wrong, 1))
    assert said in "\n".join(map(str, check_eds(path)))


def test_mapping_longer_than_a_pdo(tmp_path: Path) -> None:
    path = tmp_path / "io32.eds"
    path.write_text(TEXT.replace("0x62000108", "0x64110110").replace("0x62000208", "0x64110210")
                    .replace("0x62000308", "0x64110310").replace("0x62000408", "0x64110410")
                    .replace("[1600sub5]\nParameterName=Mapped object 5\nObjectType=0x7\nDataType=0x0007\n"
                             "AccessType=rw\nDefaultValue=0", "[1600sub5]\nParameterName=Mapped object 5\n"
                             "ObjectType=0x7\nDataType=0x0007\nAccessType=rw\nDefaultValue=0x62000108")
                    .replace("[1600sub0]\nParameterName=Number of mapped objects in PDO\nObjectType=0x7\n"
                             "DataType=0x0005\nAccessType=rw\nDefaultValue=4", "[1600sub0]\nParameterName=N\n"
                             "ObjectType=0x7\nDataType=0x0005\nAccessType=rw\nDefaultValue=5"))  # fmt: skip
    assert "5 entries with 72 bits; at most 64 bits fit" in "\n".join(map(str, check_eds(path)))


@pytest.mark.parametrize(("sub", "is_described"), [(0, False), (1, True), (4, True), (5, False)])
def test_members_of_a_compact_array_may_be_mapped(tmp_path: Path, sub: int, is_described: bool) -> None:
    """CiA 306-1 4.6.3.2: one section tells of all members but sub-index 0."""
    path = tmp_path / "io32.eds"
    described = "ObjectType=0x8\nCompactSubObj=4\nDataType=0x0003\nAccessType=rww\nPDOMapping=1\n"
    head = "[6411]\nParameterName=Write analogue output 16-bit\n"
    text = TEXT.replace(f"{head}ObjectType=0x8\nSubNumber=5\n", head + described)
    before, after = text[: text.index("[6411sub0]")], text[text.index("[6421]") :]
    path.write_text((before + after).replace("DefaultValue=0x64110110", f"DefaultValue=0x6411{sub:02d}10"))
    said = [str(one) for one in check_eds(path)]
    assert all(f"sub-index {sub} is not described" in one for one in said)
    assert bool(said) != is_described


def test_findings_come_in_order_of_lines_with_place_and_remedy(tmp_path: Path) -> None:
    path = tmp_path / "bare.eds"
    path.write_text("[FileInfo]\n[1000]\nDataType=7\n")
    found = check_eds(path)
    assert [one.line for one in found] == sorted(one.line for one in found)
    assert all(one.what and one.remedy for one in found)
    assert str(found[-1]) == "2: error: [1000] AccessType: is missing; one of ro, wo, rw, rwr, rww, const"


lines = TEXT.splitlines()


@settings(max_examples=150, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.integers(0, len(lines) - 1), st.sampled_from(["drop", "twice", "cut", "garble"]), st.text(max_size=8)
        ),
        max_size=20,
    )
)
def test_no_file_raises(tmp_path_factory: pytest.TempPathFactory, edits: list[tuple[int, str, str]]) -> None:
    changed = list(lines)
    for number, what, text in edits:
        line = changed[number]
        key = line.partition("=")[0]
        changed[number] = {
            "drop": "",
            "twice": f"{line}\n{line}",
            "cut": line[: len(line) // 2],
            "garble": f"{key}={text}",
        }[what]
    path = tmp_path_factory.mktemp("eds") / "io32.eds"
    path.write_text("\n".join(changed), encoding="utf-8", errors="replace")
    assert all(one.remedy for one in check_eds(path))


# The command


def run(*arguments: str) -> tuple[int, str]:
    done = CliRunner().invoke(app, ["check", *arguments])
    return done.exit_code, done.output


def test_command_says_so_when_there_is_nothing(tmp_path: Path) -> None:
    assert run(str(IO32)) == (0, f"{IO32}: nothing to find fault with\n")


def test_command_fails_on_errors_and_names_file_and_line(tmp_path: Path) -> None:
    path = tmp_path / "io32.eds"
    path.write_text(TEXT.replace("SubNumber=5", "SubNumber=4"))
    code, said = run(str(path))
    assert code == 2
    line = TEXT.splitlines().index("SubNumber=5") + 1
    assert said.startswith(f"{path}:{line}: error: [1018] SubNumber: 4; 5, as many sub-indices as are described\n")


def test_command_gives_json_and_passes_with_warnings(tmp_path: Path) -> None:
    path = tmp_path / "other.eds"
    path.write_text(TEXT)
    code, said = run("--json", str(path))
    assert code == 0
    finding = json.loads(said)
    assert (finding["severity"], finding["key"], finding["remedy"]) == ("warning", "FileName", "the file is other.eds")
    assert [one.severity for one in check_eds(path)] == [Severity.WARNING]


def test_command_says_which_file_can_t_be_read(tmp_path: Path) -> None:
    code, said = run(str(tmp_path / "none.eds"))
    assert (code, "can't be read: No such file" in said) == (2, True)
