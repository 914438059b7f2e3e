"""A finding of a search is opened: its rig stands where the property does not hold, and goes back from there."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import forked_cli
import pytest
from running_rig import until
from st_tests import LAMP_RIG

from fieldrig.clock import MS
from fieldrig.control.messages import Client
from fieldrig.errors import ControlError
from fieldrig.testing import free_port, return_port

pytestmark = [pytest.mark.system, pytest.mark.timeout(600)]

PROGRAM = """\
VAR_GLOBAL presses : INT; END_VAR
PROGRAM PLC_PRG
VAR
  switch AT %IX0.0 : BOOL;
  lamp AT %QX0.0 : BOOL;
  edge : R_TRIG;
END_VAR
edge(CLK := switch);
IF edge.Q THEN presses := presses + 1; END_IF
lamp := switch;
IF presses >= 3 THEN lamp := TRUE; END_IF
END_PROGRAM
"""
FINDING = """\
# the lamp goes out
rig: rig.yaml
after: 500ms
steps:
  - {at: 100ms, press: {wires/switch.on: true}, hold: 30ms}
  - {at: 300ms, press: {wires/switch.on: true}, hold: 30ms}
  - {at: 500ms, press: {wires/switch.on: true}, hold: 30ms}
  - {at: 800ms, set: {wires/switch.on: true}}
properties:
  the lamp goes out: {never: wires/lamp.on and not wires/switch.on, longer: 50ms}
"""
SESSION = """\
print presses
last presses
back
back 3
print presses
break 9
reverse-continue
back 1.05s
print presses
"""
"""The third press is at 1 s of the rig, and the lamp should be out at 1.08 s."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "rig.yaml").write_text(LAMP_RIG)
    (tmp_path / "lamp.st").write_text(PROGRAM)
    (tmp_path / "finding-1.yaml").write_text(FINDING)
    return tmp_path


def fieldrig(*words: str) -> list[str]:
    return [sys.executable, "-m", "fieldrig", *words]


def debug(folder: Path, *words: str, script: str = SESSION) -> subprocess.CompletedProcess[str]:
    command = fieldrig("debug", *words)
    return subprocess.run(command, cwd=folder, input=script, capture_output=True, text=True, timeout=110, check=False)


def test_the_debugger_opens_a_finding_and_steps_back_from_it(folder: Path) -> None:
    done = debug(folder, "finding-1.yaml")
    assert done.returncode == 0, done.stderr
    said = done.stdout
    assert said.startswith("the lamp goes out: at 0.58 s: `wires/lamp.on and not wires/switch.on` was true for longer")
    assert "presses 2 -> 3 at 1" in said
    assert "by lamp.st:9" in said
    assert "(debug) back\nPLC_PRG paused at PLC_PRG, lamp.st:11: IF presses >= 3 THEN lamp := TRUE; END_IF" in said
    assert "(debug) reverse-continue\nPLC_PRG paused at PLC_PRG, lamp.st:9: " in said
    assert said.count("presses = 3") == 3


@pytest.mark.parametrize(
    ("text", "words", "message"),
    [
        (FINDING.replace("rig: rig.yaml", "rig: no.yaml"), (), "the scenario cannot be opened"),
        (FINDING, ("--device", "terminsl"), "did you mean terminal?"),
    ],
)
def test_the_debugger_says_why_it_cannot_open_a_file(
    folder: Path, text: str, words: tuple[str, ...], message: str
) -> None:
    (folder / "finding-1.yaml").write_text(text)
    done = debug(folder, "finding-1.yaml", *words)
    assert done.returncode != 0
    assert message in done.stderr


@pytest.fixture
def opened(folder: Path) -> Iterator[tuple[str, Client]]:
    """Yield the endpoint of the rig when it is at the violation."""
    port = free_port()
    endpoint = f"tcp/127.0.0.1:{port}"
    command = fieldrig("scenario", "open", "finding-1.yaml", "--control", endpoint, "--no-ui")
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL) as process:
        try:
            until(lambda: is_there(endpoint))
            with Client(endpoint) as client:
                yield endpoint, client
        finally:
            process.terminate()
            process.wait()
            return_port(port)


def is_there(endpoint: str) -> bool:
    try:
        with Client(endpoint) as client:
            return bool(client.ask("prelude/timeline")["is_there"])
    except ControlError:
        return False


def test_a_rig_is_kept_where_its_scenario_ends_with_its_time_line(opened: tuple[str, Client], folder: Path) -> None:
    endpoint, client = opened
    timeline: dict[str, Any] = client.ask("prelude/timeline")
    assert [(one["at_ns"] // MS, one["what"]) for one in timeline["acts"]][:2] == [
        (100, "wires/switch.on = true for 30 ms"),
        (130, "wires/switch.on = false"),
    ]
    assert [one["at_ns"] for one in timeline["violations"]] == [580 * MS]
    assert {one["place"] for one in timeline["signals"]} == {"wires/lamp.on", "wires/switch.on"}
    status = client.ask("rig/status")
    assert (status["state"], status["now_ns"]) == ("paused", 1080 * MS)
    for words, presses in ((("back", "--by", "90ms"), 2), (("step", "200ms"), 2)):
        assert forked_cli.run([*words, "--control", endpoint], folder, {}).returncode == 0
        assert client.ask("device/terminal/get", {"keys": ["presses"]}) == {"presses": presses}
