"""`fieldrig iec check`, `fmt`, `run` and `symbols`, without a running rig."""

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest
from typer.testing import CliRunner

from fieldrig.system.exits import Exit
from fieldrig_devices.iec.commands import app

ROOT = Path(__file__).parents[3]
TANK = """\
PROGRAM PLC_PRG
VAR level : INT := 50; valve : BOOL; END_VAR
valve := level > 40;
IF valve THEN level := level - 1; END_IF
END_PROGRAM
"""
WRONG = """\
PROGRAM PLC_PRG
VAR a : INT; END_VAR
a := b;
a := TRUE;
END_PROGRAM
"""
NS = {"s": "http://www.3s-software.com/schemas/Symbolconfiguration.xsd"}


def iec(*arguments: object) -> Any:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def tank(tmp_path: Path) -> Path:
    return saved(tmp_path / "tank.st", TANK)


def saved(file: Path, text: str) -> Path:
    file.write_text(text, encoding="utf-8")
    return file


# ---- check


def test_check_tells_the_sizes_of_a_right_program(tank: Path) -> None:
    done = iec("check", tank)
    assert done.exit_code == 0, done.output
    assert "Code Size: " in done.stdout
    assert "Data Size: 3 bytes" in done.stdout


def test_check_lists_all_mistakes_with_their_places(tmp_path: Path) -> None:
    file = saved(tmp_path / "wrong.st", WRONG)
    done = iec("check", file)
    assert done.exit_code == 2
    assert [line.split(" ")[0] for line in done.stderr.splitlines() if line.startswith(str(file))] == [
        f"{file}:3:6:",
        f"{file}:4:6:",
    ]
    mistakes = json.loads(iec("check", file, "--json").stdout)
    assert [(mistake["line"], mistake["column"]) for mistake in mistakes if not mistake["is_note"]] == [(3, 6), (4, 6)]


def test_all_files_of_a_folder_are_one_program(tmp_path: Path) -> None:
    saved(tmp_path / "main.st", "PROGRAM PLC_PRG VAR a : INT; END_VAR a := Twice(a); END_PROGRAM")
    saved(tmp_path / "sub.st", "FUNCTION Twice : INT VAR_INPUT x : INT; END_VAR Twice := 2 * x; END_FUNCTION")
    saved(tmp_path / "readme.txt", "not a source")
    assert iec("check", tmp_path).exit_code == 0
    assert iec("check", tmp_path / "main.st").exit_code == 2


def test_xml_of_a_folder_that_is_no_program_is_left_out(tmp_path: Path) -> None:
    saved(tmp_path / "main.st", "PROGRAM PLC_PRG END_PROGRAM")
    other = saved(tmp_path / "terminals.xml", "<Terminals><Terminal/></Terminals>")
    assert iec("check", tmp_path).exit_code == 0
    assert "<Terminals> is not the root of a known format" in iec("check", other).stderr
    saved(tmp_path / "broken.xml", "<project")
    assert iec("check", tmp_path).exit_code == 2


def test_the_dialect_decides(tmp_path: Path) -> None:
    file = saved(tmp_path / "a.st", "PROGRAM PLC_PRG VAR a : LINT; END_VAR a := a + 1; END_PROGRAM")
    assert iec("check", file).exit_code == 2
    assert iec("check", file, "--dialect", "edition-3").exit_code == 0
    assert (
        "expected epas-4, edition-3 or codesys, got 'edition-4'" in iec("check", file, "--dialect", "edition-4").output
    )


@pytest.mark.long
def test_a_program_is_checked_for_the_objects_of_a_controller() -> None:
    conveyor, rig = ROOT / "configs/programs/conveyor.st", ROOT / "configs/conveyor.yaml"
    alone = iec("check", conveyor)
    assert (alone.exit_code, "is not declared" in alone.stderr) == (2, True)
    for more in ((), ("--device", "max4")):
        done = iec("check", conveyor, "--rig", rig, *more)
        assert done.exit_code == 0, done.output


def test_the_program_of_the_rig_file_itself_may_be_wrong(tmp_path: Path) -> None:
    saved(tmp_path / "own.st", WRONG)
    good = saved(tmp_path / "good.st", "PROGRAM PLC_PRG VAR t : UDINT; END_VAR t := PacDriveM.Timer1; END_PROGRAM")
    rig = saved(tmp_path / "rig.yaml", "time: virtual\nbuses: {}\ndevices: {plc: {kind: max4, program: own.st}}\n")
    assert iec("check", good, "--rig", rig).exit_code == 0
    assert iec("check", tmp_path / "own.st", "--rig", rig).exit_code == 2


@pytest.mark.long
@pytest.mark.parametrize("device", ["feeder", "sealer"])
def test_a_program_is_compiled_for_a_controller_whose_settings_refer_to_it(device: str) -> None:
    """Their register tables name variables of the program, which is left out of the rig."""
    program, rig = ROOT / f"configs/programs/{device}.st", ROOT / "configs/feeder.yaml"
    assert iec("check", program).exit_code == Exit.WRONG  # without the library there is no PTO00 and PWM00
    assert iec("check", program, "--rig", rig, "--device", device).exit_code == Exit.OK


