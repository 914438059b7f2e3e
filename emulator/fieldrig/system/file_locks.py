"""Locks on open files, which the system releases when their process ends, however it ends.

Left out: Windows, where every lock is given; there only ports and the control endpoint keep rigs apart.
"""

import sys
from typing import IO, Any

try:
    import fcntl
except ImportError:
    HAS_LOCKS = False
else:
    HAS_LOCKS = True


def lock(file: IO[Any] | int, *, is_shared: bool = False) -> bool:
    """Lock an open file, without waiting.  Return False if another process has it."""
    if sys.platform != "win32" and HAS_LOCKS:
        try:
            fcntl.flock(file, (fcntl.LOCK_SH if is_shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
    return True
