"""A rig whose processes are started from outside, such as containers: `--control-only` and `--only`."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from lamp_rig import KINDS, lamp_rig
from running_rig import RunningRig, until

from fieldrig.testing import free_port

pytestmark = pytest.mark.system

LAMP = lamp_rig("after: lamp, ")


@pytest.fixture(autouse=True)
def token(monkeypatch: pytest.MonkeyPatch) -> None:
    """Set the token for this process and everything that a test starts."""
    monkeypatch.setenv("FIELDRIG_TOKEN", "for this test")


@contextmanager
def part(rig: RunningRig, name: str) -> Iterator[subprocess.Popen[bytes]]:
    process = rig.up("--only", name)
    try:
        yield process
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(30)


def fresh_files(rig: RunningRig) -> set[str]:
    """Return the names of the files for health checks."""
    return {file.name for file in (rig.run / "ready").glob("*")}


def test_parts_find_each_other_in_any_order_and_the_control_service_may_be_restarted() -> None:
    with RunningRig(LAMP, KINDS, "--control-only") as rig, ExitStack() as parts:
        rig.until_there()
        switch = parts.enter_context(part(rig, "switch"))
        lamp = parts.enter_context(part(rig, "lamp"))
        assert rig.tool("status", "--ready", "lamp").returncode == 7
        parts.enter_context(part(rig, "wires"))
        rig.until_ready()
        assert rig.tool("set", "switch/on=true").returncode == 0
        until(lambda: rig.value("lamp/on") is True)
        until(lambda: fresh_files(rig) == {"all", "lamp", "switch", "wires"})

        lamp.send_signal(signal.SIGKILL)
        until(lambda: rig.status()["processes"]["lamp"]["state"] == "dead")
        until(lambda: fresh_files(rig) == {"lamp", "switch", "wires"})  # what it has left gets old
        parts.enter_context(part(rig, "lamp"))
        rig.until_ready()

        rig.end(signal.SIGKILL)
        rig.process = rig.up("--control-only")
        rig.until_ready()
        assert switch.poll() is None
        assert rig.tool("get", "lamp").returncode == 0


def test_without_the_token_no_process_joins() -> None:
    with RunningRig(LAMP, KINDS, "--control-only") as rig:
        rig.until_there()
        rig.environment.pop("FIELDRIG_TOKEN")
        refused = rig.tool("status")
        assert refused.returncode == 4
        assert "FIELDRIG_TOKEN" in refused.stderr


def test_a_part_without_its_control_service_gives_up() -> None:
    with RunningRig(LAMP + "start_timeout_s: 0.3\n", KINDS, "--only", "lamp") as rig:
        assert rig.ended() == 3
        assert "no rig answers" in rig.output()


@pytest.mark.parametrize("blank", ["", "  "])
@pytest.mark.parametrize("command", [["up", "--control-only"], ["up"], ["status"]])
def test_a_blank_token_is_wrong_configuration(tmp_path: Path, command: list[str], blank: str) -> None:
    (tmp_path / "rig.yaml").write_text(LAMP)
    arguments = [*command, "rig.yaml"] if command[0] == "up" else command
    beyond = {"FIELDRIG_CONTROL": f"tcp/0.0.0.0:{free_port()}", "PYTHONPATH": str(KINDS.parent)}
    ended = subprocess.run(
        [sys.executable, "-m", "fieldrig", *arguments],
        cwd=tmp_path,
        env={**os.environ, **beyond, "FIELDRIG_TOKEN": blank},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert ended.returncode == 2, ended.stderr
    assert "FIELDRIG_TOKEN: the token is empty" in ended.stderr


def test_parts_share_the_token_that_the_rig_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("FIELDRIG_TOKEN")
    monkeypatch.setenv("FIELDRIG_TOKEN_FILE", str(tmp_path / "token"))
    with RunningRig(LAMP, KINDS, "--control-only") as rig, ExitStack() as parts:
        rig.until_there()
        for name in ("wires", "lamp", "switch"):
            parts.enter_context(part(rig, name))
        rig.until_ready()
        rig.environment["FIELDRIG_TOKEN_FILE"] = str(tmp_path / "another")
        assert rig.tool("status").returncode == 4


def test_a_process_with_too_long_a_run_folder_says_so(tmp_path: Path) -> None:
    folder = tmp_path / ("x" * 100)
    folder.mkdir()
    with RunningRig(LAMP, KINDS, "--only", "lamp", f"--set=run={folder}") as rig:
        assert rig.ended() == 3
        assert "has too long a path for Unix sockets" in rig.output()
        assert "--set run=" in rig.output()
