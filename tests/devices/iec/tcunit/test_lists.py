"""A suite that names a variable which a list of global variables does not have."""

from pathlib import Path

from typer.testing import CliRunner

from fieldrig_devices.iec.commands import app

LIST = """<?xml version="1.0"?>
<TcPlcObject><GVL Name="Limits"><Declaration><![CDATA[{attribute 'qualified_only'}
VAR_GLOBAL CONSTANT lowest : INT := 1; highest : INT := 9; END_VAR]]></Declaration></GVL></TcPlcObject>
"""
SUITE = """FUNCTION_BLOCK LimitTest EXTENDS TcUnit.FB_TestSuite
VAR n : INT := Limits.highst; END_VAR
TEST('limit');
TEST_FINISHED();
END_FUNCTION_BLOCK
"""


def said(folder: Path, suite: str) -> str:
    (folder / "Limits.TcGVL").write_text(LIST)
    (folder / "LimitTest.st").write_text(suite)
    return CliRunner().invoke(app, ["test", str(folder)]).output


def test_the_variable_that_a_list_lacks_is_named(tmp_path: Path) -> None:
    output = said(tmp_path, SUITE)
    assert "LimitTest.st:2: the list Limits has no variable highst" in output
    assert "did you mean highest?" in output


def test_a_list_that_is_not_there_is_not_declared(tmp_path: Path) -> None:
    assert "LimitTest.st:2: Bounds is not declared" in said(tmp_path, SUITE.replace("Limits.", "Bounds."))


def test_a_variable_that_a_list_has_is_taken(tmp_path: Path) -> None:
    assert "1 passed" in said(tmp_path, SUITE.replace("highst", "highest"))