def test_the_controller_has_to_be_in_the_rig(tank: Path) -> None:
    rig = ROOT / "configs/conveyor.yaml"
    assert "has no controller 'belt'" in str(iec("check", tank, "--rig", rig, "--device", "belt").exception)
    assert "--device needs --rig" in iec("check", tank, "--device", "max4").output


# ---- fmt


def test_fmt_writes_one_layout_and_keeps_comments(tmp_path: Path) -> None:
    file = saved(tmp_path / "a.st", "program PLC_PRG var a:INT; (* items *) end_var a:=a+1; end_program")
    assert (iec("fmt", file, "--check").exit_code, file.read_text()[:7]) == (2, "program")
    assert iec("fmt", file).stdout == f"{file}: formatted\n"
    text = file.read_text()
    assert "PROGRAM PLC_PRG\n" in text
    assert "a : INT;" in text
    assert "(* items *)" in text
    assert "a := a + 1;" in text
    again = iec("fmt", file)
    assert (again.exit_code, again.stdout, file.read_text()) == (0, "", text)
    assert iec("fmt", file, "--check").exit_code == 0


def test_fmt_leaves_a_file_with_mistakes_and_xml(tmp_path: Path) -> None:
    broken = saved(tmp_path / "a.st", "PROGRAM PLC_PRG a := ; END_PROGRAM")
    xml = saved(tmp_path / "b.xml", "<project/>")
    done = iec("fmt", broken, xml)
    assert (done.exit_code, f"{broken}:1:" in done.stderr) == (2, True)
    assert (broken.read_text(), xml.read_text()) == ("PROGRAM PLC_PRG a := ; END_PROGRAM", "<project/>")


def test_fmt_writes_the_standard_input_to_the_standard_output() -> None:
    text = "program PLC_PRG var a:INT; (* Größe *) end_var a:=a+1; end_program"
    done = CliRunner().invoke(app, ["fmt", "-"], input=text.encode())
    assert done.exit_code == 0
    assert "    a : INT; (* Größe *)\n" in done.stdout_bytes.decode()
    again = CliRunner().invoke(app, ["fmt", "-"], input=done.stdout_bytes)
    assert again.stdout_bytes == done.stdout_bytes
    wrong = CliRunner().invoke(app, ["fmt", "-"], input="PROGRAM PLC_PRG a := ; END_PROGRAM")
    assert (wrong.exit_code, wrong.stdout, wrong.stderr.partition(" ")[0]) == (2, "", "-:1:22:")
    assert "one of several files" in str(iec("fmt", "-", "a.st").exception)


# ---- run


TYPES = """\
TYPE Light : (red, yellow, green := 10); END_TYPE
PROGRAM PLC_PRG
VAR
  t : TIME := T#65s; d : DATE := D#1998-12-07; o : TOD := TOD#12:00:00.123; x : DT := DT#1998-02-13-14:20;
  l : Light := green; r : REAL := 0.1; n : INT := 5; b : BOOL := TRUE; s : STRING := 'on';
END_VAR
END_PROGRAM
"""


@pytest.mark.parametrize(
    ("option", "meant"),
    [
        (("--watch", "level"), "PLC_PRG.level"),
        (("--watch", "PLC_PRG.levl"), "PLC_PRG.level"),
        (("--set", "vlave=1"), "PLC_PRG.valve"),
        (("--watch", "quite_different"), ""),
    ],
)
def test_run_proposes_the_variable_that_a_wrong_name_may_mean(tank: Path, option: tuple[str, str], meant: str) -> None:
    done = iec("run", tank, "--for", "1s", *option)
    name = option[1].partition("=")[0]
    expected = f"; did you mean {meant}?" if meant else ""
    assert done.exit_code == 2
    assert f"{name} is not a variable of the program{expected}\n" in done.stderr


def test_run_shows_values_as_the_language_writes_them_and_numbers_in_json(tmp_path: Path) -> None:
    file = saved(tmp_path / "types.st", TYPES)
    done = iec("run", file, "--for", "15ms")
    rows = [line.split() for line in done.stdout.splitlines()[1:]]
    assert {row[0].removeprefix("PLC_PRG."): row[-1] for row in rows} == {
        "t": "T#1m5s", "d": "D#1998-12-07", "o": "TOD#12:00:00.123", "x": "DT#1998-02-13-14:20",
        "l": "green", "r": "0.1", "n": "5", "b": "TRUE", "s": "'on'",
    }  # fmt: skip
    found = json.loads(iec("run", file, "--for", "15ms", "--json").stdout)
    assert (found["PLC_PRG.t"], found["PLC_PRG.l"]) == (65_000, 10)


def test_run_shows_the_variables_at_the_end(tank: Path) -> None:
    """A task of 10 ms has six cycles from 0 to 50 ms."""
    done = iec("run", tank, "--for", "1s", "--json")
    assert (done.exit_code, json.loads(done.stdout)) == (0, {"PLC_PRG.level": 40, "PLC_PRG.valve": False})
    table = iec("run", tank, "--for", "50ms", "--watch", "PLC_PRG.level").stdout.splitlines()
    assert [line.split() for line in table] == [["variable", "type", "value"], ["PLC_PRG.level", "INT", "44"]]


