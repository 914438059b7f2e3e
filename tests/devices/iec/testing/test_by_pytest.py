"""Files of pytest among the tests of programs: one list, one report, one exit code."""

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest
from st_tests import written
from typer.testing import CliRunner, Result

from fieldrig.system.exits import Exit
from fieldrig_devices.iec.commands import app

pytestmark = [pytest.mark.lean, pytest.mark.long]

TWICE = "FUNCTION Twice : INT\nVAR_INPUT a : INT; END_VAR\nTwice := 2 * a;\nEND_FUNCTION\n"
BLOCK = "TEST 'twice' ASSERT_EQ(Twice(2), 4); END_TEST\n"
TESTS = """\
import pytest
from fieldrig import program


@pytest.mark.parametrize("a", [1, 2])
def test_twice(a):
    assert program(__file__.replace("test_twice.py", "twice.st")).function("Twice")(a) == 2 * a


@pytest.mark.skip(reason="the customer decides")
def test_later():
    pass


def test_wrong():
    print("a line")
    assert 1 + 1 == 3, "not even here"
"""


def iec_test(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["test", *map(str, arguments)])


def folder_of(tmp_path: Path) -> Path:
    (tmp_path / "test_twice.py").write_text(TESTS)
    return written(tmp_path, twice=TWICE, twice_test=BLOCK)


def test_both_kinds_are_in_one_report(tmp_path: Path) -> None:
    folder, junit = folder_of(tmp_path), tmp_path / "report.xml"
    done = iec_test(folder / "twice_test.st", folder / "test_twice.py", "--junit", junit)
    assert done.exit_code == Exit.TESTS_FAILED, done.output
    assert "  skipped test_later  (the customer decides)\n" in done.stdout
    assert f'{folder}/test_twice.py:17\n    assert 1 + 1 == 3, "not even here"\n' in done.stdout
    assert "AssertionError: not even here" in done.stdout
    assert "5 tests: 3 passed, 1 failed, 1 skipped" in done.stdout
    cases = {case.get("name"): case for case in ElementTree.parse(junit).iter("testcase")}
    assert list(cases) == ["test_twice[1]", "test_twice[2]", "test_later", "test_wrong", "twice"]
    assert cases["test_wrong"].get("line") == "15"
    assert cases["test_wrong"].findtext("system-out") == "a line"


def test_tests_are_listed_and_chosen_by_name(tmp_path: Path) -> None:
    file = folder_of(tmp_path) / "test_twice.py"
    listed = json.loads(iec_test(file, "--list", "--json").stdout)
    assert [(one["name"], one["line"]) for one in listed][-2:] == [("test_later", 10), ("test_wrong", 15)]
    done = iec_test(f"{file}::test_twice[[]2]")
    assert (done.exit_code, "1 test: 1 passed" in done.stdout) == (0, True)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("import nothing_of_the_kind\n", "1: ModuleNotFoundError: No module named 'nothing_of_the_kind'"),
        ("\ndef f(:\n", "SyntaxError: invalid syntax"),
        (
            "from fieldrig import program\nprogram('gone.st')\n",
            "2: fieldrig.errors.UsageError: there is no gone.st; expected",
        ),
    ],
)
def test_a_file_that_cannot_be_imported_is_a_mistake(tmp_path: Path, text: str, told: str) -> None:
    (tmp_path / "test_it.py").write_text(text)
    done = iec_test(tmp_path / "test_it.py")
    assert done.exit_code == Exit.WRONG
    assert told in done.stdout


def test_a_test_without_an_end_is_ended(tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text("def test_it():\n    while True:\n        pass\n")
    done = iec_test(tmp_path / "test_it.py", "--timeout", 0.1)
    assert done.exit_code == Exit.TESTS_FAILED
    assert "at most 0.1 s of a processor are allowed" in done.stdout


def test_warnings_may_be_errors_in_the_settings_of_pytest(tmp_path: Path) -> None:
    folder = folder_of(tmp_path)
    (folder / "pytest.ini").write_text("[pytest]\nfilterwarnings = error\nrequired_plugins = fieldrig\n")
    done = iec_test(f"{folder / 'test_twice.py'}::test_twice[1]", f"{folder / 'test_twice.py'}::test_twice[2]")
    assert (done.exit_code, "2 tests: 2 passed" in done.output) == (Exit.OK, True), done.output


@pytest.mark.parametrize("settings", ["addopts = --no-such-option", "required_plugins = no-such-plugin"])
def test_settings_that_pytest_refuses_are_an_error(tmp_path: Path, settings: str) -> None:
    folder = folder_of(tmp_path)
    (folder / "pytest.ini").write_text(f"[pytest]\n{settings}\n")
    done = iec_test(folder / "test_twice.py")
    assert done.exit_code != Exit.OK
    assert "pytest cannot begin; run it alone to see why" in done.output, done.output
