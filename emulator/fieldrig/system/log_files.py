"""The log of one process of a rig: standard output and error in a file of bounded size, and a few older ones.

`NAME.log` is the present one, `NAME.log.1` the one before.  The process itself begins the next file, before it writes
what would be too much, so nothing is lost or written twice.  Left out: text that a library writes without Python counts
only when Python writes next; what a full disk refuses (`steady_output`).  Windows cannot rename a file that is open, so
the log grows there.
"""

import io
import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import Final

from fieldrig.system.own_files import open_file, open_own
from fieldrig.system.steady_output import SteadyFile

LOG_BYTES: Final = 4 << 20
OLD_LOGS: Final = 3
LONGEST_TEXT: Final = LOG_BYTES // 4
"""Longest write, in characters; the rest of a longer one is dropped."""


def older(log: Path, number: int) -> Path:
    return log.with_name(f"{log.name}.{number}")


def rotate(log: Path) -> None:
    """Make room for a new file: the present one becomes number 1, and the oldest is dropped."""
    for number in range(OLD_LOGS, 0, -1):
        younger = older(log, number - 1) if number > 1 else log
        with suppress(OSError):
            younger.replace(older(log, number))


def begin_anew(log: Path) -> None:
    """Start an empty log, and delete the older ones."""
    for number in range(1, OLD_LOGS + 1):
        older(log, number).unlink(missing_ok=True)
    open_file(log, "wb").close()


def is_full(log: Path, more: int = 0) -> bool:
    """Return whether the log contains text and `more` bytes would exceed its limit."""
    try:
        size = log.stat().st_size
    except OSError:
        return False
    return size > 0 and size + more > LOG_BYTES


class LogText(io.TextIOWrapper):
    """The standard output or error of this process, written to its log file."""

    def __init__(self, fd: int, log: Path) -> None:
        super().__init__(io.BufferedWriter(SteadyFile(fd)), errors="backslashreplace", line_buffering=True)
        self._log_file = log

    def write(self, text: str) -> int:
        shown = text[:LONGEST_TEXT]
        if is_full(self._log_file, len(shown)):
            rotate(self._log_file)
            direct_output(self._log_file)
        super().write(shown)
        return len(text)


def direct_output(log: Path) -> None:
    """Direct both outputs of this process to the end of the file; they stay where they are if it cannot be opened."""
    try:
        fd = open_own(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    except OSError:
        return
    os.dup2(fd, 1)
    os.dup2(fd, 2)
    os.close(fd)


def take_over(log: Path) -> None:
    """Write all output of this process to its log from now on."""
    direct_output(log)
    sys.stdout, sys.stderr = LogText(1, log), LogText(2, log)
