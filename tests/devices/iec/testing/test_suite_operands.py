"""The variables of the condition of an AssertTrue that has failed, beside the texts of TcUnit."""

import json
from pathlib import Path

from typer.testing import CliRunner

from fieldrig_devices.iec.commands import app

SUITE = """
FUNCTION_BLOCK Pump
VAR_INPUT on : BOOL; END_VAR
VAR_OUTPUT speed : INT; END_VAR
METHOD Twice : INT
Twice := 2 * speed;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK PumpTest EXTENDS TcUnit.FB_TestSuite
VAR pump : Pump; list : ARRAY[1..3] OF INT; place : INT := 2; END_VAR
METHOD Run
VAR local : INT := 4; END_VAR
VAR_INST kept : INT := 6; END_VAR
TEST('method');
AssertTrue(local > 5 OR pump.on, 'm');
AssertTrue(kept = local, 'instance');
TEST_FINISHED();
END_METHOD
METHOD Check
VAR_INPUT given : INT; holds : BOOL; END_VAR
AssertTrue(holds AND given > 9, 'helper');
END_METHOD
Run();
TEST('body');
AssertTrue(Condition := pump.speed > 10 AND NOT pump.on,
    Message := 'two lines');
AssertFalse(THIS^.pump.speed = 0, 'this');
AssertTrue(pump.Twice() = pump.speed + 1, 'call');
AssertTrue(list[2] = 6, 'element');
AssertTrue(list[place] = 6 AND place > 1, 'index');
AssertTrue(FALSE, 'constant');
AssertTrue(pump.speed = 0, 'holds');
Check(given := place + 1, holds := place > 7);
TEST_FINISHED();
END_FUNCTION_BLOCK
"""
SHOWN = {
    "m": "FALSE, where local = 4 and pump.on = FALSE",
    "instance": "FALSE, where kept = 6 and local = 4",
    "two lines": "FALSE, where pump.speed = 0 and pump.on = FALSE",
    "this": "TRUE, where pump.speed = 0",
    "call": "FALSE, where pump.speed = 0",
    "element": "FALSE, where list[2] = 0",
    "index": "FALSE, where place = 2",
    "constant": "FALSE",
    "helper": "FALSE, where holds = FALSE and given = 3",
}


def test_the_variables_of_a_condition_are_shown_where_it_fails(tmp_path: Path) -> None:
    (tmp_path / "pump.st").write_text(SUITE)
    done = CliRunner().invoke(app, ["test", str(tmp_path / "pump.st"), "--json"])
    found = {one["message"]: one["actual"] for test in json.loads(done.stdout) for one in test["failures"]}
    assert found == SHOWN