def test_run_starts_with_values_from_outside(tank: Path) -> None:
    done = iec("run", tank, "--for", "20ms", "--set", "PLC_PRG.level=16#20", "--json")
    assert json.loads(done.stdout) == {"PLC_PRG.level": 32, "PLC_PRG.valve": False}


def test_run_ends_with_a_fault_of_the_program(tmp_path: Path) -> None:
    file = saved(tmp_path / "a.st", "PROGRAM PLC_PRG VAR a : INT := 3; END_VAR\na := a - 1;\na := 6 / a;\nEND_PROGRAM")
    done = iec("run", file, "--for", "1s", "--set", "PLC_PRG.a=1")
    assert (done.exit_code, f"{file}:3" in done.stderr) == (6, True)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (("--for", "soon"), "is not a duration"),
        (("--for", "1s", "--set", "PLC_PRG.level"), "expected NAME=VALUE"),
        (("--for", "1s", "--set", "PLC_PRG.level=x"), "expected a constant"),
        (("--for", "1s", "--set", "PLC_PRG.level=1,5"), "PLC_PRG.level: expected a constant of type"),
        (("--for", "1s", "--set", "PLC_PRG.level=5s"), "expected T#5s"),
        (("--for", "1s", "--watch", "PLC_PRG.tap"), "is not a variable"),
        ((), "expected a time, because there is no terminal"),
    ],
)
def test_run_says_what_it_expects(tank: Path, more: tuple[str, ...], message: str) -> None:
    done = iec("run", tank, *more)
    assert (done.exit_code, message in " ".join(done.output.replace("│", "").split())) == (2, True), done.output


def test_run_needs_a_program_and_not_only_functions(tmp_path: Path) -> None:
    done = iec("run", saved(tmp_path / "only.st", "FUNCTION f : INT\nf := 1;\nEND_FUNCTION\n"), "--for", "1s")
    assert (done.exit_code, "there is no program to run" in str(done.exception)) == (1, True)


def test_run_takes_the_resource_that_is_named(tmp_path: Path) -> None:
    file = saved(tmp_path / "two.st", RESOURCES)
    done = iec("run", file, "--for", "100ms", "--resource", "Two", "--json")
    assert json.loads(done.stdout)["PLC_PRG.n"] == 6  # from 0 to 100 ms
    done = iec("check", file)
    assert (done.exit_code, "there are the resources One, Two" in done.stderr) == (2, True)
    assert iec("check", file, "--resource", "One").exit_code == 0


RESOURCES = """PROGRAM PLC_PRG VAR n : INT; END_VAR n := n + 1; END_PROGRAM
CONFIGURATION c
RESOURCE One ON PLC TASK T(INTERVAL := T#10ms); PROGRAM p WITH T : PLC_PRG; END_RESOURCE
RESOURCE Two ON PLC TASK T(INTERVAL := T#20ms); PROGRAM p WITH T : PLC_PRG; END_RESOURCE
END_CONFIGURATION
"""


def test_run_lists_the_mistakes_of_a_program(tmp_path: Path) -> None:
    done = iec("run", saved(tmp_path / "wrong.st", WRONG), "--for", "1s")
    assert (done.exit_code, "wrong.st:3:6: " in done.stderr, "wrong.st:4:6: " in done.stderr) == (2, True, True)
    assert "note" not in done.stderr, "that the program has no task configuration is no mistake"


# ---- symbols


def test_symbols_of_sources(tank: Path, tmp_path: Path) -> None:
    output = tmp_path / "tank.xml"
    done = iec("symbols", output, tank)
    assert (done.exit_code, done.stdout.startswith(f"{output}: ")) == (0, True)
    nodes = ET.parse(output).findall(".//s:Node[@name='PLC_PRG']/s:Node", NS)
    assert {node.get("name") for node in nodes} == {"level", "valve"}


def test_symbols_of_a_wrong_program_write_nothing(tmp_path: Path) -> None:
    done = iec("symbols", tmp_path / "a.xml", saved(tmp_path / "wrong.st", WRONG))
    assert (done.exit_code, (tmp_path / "a.xml").exists()) == (2, False)
    assert "expected source files" in str(iec("symbols", tmp_path / "a.xml").exception)


@pytest.mark.parametrize(
    ("name", "data", "expected"),
    [
        ("Belt.plcproj", b'<Project xmlns="http://schemas.microsoft.com/developer/msbuild/2003"/>', "Give the folder"),
        ("Belt.project", b"PK\x03\x04\x14\x00\x06\x00", "choose Project, Export PLCopenXML"),
    ],
)
def test_check_says_what_to_give_instead_of_a_file_of_a_project(
    tmp_path: Path, name: str, data: bytes, expected: str
) -> None:
    (tmp_path / name).write_bytes(data)
    result = iec("check", tmp_path / name)
    assert result.exit_code != 0
    assert expected in " ".join(f"{result.output} {result.exception}".split())
