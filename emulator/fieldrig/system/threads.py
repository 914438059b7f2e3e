"""The threads of this process."""

import threading
from pathlib import Path


def threads() -> set[int]:
    """Return the threads of this process, those without Python too; only those with Python outside Linux."""
    try:
        return {int(entry.name) for entry in Path("/proc/self/task").iterdir()}
    except OSError:
        return {thread.native_id or 0 for thread in threading.enumerate()}
