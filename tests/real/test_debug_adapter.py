"""`fieldrig debug-adapter` with a client that is not ours: the test support of Visual Studio Code."""

import json
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest
from running_rig import PATIENCE_S, RunningRig

from fieldrig.real.live_rig import FIELDRIG

pytestmark = pytest.mark.real

CLIENT = Path(__file__).parent / "node" / "debugger.js"
COUNT = """\
FUNCTION Twice : INT
VAR_INPUT x : INT; END_VAR
Twice := x * 2;
END_FUNCTION
PROGRAM PLC_PRG
VAR a : INT; b : INT; END_VAR
a := a + 1;
b := Twice(
  a);
END_PROGRAM
"""
CALL, INSIDE_CALL, IN_FUNCTION = 8, 9, 3


class Controller(RunningRig):
    """A controller that runs the counting program."""

    def __init__(self) -> None:
        rig = "time: real\nbuses: {}\ndevices: {controller: {kind: max4, program: count.st, autostart: true}}\n"
        super().__init__(rig, None)

    def up(self, *options: str) -> subprocess.Popen[bytes]:
        (self.folder / "count.st").write_text(COUNT)
        (self.folder / "adapter.sh").write_text(f"exec {shlex.join(FIELDRIG)} debug-adapter controller\n")
        return super().up(*options)


def test_visual_studio_codes_own_client_debugs_a_program() -> None:
    node = shutil.which("node")
    if node is None or not (CLIENT.parent / "node_modules/@vscode").is_dir():
        pytest.skip("the test support of Visual Studio Code is not installed: npm ci in tests/real/node")
    with Controller() as rig:
        rig.until_ready()
        done = subprocess.run(
            [node, CLIENT, rig.folder / "adapter.sh", rig.folder / "count.st", str(INSIDE_CALL), str(CALL), "a > 20"],
            env=rig.environment,
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        seen = json.loads(done.stdout)
        assert rig.ask("device/controller/debug", {"command": "state"})["state"] == "running"
    assert seen.pop("above") > 20
    assert seen == {
        "conditions": True,
        "verified": [True],
        "lines": [CALL],
        "thread": "PLC_PRG",
        "reason": "step",
        "stack": [["Twice", IN_FUNCTION], ["PLC_PRG", CALL]],
        "roots": ["PLC_PRG"],
    }
