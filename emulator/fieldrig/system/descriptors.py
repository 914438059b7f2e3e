"""The file descriptors that a rig's supervisor needs, and the system's limit on them."""

import sys
from typing import Final

from fieldrig.errors import RigError

try:
    import resource
except ImportError:
    HAS_LIMITS = False  # Windows
else:
    HAS_LIMITS = True

OWN: Final = 64
"""Descriptors of a supervisor without processes: its loop, its Zenoh session, its locks, and some to spare.  A session
that gets none does not raise, but aborts the process (measured: below 34)."""
FOR_EACH: Final = 3
"""Descriptors for each process: the pipe of its steps, the wait for its end, its control connection."""


def ensure_for(processes: int) -> None:
    """Raise the soft limit to what this number of processes needs.  RigError if the hard limit forbids it."""
    if sys.platform != "win32" and HAS_LIMITS:
        needed = OWN + FOR_EACH * processes
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        if soft == resource.RLIM_INFINITY or soft >= needed:
            return
        if hard != resource.RLIM_INFINITY and hard < needed:
            raise RigError(
                f"this rig needs {needed} file descriptors for its {processes} processes, and may have {hard}",
                f"raise the limit (`ulimit -n {needed}`, as root), or let devices share a process",
            )
        resource.setrlimit(resource.RLIMIT_NOFILE, (needed, hard))
