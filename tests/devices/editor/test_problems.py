"""`fieldrig editor problems` and `rigs`: what an editor shows of a file."""

import json
from pathlib import Path
from typing import Any

import pytest
from pam_programs import MACHINE
from typer.testing import CliRunner

from fieldrig_devices.editor.commands import app

ROOT = Path(__file__).parents[3]
CONTROLLER = "time: virtual\nbuses: {}\ndevices: {controller: {kind: max4, program: count.st}}\n"
COUNT = "PROGRAM PLC_PRG\nVAR a : INT; END_VAR\na := a + 1;\nEND_PROGRAM\n"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def asked(command: str, *arguments: object) -> Any:
    done = CliRunner().invoke(app, [command, *map(str, arguments)])
    assert done.exit_code == 0, (done.output, done.exception)
    return json.loads(done.stdout)


def problems(file: str, *options: str) -> list[tuple[str, int, int, str, str]]:
    found = asked("problems", file, *options)
    return [(Path(one["file"]).name, one["line"], one["column"], one["severity"], one["message"]) for one in found]


def saved(name: str, text: str) -> None:
    file = Path(name)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")


def test_a_program_in_a_rig_has_the_problems_of_its_controller() -> None:
    saved("rig.yaml", CONTROLLER)
    saved("count.st", COUNT.replace("a + 1", "a + b"))
    expected = [("count.st", 3, 10, "error", "b is not declared\nexpected a name from a declaration")]
    assert problems("count.st") == expected
    assert problems("rig.yaml") == expected


def test_objects_of_the_controller_are_known() -> None:
    saved("rig.yaml", CONTROLLER)
    saved("count.st", COUNT.replace("a + 1", "DWORD_TO_INT(PacDriveM.Timer1)"))
    assert problems("count.st") == []


def test_the_rig_file_may_be_above_the_program() -> None:
    saved("rig.yaml", CONTROLLER.replace("count.st", "programs/count.st"))
    saved("programs/count.st", COUNT)
    saved("programs/other.st", COUNT)
    assert asked("rigs", "programs/count.st") == [str(Path("rig.yaml").absolute())]
    assert asked("rigs", "programs/other.st") == []


def test_rig_files_above_the_current_folder_are_none_of_ours(monkeypatch: pytest.MonkeyPatch) -> None:
    saved("rig.yaml", CONTROLLER.replace("count.st", "programs/count.st"))
    saved("programs/count.st", COUNT)
    monkeypatch.chdir("programs")
    assert asked("rigs", "count.st") == []


def test_mistakes_and_doubts_of_a_rig_have_their_lines() -> None:
    saved("rig.yaml", "time: virtual\nbuses: {}\ndevices:\n  a: {kind: max4, cycle: 1}\n  b:\n    kind: nothing\n")
    found = problems("rig.yaml")
    assert [(file, line, column, severity) for file, line, column, severity, _ in found] == [
        ("rig.yaml", 4, 1, "error"),
        ("rig.yaml", 6, 1, "error"),
    ]
    assert found[0][4].startswith("devices.a.cycle: there is no such key\n")


def test_another_yaml_file_has_no_problems() -> None:
    saved("compose.yaml", "services:\n  a: {image: b}\n")
    saved("broken.yaml", "a: [\n")
    assert problems("compose.yaml") == problems("broken.yaml") == []


def test_a_program_without_a_rig_is_checked_with_the_files_beside_it() -> None:
    saved("main.st", "PROGRAM PLC_PRG\nVAR up : Counter; END_VAR\nup();\nEND_PROGRAM\n")
    saved("counter.st", "FUNCTION_BLOCK Counter\nVAR a : INT; END_VAR\na := TRUE;\nEND_FUNCTION_BLOCK\n")
    saved("unrelated.st", "PROGRAM other\nbroken\nEND_PROGRAM\n")
    found = problems("main.st")
    assert [one[:4] for one in found if one[3] == "error"] == [("counter.st", 3, 6, "error")]
    saved("counter.st", "FUNCTION_BLOCK Counter\nVAR a : INT; END_VAR\na := 1;\nEND_FUNCTION_BLOCK\n")
    assert [one[:4] for one in problems("main.st")] == [("main.st", 1, 1, "note")]


def test_a_test_file_is_checked_with_its_tests_and_code() -> None:
    saved("twice.st", "FUNCTION Twice : INT\nVAR_INPUT x : INT; END_VAR\nTwice := 2 * x;\nEND_FUNCTION\n")
    saved("twice_test.st", "TEST 'two'\nASSERT_EQ(Twice(1), 2);\nASSERT_EQ(Twice(y), 2);\nEND_TEST\n")
    assert [one[:4] for one in problems("twice_test.st")] == [("twice_test.st", 3, 17, "error")]


def test_the_dialect_is_that_of_the_editor() -> None:
    saved("a.st", COUNT.replace("a := a + 1;", "// a comment\na := a + 1;"))
    assert [one[3] for one in problems("a.st")] == ["note", "error"]
    assert [one[3] for one in problems("a.st", "--dialect", "codesys")] == ["note"]


def test_programs_of_a_pam_and_of_arp_cards() -> None:
    saved("belt.pam", MACHINE + "TASK TSK_a; SEQUENCE SEQ_a; AXI_Blt <- stop; END_SEQUENCE END_TASK\n")
    ((file, line, _, severity, message),) = problems("belt.pam")
    assert (file, line, severity) == ("belt.pam", MACHINE.count("\n") + 1, "error")
    assert message.endswith("Perhaps AXI_Belt is meant.")
    saved("cam.I01", "BEG MAIN\nV1 = 2\nEND\n")
    assert problems("cam.I01") == [("cam.I01", 2, 4, "error", "values are assigned by ==, and = compares; expected ==")]


@pytest.mark.long
def test_the_shipped_rigs_and_programs_have_no_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    for name in ("arp-cell.yaml", "programs/line.I01"):
        assert [one for one in problems(f"configs/{name}") if one[3] == "error"] == []


@pytest.mark.parametrize("name", ["nowhere.st", "nowhere.yaml", "nowhere.pam", "nowhere.I01", "."])
def test_a_file_that_is_not_there_is_refused(name: str) -> None:
    done = CliRunner().invoke(app, ["problems", name])
    assert f"{name} cannot be read" in str(done.exception)


@pytest.mark.parametrize(
    ("name", "data", "severities"),
    [
        ("a.yaml", b"devices: [\n", {"error"}),
        ("a.yaml", b"devices:\n  - a\n", {"error"}),
        ("a.yaml", b"extends: nowhere.yaml\n", {"error"}),
        ("a.yaml", bytes(range(256)), set()),
        ("a.st", bytes(range(256)), {"error"}),
        ("a.st", b"", {"note"}),
        ("a.pam", b"", {"error"}),
        ("a.I01", b"\xff\xfe\x00", {"error"}),
    ],
)
def test_odd_files_have_problems_with_places(name: str, data: bytes, severities: set[str]) -> None:
    Path(name).write_bytes(data)
    found = problems(name)
    assert {severity for _, _, _, severity, _ in found} == severities
    assert all(line >= 1 and column >= 1 for _, line, column, _, _ in found)
