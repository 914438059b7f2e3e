"""A command with everything that it starts, in a process group of its own."""

import os
import signal
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path


def run_group(
    command: Sequence[str], folder: Path, environment: Mapping[str, str], patience_s: float | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a command to its end, with its errors among its output.

    Whatever interrupts the wait kills the whole group.  TimeoutExpired, with the output, after `patience_s`.
    """
    with subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            output = process.communicate(timeout=patience_s)[0]
        except subprocess.TimeoutExpired as late:
            os.killpg(process.pid, signal.SIGKILL)
            late.output = process.communicate()[0]
            raise
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
    return subprocess.CompletedProcess(command, process.returncode, output)
