"""A command with everything that it starts, in a process group of its own."""

import contextlib
import os
import signal
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryFile
from typing import TextIO


def run_group(
    command: Sequence[str], folder: Path, environment: Mapping[str, str], patience_s: float | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a command to its end, with its errors among its output, and kill what it has left running in its group.

    Whatever interrupts the wait kills the whole group.  TimeoutExpired, with the output, after `patience_s`.
    """
    # A file and not a pipe: a script that fails leaves its rigs running, and they would keep a pipe open.
    with TemporaryFile("w+", encoding="utf-8", errors="replace") as output:
        process = subprocess.Popen(
            command,
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            process.wait(patience_s)
        except subprocess.TimeoutExpired as late:
            kill_group(process.pid)
            late.output = _text(output)
            raise
        finally:
            kill_group(process.pid)
            process.wait()
        return subprocess.CompletedProcess(command, process.returncode, _text(output))


def kill_group(number: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(number, signal.SIGKILL)


def _text(output: TextIO) -> str:
    output.seek(0)
    return output.read()
