"""The runner of user-mode Linux, and the guest it boots (3 s each)."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from tests.driver import uml

needs_uml = pytest.mark.skipif(not uml.is_there(), reason=f"{uml.KERNEL} is not installed")


def run_inside(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "tests.driver.uml", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


def test_command_script_quotes_what_a_shell_would_read(tmp_path: Path) -> None:
    environment = {"PLAIN": "1", "HARD": "it's $HOME", "BASH_FUNC_x%%": "() { :; }"}
    script = uml.command_script(["sh", "-c", 'echo $PLAIN; printf %s "$HARD"; pwd; exit 7'], environment, tmp_path)
    done = subprocess.run(["sh", "-c", script], capture_output=True, text=True, check=False)
    assert done.stdout == f"1\nit's $HOME{tmp_path}\n"
    assert done.returncode == 7


@needs_uml
@pytest.mark.system
def test_guest_has_vcan_streams_output_and_keeps_only_the_writable_folder(tmp_path: Path) -> None:
    kept, lost = tmp_path / "kept", tmp_path / "lost"
    lost.mkdir()
    command = f"cat /sys/class/net/vcan0/type; echo 1 > {kept}/file; echo 1 > {lost}/file; cat {lost}/file; exit 7"
    done = run_inside("--writable", str(kept), "--", "sh", "-c", command)
    assert done.stdout == "280\n1\n"  # ARPHRD_CAN
    assert done.returncode == 7
    assert (kept / "file").exists()
    assert not (lost / "file").exists()


@needs_uml
@pytest.mark.system
def test_guest_that_takes_too_long_is_ended() -> None:
    done = run_inside("--seconds", "5", "--", "sleep", "100")
    assert done.returncode == uml.TIMED_OUT
    assert "stopped after 5 s" in done.stderr


@needs_uml
@pytest.mark.system
def test_guest_that_fails_shows_its_kernel_log() -> None:
    done = run_inside("--setup", "false", "--", "true")
    assert done.returncode == uml.GUEST_FAILED
    assert "guest: the setup failed" in done.stderr


@needs_uml
@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
@pytest.mark.system
def test_guest_runs_with_the_library_for_wide_registers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uml, "has_wide_registers", lambda: True)
    arithmetic = "import sys; sys.exit(round(2.5 * 2.8))"  # the state that the library handles is that of such numbers
    assert uml.run([sys.executable, "-c", arithmetic], uml.Guest()) == 7
