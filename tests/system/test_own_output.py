"""The output of fieldrig itself: on a full disk, closed, without free descriptors, and what it says of full stores."""

import os
import resource
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from lamp_rig import KINDS, lamp_rig
from running_rig import RunningRig, until
from storing_devices import TABLE

from fieldrig.real.live_rig import FIELDRIG
from fieldrig.testing import free_port

pytestmark = [pytest.mark.system, pytest.mark.skipif(sys.platform != "linux", reason="needs /dev/full")]

NO_SPACE = "No space left on device"
STORING = """
time: real
buses: {{mb: {{kind: modbus.tcp, listen: "127.0.0.1:{port}"}}}}
devices: {{drive: {{kind: modbus.device, table: {folder}/table.yaml, links: {{modbus: mb}}}}}}
"""


class ShellRig(RunningRig):
    """A rig whose outputs are directed by a shell."""

    def __init__(self, redirections: str, *options: str) -> None:
        self._redirections = redirections
        super().__init__(lamp_rig(), KINDS, *options)

    def start_up(self, file: Path, *options: str, folder: Path | None = None) -> "subprocess.Popen[bytes]":
        line = f'exec "$@" {self._redirections}'
        return subprocess.Popen(
            ["sh", "-c", line, "sh", *FIELDRIG, "up", str(file), *options],
            cwd=folder,
            env=self.environment,
            stdin=subprocess.DEVNULL,
        )

    def said(self) -> str:
        return (self.folder / "said").read_text()


@pytest.mark.parametrize(
    ("redirections", "options", "said"),
    [
        (">/dev/full 2>said", (), f"standard output cannot be written: {NO_SPACE}; the rig goes on\n"),
        (">/dev/full 2>said", ("--quiet",), "lamp died"),
        (">said 2>/dev/full", (), "lamp died"),
        (">/dev/full 2>&1", (), None),
        (">/dev/full 2>&1", ("--quiet",), None),
        (">&- 2>said", ("--quiet",), "lamp died"),
        (">&- 2>&-", (), None),
        ("0<&- >&- 2>&-", ("--quiet",), None),
    ],
)
def test_a_rig_goes_on_wherever_its_output_leads(redirections: str, options: tuple[str, ...], said: str | None) -> None:
    with ShellRig(redirections, *options) as rig:
        rig.until_ready()
        os.kill(rig.pid("lamp"), signal.SIGKILL)
        rig.until_back("lamp")
        assert rig.end() == 0
        if said is not None:
            assert said in rig.said()
            assert "Traceback" not in rig.said()


@pytest.mark.parametrize(
    "command",
    [("--help",), ("devices",), ("devices", "mc4"), ("schema",), ("check", "lab.yaml"), ("status",), ("get", "lamp")],
)
def test_a_command_whose_output_is_lost_says_so_and_fails(command: tuple[str, ...]) -> None:
    with RunningRig(lamp_rig(), KINDS) as rig, Path("/dev/full").open("w", encoding="utf-8") as full:
        rig.until_ready()
        done = subprocess.run(
            [*FIELDRIG, *command],
            cwd=rig.folder,
            env=rig.environment,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
        assert (done.returncode, done.stderr) == (2, f"error: the output cannot be written: {NO_SPACE}\n")


@pytest.mark.parametrize("redirection", ["2>/dev/full", "2>&-", ">/dev/full 2>&1", "0<&- >&- 2>&-"])
@pytest.mark.parametrize(("command", "code"), [("nonsense", 2), ("check none.yaml", 2), ("status", 4)])
def test_a_message_that_can_be_read_nowhere_leaves_the_exit_code_as_it_is(
    tmp_path: Path, command: str, redirection: str, code: int
) -> None:
    line = f'exec "$@" {command} {redirection}'
    done = subprocess.run(
        ["sh", "-c", line, "sh", *FIELDRIG],
        cwd=tmp_path,
        env={**os.environ, "FIELDRIG_CONTROL": f"tcp/127.0.0.1:{free_port()}"},
        check=False,
    )
    assert done.returncode == code


def test_a_supervisor_without_free_descriptors_starts_a_process_again_when_it_has_some() -> None:
    with RunningRig(lamp_rig(), KINDS, "--quiet") as rig:
        lamp = rig.until_ready().pid("lamp")
        limits = resource.prlimit(rig.process.pid, resource.RLIMIT_NOFILE)
        resource.prlimit(rig.process.pid, resource.RLIMIT_NOFILE, (3, limits[1]))
        os.kill(lamp, signal.SIGKILL)
        until(lambda: "lamp late: it cannot be started: Too many open files; trying again" in rig.output())
        assert rig.process.poll() is None
        resource.prlimit(rig.process.pid, resource.RLIMIT_NOFILE, limits)
        rig.until_back("lamp")
        assert rig.output().count("cannot be started") == 1
        assert rig.end() == 0


@pytest.mark.parametrize("limit", [8, 16, 24, 32, 48])
def test_a_rig_for_which_there_are_too_few_descriptors_is_refused(tmp_path: Path, limit: int) -> None:
    (tmp_path / "lab.yaml").write_text(lamp_rig())
    (tmp_path / KINDS.name).symlink_to(KINDS)
    line = f'ulimit -n {limit}; exec "$@" up lab.yaml --control tcp/127.0.0.1:{free_port()}'
    done = subprocess.run(
        ["sh", "-c", line, "sh", *FIELDRIG], cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stderr.splitlines()[:1]) == (
        3,
        [f"error: this rig needs 73 file descriptors for its 3 processes, and may have {limit}"],
    )


def test_a_quiet_rig_says_when_a_store_is_full_and_when_it_is_not(tmp_path: Path) -> None:
    (tmp_path / "table.yaml").write_text(TABLE)
    with RunningRig(STORING.format(port=(port := free_port()), folder=tmp_path), None, "--quiet") as rig:
        state = rig.until_ready().run / "state"
        state.rmdir()  # nothing is stored yet
        state.write_text("no folder")
        _write(port)
        until(lambda: "drive cannot store anything: File exists" in rig.output())
        assert rig.json("status")["state"] == "degraded"
        state.unlink()
        _write(port)
        until(lambda: "drive can store again" in rig.output())


def _write(port: int) -> None:
    """Write a register that is stored; the answer may be the device's error."""
    with socket.create_connection(("127.0.0.1", port)) as end:
        end.sendall(bytes.fromhex("0001 0000 0006 01 06 0000 0001"))
        assert end.recv(256)


@pytest.mark.parametrize("words", ["schema", "devices hmiscu", "new"])
def test_a_reader_that_has_gone_ends_a_command_in_silence(words: str) -> None:
    """The exit code is that of `cat` in `cat FILE | head -1`, which SIGPIPE ends."""
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run([*FIELDRIG, *words.split()], stdout=writer, stderr=subprocess.PIPE, timeout=60, check=False)
    os.close(writer)
    assert (done.returncode, done.stderr) == (141, b"")
