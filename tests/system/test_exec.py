"""`fieldrig exec` runs a program as a master in virtual time."""

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.system
EDS = Path(__file__).parents[2] / "configs" / "eds" / "io32.eds"
RIG = f"""\
time: real
buses:
  can0: {{kind: can.hub, bitrate: 1000000, socketcand: 127.0.0.1:29536}}
devices:
  io: {{kind: canopen.node, node_id: 5, eds: {EDS}, links: {{can: can0}}, objects: {{"1017:00": 1000}}}}
"""
MASTER = """\
import sys, time
import can

bus = can.Bus(interface="socketcand", channel="can0", host="127.0.0.1", port=29536)
bus.send(can.Message(arbitration_id=0, data=[1, 0], is_extended_id=False))
begin = time.monotonic()
time.sleep(3600)
slept = time.monotonic() - begin
beats = 0
while (message := bus.recv(0)) is not None:
    beats += message.arbitration_id == 0x705
print(beats, slept, sys.argv[1:])
bus.shutdown()
sys.exit(int(sys.argv[1]))
"""


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "fieldrig", "exec", "rig.yaml", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "rig.yaml").write_text(RIG)
    (tmp_path / "master.py").write_text(MASTER)
    return tmp_path


def test_a_program_of_an_hour_ends_at_once_with_its_exit_code(folder: Path) -> None:
    done = run(folder, "--", "master.py", "7")
    assert done.returncode == 7, done.stderr
    beats, seconds, arguments = done.stdout.split(maxsplit=2)
    assert (float(seconds), arguments.strip()) == (3600.0, "['7']")
    assert int(beats) > 1000
    assert "s of virtual time in" in done.stderr


def test_a_program_that_leaves_the_rig_is_told_so(folder: Path) -> None:
    (folder / "outside.py").write_text("import socket; socket.create_connection(('10.0.0.1', 502))")
    done = run(folder, "--", "outside.py")
    assert done.returncode != 0
    assert "error: 10.0.0.1:502 is outside of the rig" in done.stderr
    assert "socketcand at 127.0.0.1:29536" in done.stderr
    assert "outside.py:1" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_program_that_is_not_there_is_named(folder: Path) -> None:
    done = run(folder, "--", "mastr.py")
    assert "there is no program mastr.py" in done.stderr
    assert "did you mean master.py?" in done.stderr


def test_a_module_is_run(folder: Path) -> None:
    assert run(folder, "--", "-m", "calendar").returncode == 0


@pytest.mark.parametrize(
    ("text", "last", "is_traceback"),
    [("def wrong(:\n", "SyntaxError: invalid syntax", False), ("x = {}\nx['a']\n", "KeyError: 'a'", True)],
)
def test_an_error_of_the_program_is_shown_as_by_python(folder: Path, text: str, last: str, is_traceback: bool) -> None:
    """The frames of ours and those of runpy are left out."""
    (folder / "wrong.py").write_text(text)
    done = run(folder, "--", "wrong.py")
    assert done.returncode == 1
    assert last in done.stderr
    assert ('Traceback (most recent call last):\n  File "wrong.py", line 2' in done.stderr) is is_traceback
    assert "runpy" not in done.stderr
    assert "fieldrig/cli" not in done.stderr
