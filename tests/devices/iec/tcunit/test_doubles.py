"""Two suites with one name in a folder: the first one runs, and the second one is an error."""

from pathlib import Path

from typer.testing import CliRunner

from fieldrig_devices.iec.commands import app

SUITE = """FUNCTION_BLOCK {name} EXTENDS TcUnit.FB_TestSuite
TEST('{test}');
TEST_FINISHED();
END_FUNCTION_BLOCK
"""


def test_the_other_suites_of_a_folder_run(tmp_path: Path) -> None:
    for file, name, test in (("a", "Pump", "first"), ("b", "pump", "second"), ("c", "Valve", "third")):
        (tmp_path / f"{file}.st").write_text(SUITE.format(name=name, test=test))
    done = CliRunner().invoke(app, ["test", str(tmp_path)])
    assert done.exit_code == 2
    assert "ok      first" in done.output
    assert "ok      third" in done.output
    assert "second" not in done.output
    assert f"b.st:1: pump is declared in {tmp_path / 'a.st'}, line 1 already" in done.output
    assert "3 tests: 2 passed, 1 error" in done.output
