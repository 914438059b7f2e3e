"""A rig's run folder: sockets, pty links, logs and memories, and the locks that say whose it is.

`rig.lock` is held by the rig, `processes.lock` by each of its processes, so a new rig neither shares the folder with a
living one nor meets the last processes of a killed one.  The system lets go of the locks of a killed process.  Left
out: Windows, which has neither these locks nor Unix sockets; there only the control endpoint keeps rigs apart.
"""

import os
import stat
import time
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

from fieldrig.errors import RigError

try:
    import fcntl
except ImportError:
    HAS_LOCKS = False
else:
    HAS_LOCKS = True

RIG_LOCK = "rig.lock"
PROCESSES_LOCK = "processes.lock"
LONGEST_PATH = 100
"""Bytes of a Unix socket's path; the system's limit is 104 to 108."""
LINGER_S = 5.0
"""How long the processes of a killed rig may take to notice."""


class RunFolder:
    """The rig's own hold of it; `release` leaves no socket and no pty link behind."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.absolute()
        self._lock: IO[str] | None = None

    def claim(self, sockets: list[str]) -> None:
        """RigError if it is a living rig's, or too deep for the `sockets` that will lie in it."""
        for name in sockets:
            if len(os.fsencode(self.folder / name)) > LONGEST_PATH:
                raise RigError(
                    f"the run folder {self.folder} lies too deep for Unix sockets",
                    "give the rig a shorter one: --set run=/tmp/lab",
                )
        try:
            (self.folder / "log").mkdir(parents=True, exist_ok=True)
            lock = (self.folder / RIG_LOCK).open("a+")
        except OSError as cause:
            raise RigError(f"the run folder can't be made: {cause}", "name another: --set run=FOLDER") from cause
        if not _locked(lock, wait_s=0):
            lock.seek(0)
            owner = lock.read().strip() or "unknown"
            lock.close()
            raise RigError(
                f"another rig runs in {self.folder} (process {owner})",
                f"stop it: `fieldrig stop`, Ctrl-C where it runs, or kill {owner};"
                " or give this one its own folder: --set run=FOLDER",
            )
        self._lock = lock
        with suppress(OSError):  # on a full disk nobody can read who holds it
            lock.truncate(0)
            os.write(lock.fileno(), f"{os.getpid()}\n".encode())

    def wait_for_the_last(self) -> None:
        """RigError if processes of a rig that was killed are still there after a while."""
        try:
            lock = (self.folder / PROCESSES_LOCK).open("a")
        except OSError as cause:
            raise RigError(
                f"{self.folder} can't be written: {cause.strerror}", "make room, or --set run=FOLDER"
            ) from cause
        with lock:
            if not _locked(lock, wait_s=LINGER_S):
                raise RigError(
                    f"processes of an earlier rig still run in {self.folder}",
                    "find them by `ps -e | grep rig:`, and end them",
                )
        self.sweep()

    def sweep(self) -> None:
        """Take away the sockets and pty links of processes that are gone."""
        for path in self.folder.rglob("*"):
            if stat.S_ISSOCK(path.lstat().st_mode) or _is_pty_link(path):
                path.unlink(missing_ok=True)

    def release(self) -> None:
        if self._lock is not None:
            self.sweep()
            self._lock.close()
            self._lock = None


def join_run(folder: Path) -> IO[Any]:
    """The hold of a process of the rig; keep it open."""
    folder.mkdir(parents=True, exist_ok=True)
    lock = (folder / PROCESSES_LOCK).open("a")
    if HAS_LOCKS:
        fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
    return lock


def _locked(file: IO[str], wait_s: float) -> bool:
    """Whether the lock could be had."""
    give_up_s = time.monotonic() + wait_s
    while HAS_LOCKS:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() >= give_up_s:
                return False
            time.sleep(0.02)
        else:
            return True
    return True


def _is_pty_link(path: Path) -> bool:
    return path.is_symlink() and str(path.readlink()).startswith("/dev/")
