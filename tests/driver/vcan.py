"""Run a command on a vcan0 of its own: in a network namespace of this machine, or in user-mode Linux.

The namespace needs a kernel with vcan whose module is loaded, or root to load it.  In both cases the machine's own
network devices are out of reach.
"""

import os
import shlex
import subprocess
from collections.abc import Sequence
from pathlib import Path

from tests.driver import uml

# An ordinary user is root inside a user namespace.
NAMESPACE = ["unshare", "--net"] if os.geteuid() == 0 else ["unshare", "--map-root-user", "--net"]


def is_there() -> bool:
    """True if this machine's kernel provides vcan in a namespace of our own."""
    command = [*NAMESPACE, "ip", "link", "add", "dev", "vcan0", "type", "vcan"]
    try:
        return subprocess.run(command, capture_output=True, check=False).returncode == 0
    except OSError:
        return False


def command(wanted: Sequence[str], writable: Path, limit_s: float) -> list[str]:
    """The command that runs the one wanted on vcan0, where `writable` keeps what it writes."""
    if is_there():
        lines = f"ip link set lo up\n{uml.VCAN0_UP}exec {shlex.join(wanted)}"
        return [*NAMESPACE, "sh", "-ec", lines]
    return [*uml.PYTHON, "--seconds", f"{limit_s:g}", "--writable", str(writable), "--", *wanted]
