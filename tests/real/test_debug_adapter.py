"""`fieldrig debug-adapter` with a client that is not ours: the test support of Visual Studio Code."""

import json
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest
from patience import PATIENCE_S
from running_rig import RunningRig

from fieldrig.real.live_rig import FIELDRIG

pytestmark = pytest.mark.real

CLIENT = Path(__file__).parent / "node" / "debugger.js"
TRAVELLER = CLIENT.parent / "back.js"
STEPPER = CLIENT.parent / "steps.js"
CONFIGS = Path(__file__).parents[2] / "configs"
PAGE = Path(__file__).parents[2] / "docs/programs/editor.md"
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

    def __init__(self, time: str = "real") -> None:
        rig = (
            f"time: {time}\nbuses: {{}}\ndevices: {{controller: {{kind: max4, program: count.st, autostart: true}}}}\n"
        )
        super().__init__(rig, None)

    def up(self, *options: str) -> subprocess.Popen[bytes]:
        (self.folder / "count.st").write_text(COUNT)
        (self.folder / "adapter.sh").write_text(f"exec {shlex.join(FIELDRIG)} debug-adapter controller\n")
        return super().up(*options)


@pytest.fixture(scope="module")
def node() -> str:
    found = shutil.which("node")
    if found is None or not (CLIENT.parent / "node_modules/@vscode").is_dir():
        pytest.skip("the test support of Visual Studio Code is not installed: npm ci in tests/real/node")
    return found


def said(node: str, client: Path, rig: Controller, *options: str) -> str:
    """Return what a client says about its session with a rig."""
    done = subprocess.run(
        [node, client, rig.folder / "adapter.sh", rig.folder / "count.st", *options],
        env=rig.environment,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_visual_studio_codes_own_client_goes_back_in_time_as_recorded_in_the_docs(node: str) -> None:
    recorded = PAGE.read_text(encoding="utf-8").partition("```text\n-> initialize")[2].partition("```")[0]
    with Controller("virtual") as rig:
        rig.until_ready()
        assert said(node, TRAVELLER, rig) == f"-> initialize{recorded}"


# The sessions of the page by their first words: the rig, the device, its program, a value, and what is set before.
SHIPPED = {
    "setBreakpoints 334": ("pam-machine", "pam", "labeller.pam", "SBO_AliveBelt", ()),
    "setBreakpoints 67": ("arp-cell", "line", "line.I01", "V20", ("panel/6200:01=1",)),
}


@pytest.mark.parametrize(("first", "shipped"), SHIPPED.items(), ids=["PAM", "ARP"])
def test_programs_of_a_pam_and_of_a_card_are_stepped_both_ways_as_recorded_in_the_docs(
    node: str, first: str, shipped: tuple[str, str, str, str, tuple[str, ...]]
) -> None:
    name, device, program, expression, values = shipped
    recorded = PAGE.read_text(encoding="utf-8").partition(f"{first} -> ")[2].partition("```")[0].partition("\n\n")[0]
    with RunningRig(CONFIGS / f"{name}.yaml", None, "--set", "time=virtual") as rig:
        rig.until_ready()
        for value in values:
            assert rig.tool("set", value).returncode == 0
        adapter = rig.folder / "adapter.sh"
        adapter.write_text(f"exec {shlex.join(FIELDRIG)} debug-adapter {device}\n")
        line = first.rpartition(" ")[2]
        done = subprocess.run(
            [node, STEPPER, adapter, CONFIGS / "programs" / program, line, expression],
            env=rig.environment,
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=False,
        )
        assert done.returncode == 0, done.stderr
    assert done.stdout.rstrip() == f"{first} -> {recorded.rstrip()}"


def test_visual_studio_codes_own_client_debugs_a_program(node: str) -> None:
    with Controller() as rig:
        rig.until_ready()
        seen = json.loads(said(node, CLIENT, rig, str(INSIDE_CALL), str(CALL), "a > 20"))
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
