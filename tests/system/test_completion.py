"""Completion in the shell: what is offered for a word, by the protocol of bash and in a bash with a keyboard."""

import os
import shlex
import socket
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from running_rig import RunningRig, until
from terminal import Terminal

from fieldrig.config.kinds import BUSES, DEVICES, installed
from fieldrig.testing import free_port

pytestmark = pytest.mark.system

BIN = Path(sys.executable).parent
CONFIGS = Path(__file__).parents[2] / "configs"
RIG = f"""
time: real
buses:
  can0: {{kind: can.hub}}
  wires: {{kind: wires.hub, process: can0}}
devices:
  tank:
    kind: plant.tank
    process: can0
    links: {{wires: wires}}
    area_m2: 0.25
    height_m: 2.0
    outlet_area_m2: 0.0002
    pump_flow_m3_per_s: 0.001
  terrace_io:
    kind: canopen.node
    process: can0
    node_id: 5
    eds: {CONFIGS / "eds" / "io32.eds"}
    links: {{can: can0}}
"""
SCRIPT = """
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
_fieldrig_completion fieldrig
printf '%s\\n' "${COMPREPLY[@]}"
"""


@cache
def installed_function() -> str:
    """Return what `--install-completion` installs for bash."""
    environment = {**os.environ, "_FIELDRIG_COMPLETE": "source_bash"}
    return subprocess.run([BIN / "fieldrig"], env=environment, capture_output=True, text=True, check=True).stdout


