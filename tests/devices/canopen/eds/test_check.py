"""The linter for EDS files: our files pass, and each mistake is reported with what was expected."""

import json
from pathlib import Path

import pytest
from canopen_bench import IO32, LEVEL_SENSOR
from eds_oddities import MISTAKES
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from fieldrig.errors import UsageError
from fieldrig_devices.canopen.commands import app
from fieldrig_devices.canopen.eds.check import Severity, check_eds

TEXT = IO32.read_text()


@pytest.mark.parametrize("path", [IO32, LEVEL_SENSOR], ids=lambda path: path.name)
def test_our_files_pass(path: Path) -> None:
    assert check_eds(path) == []


@pytest.mark.long
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


def test_a_mapping_has_no_more_entries_than_there_are_sub_indices(tmp_path: Path) -> None:
    """A check that counted to 4294967295 would run into the time-out of the tests."""
    path = tmp_path / "io32.eds"
    head = "[1600sub0]\nParameterName=Number of mapped objects in PDO\nObjectType=0x7\nDataType=0x0005\nAccessType=rw\n"
    assert f"{head}DefaultValue=4" in TEXT
    path.write_text(TEXT.replace(f"{head}DefaultValue=4", f"{head}DefaultValue=4294967295"))
    assert any("1600sub0" in str(finding) for finding in check_eds(path))


@pytest.mark.parametrize("key", ["\u00b2", "9" * 5000])
def test_a_number_in_a_list_of_objects_that_is_none(tmp_path: Path, key: str) -> None:
    path = tmp_path / "io32.eds"
    path.write_text(TEXT.replace("[OptionalObjects]\n", f"[OptionalObjects]\n{key}=0x1000\n"))
    check_eds(path)


@pytest.mark.parametrize(("sub", "is_described"), [(0, False), (1, True), (4, True), (5, False)])
def test_members_of_a_compact_array_may_be_mapped(tmp_path: Path, sub: int, is_described: bool) -> None:
    """One section describes all members except sub-index 0 (CiA 306-1 4.6.3.2)."""
    path = tmp_path / "io32.eds"
    described = "ObjectType=0x8\nCompactSubObj=4\nDataType=0x0003\nAccessType=rww\nPDOMapping=1\n"
    head = "[6411]\nParameterName=Write analogue output 16-bit\n"
    text = TEXT.replace(f"{head}ObjectType=0x8\nSubNumber=5\n", head + described)
    before, after = text[: text.index("[6411sub0]")], text[text.index("[6421]") :]
    path.write_text((before + after).replace("DefaultValue=0x64110110", f"DefaultValue=0x6411{sub:02d}10"))
    said = [str(finding) for finding in check_eds(path)]
    assert all(f"sub-index {sub} is not described" in text for text in said)
    assert bool(said) != is_described


def test_findings_come_in_order_of_lines_with_place_and_remedy(tmp_path: Path) -> None:
    path = tmp_path / "bare.eds"
    path.write_text("[FileInfo]\n[1000]\nDataType=7\n")
    found = check_eds(path)
    assert [finding.line for finding in found] == sorted(finding.line for finding in found)
    assert all(finding.what and finding.remedy for finding in found)
    assert (
        str(found[-1])
        == "2: error: [1000] AccessType: is missing; expected one of ro, wo, rw, rwr, rww, const; it is read as rw"
    )


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
@pytest.mark.long
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
    assert all(finding.remedy for finding in check_eds(path))


# The command


def run(*arguments: str) -> tuple[int, str]:
    done = CliRunner().invoke(app, ["check", *arguments])
    return done.exit_code, done.output


def test_command_says_so_when_there_is_nothing(tmp_path: Path) -> None:
    assert run(str(IO32)) == (0, f"{IO32}: no errors and no warnings\n")


def test_command_fails_on_errors_and_names_file_and_line(tmp_path: Path) -> None:
    path = tmp_path / "io32.eds"
    path.write_text(TEXT.replace("SubNumber=5", "SubNumber=4"))
    code, said = run(str(path))
    assert code == 2
    line = TEXT.splitlines().index("SubNumber=5") + 1
    assert said.startswith(
        f"{path}:{line}: error: [1018] SubNumber: 4; expected 5, the number of described sub-indices\n"
    )


def test_command_gives_json_and_passes_with_warnings(tmp_path: Path) -> None:
    path = tmp_path / "other.eds"
    path.write_text(TEXT)
    code, said = run("--json", str(path))
    assert code == 0
    finding = json.loads(said)
    assert (finding["severity"], finding["key"], finding["remedy"]) == ("warning", "FileName", "the file is other.eds")
    assert [finding.severity for finding in check_eds(path)] == [Severity.WARNING]


def test_command_says_which_file_can_t_be_read(tmp_path: Path) -> None:
    refused = CliRunner().invoke(app, ["check", str(tmp_path / "none.eds")]).exception
    assert isinstance(refused, UsageError)
    assert "cannot be read: No such file" in str(refused)