def offered(folder: Path, environment: dict[str, str], *words: str) -> list[str]:
    """Return what bash offers for the last word."""
    command = ["bash", "--norc", "-c", installed_function() + SCRIPT, "bash", "fieldrig", *words]
    surroundings = {**os.environ, **environment, "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(command, cwd=folder, env=surroundings, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    return done.stdout.split()


@pytest.fixture(scope="module")
def rig() -> Iterator[RunningRig]:
    with RunningRig(RIG, None) as rig:
        yield rig.until_ready()


def at_once(rig: RunningRig, *words: str) -> list[str]:
    return offered(rig.folder, {"FIELDRIG_CONTROL": rig.endpoint}, *words)


def in_rig(rig: RunningRig, *words: str) -> list[str]:
    """Return the offer, and try again while a busy host does not answer within the time limit of completion."""
    found: list[str] = []

    def is_offered() -> bool:
        found[:] = at_once(rig, *words)
        return bool(found)

    until(is_offered)
    return found


def test_kinds(tmp_path: Path) -> None:
    assert offered(tmp_path, {}, "devices", "") == [*installed(BUSES), *installed(DEVICES)]
    assert offered(tmp_path, {}, "devices", "can.") == [
        "can.hub",
        "can.socketcan",
        "can.udp",
        "can.virtual",
        "can.bridge",
    ]


def test_examples_and_commands_that_packages_bring(tmp_path: Path) -> None:
    assert offered(tmp_path, {}, "new", "la") == ["lab"]
    assert offered(tmp_path, {}, "ne") == ["new"]
    assert offered(tmp_path, {}, "eds", "ch") == ["check"]


def test_rig_files(tmp_path: Path) -> None:
    for name in ("plant/a/line.yaml", "plant/a/cell.yml", "plant/a/notes.txt", "lab.yaml", ".hidden.yaml"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    for command in ("up", "check"):
        assert offered(tmp_path, {}, command, "") == ["lab.yaml", "plant/"]
        assert offered(tmp_path, {}, command, "pl") == ["plant/a/cell.yml", "plant/a/line.yaml"]
        assert offered(tmp_path, {}, command, f"{tmp_path}/la") == [f"{tmp_path}/lab.yaml"]
        assert offered(tmp_path, {}, command, "nowhere/") == []


def test_devices_then_the_keys_of_one(rig: RunningRig) -> None:
    assert in_rig(rig, "get", "") == ["tank", "terrace_io"]
    assert in_rig(rig, "get", "ta")[:2] == ["tank", "tank/level"]
    assert in_rig(rig, "get", "tank/lev") == ["tank/level"]
    assert in_rig(rig, "get", "tank/level", "te")[0] == "terrace_io"
    assert at_once(rig, "get", "door/") == []


def test_signals_of_devices_and_of_buses_that_have_some(rig: RunningRig) -> None:
    assert in_rig(rig, "record", "") == ["wires", "tank", "terrace_io"]
    assert in_rig(rig, "record", "wires/tank.l") == ["wires/tank.level", "wires/tank.low"]
    assert in_rig(rig, "record", "wires/tank.level", "tank/lev") == ["tank/level"]
    assert "wires/tank.level" in in_rig(rig, "record", "wires")
    assert in_rig(rig, "record", "tank/level", "--ch") == ["--changes"]
    assert at_once(rig, "record", "can0/") == []


def test_keys_that_can_be_written(rig: RunningRig) -> None:
    assert in_rig(rig, "set", "t") == ["tank/", "terrace_io/"]
    assert in_rig(rig, "set", "tank/") == ["tank/level="]


@pytest.mark.parametrize(
    "words",
    [("tank/level", "="), ("tank/level", "=", "1"), ("tank/level=1",)],
    ids=["bash: no digit", "bash: a digit", "other shells"],
)
def test_a_value_is_left_to_the_user(rig: RunningRig, words: tuple[str, ...]) -> None:
    assert at_once(rig, "set", *words) == []


def test_the_next_setting_after_a_value(rig: RunningRig) -> None:
    assert in_rig(rig, "set", "terrace_io/6200", ":", "01", "=", "1", "tank/l") == ["tank/level="]


def test_keys_with_a_colon_where_bash_cuts_them(rig: RunningRig) -> None:
    assert in_rig(rig, "get", "terrace_io/6200", ":", "0") == ["00", "01", "02", "03", "04"]
    assert in_rig(rig, "get", "terrace_io/6200:0")[1] == "terrace_io/6200:01"
    assert "01=" in in_rig(rig, "set", "terrace_io/6200", ":", "0")


def test_faults_and_their_keys(rig: RunningRig) -> None:
    assert in_rig(rig, "fault", "") == ["can0", "wires", "tank", "terrace_io"]
    assert in_rig(rig, "fault", "tank", "p") == ["power_off"]
    assert in_rig(rig, "fault", "tank", "l") == ["leak"]
    assert in_rig(rig, "fault", "can0", "dr") == ["drop"]
    assert in_rig(rig, "fault", "can0", "drop", "prob") == ["probability="]
    assert at_once(rig, "fault", "can0", "drop", "probability", "=", "0.1", "prob") == []
    assert at_once(rig, "fault", "can0", "drop", "probability", "=", "0") == []


def test_buses_and_processes(rig: RunningRig) -> None:
    assert in_rig(rig, "watch", "") == ["can0", "wires", "tank", "terrace_io"]
    assert in_rig(rig, "trace", "record", "x.jsonl", "w") == ["wires"]
    assert in_rig(rig, "restart", "") == ["can0", "wires", "tank", "terrace_io"]
    assert in_rig(rig, "status", "--ready", "a") == ["all"]


def test_the_endpoint_may_be_on_the_line(rig: RunningRig) -> None:
    assert offered(rig.folder, {}, "get", "--control", rig.endpoint, "tank/lev") == ["tank/level"]


@pytest.mark.parametrize("words", [("get", ""), ("set", "tank/"), ("fault", ""), ("fault", "can0", ""), ("watch", "")])
def test_without_a_rig_nothing_is_offered_and_nothing_is_said(tmp_path: Path, words: tuple[str, ...]) -> None:
    assert offered(tmp_path, {"FIELDRIG_CONTROL": f"tcp/127.0.0.1:{free_port()}"}, *words) == []


def test_another_program_at_the_endpoint_is_no_rig(tmp_path: Path) -> None:
    """The program accepts connections, but never answers."""
    with socket.create_server(("127.0.0.1", 0)) as mute:
        endpoint = f"tcp/127.0.0.1:{mute.getsockname()[1]}"
        assert offered(tmp_path, {"FIELDRIG_CONTROL": endpoint}, "get", "") == []


def test_tab_in_a_bash(rig: RunningRig) -> None:
    (rig.folder / "rc").write_text("source <(_FIELDRIG_COMPLETE=source_bash fieldrig); PS1='ready> '\n")
    path = shlex.quote(f"{BIN}{os.pathsep}{os.environ['PATH']}")
    bash = f"PATH={path} FIELDRIG_CONTROL={rig.endpoint} exec bash --rcfile rc -i"
    with Terminal(bash, rig.folder) as terminal:
        terminal.until_shown("ready> ")
        terminal.type("fieldrig get terrace_io/6200:04\tX")
        terminal.until_shown("terrace_io/6200:04 X")
        terminal.type("\x15fieldrig get tank/lev\t\n")
        terminal.until_shown("tank/level = 0 m")
