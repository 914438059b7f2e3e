"""A rig's run folder: sockets, pty links, logs and memories, and the locks that protect them.

The rig holds `rig.lock`, and each of its processes holds `processes.lock`.  So a new rig neither shares the folder with
a running one, nor meets the last processes of one that was killed.  The system releases the locks of a killed process.
Left out: Windows, which has neither these locks nor Unix sockets; there only the control endpoint keeps rigs apart.
"""

import os
import stat
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

from fieldrig.errors import RigError
from fieldrig.system.file_locks import lock as lock_file
from fieldrig.system.own_files import FOLDER_MODE, open_file, own_folder, part_of, refused

RIG_LOCK = "rig.lock"
PROCESSES_LOCK = "processes.lock"
OURS = frozenset({RIG_LOCK, PROCESSES_LOCK, "log", "state"})
"""The files and folders of a run folder.  The folders have common names, so they alone don't tell one."""
LONGEST_PATH = 100
"""Longest path of a Unix socket, in bytes; the system's limit is 104 to 108."""
LINGER_S = 5.0
"""Time that the processes of a killed rig have to end."""


def check_length(folder: Path, sockets: Iterable[str]) -> None:
    """RigError if the path of a run folder is too long for Unix sockets of these names."""
    for name in sockets:
        if len(os.fsencode(folder.absolute() / name)) > LONGEST_PATH:
            raise RigError(
                f"the run folder {folder} has too long a path for Unix sockets",
                "give the rig a shorter one: --set run=/tmp/lab",
            )


class RunFolder:
    """The rig's own lock on the folder; `release` leaves no socket and no pty link behind."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.absolute()
        self._lock: IO[str] | None = None

    def claim(self, sockets: Iterable[str]) -> None:
        """Take the lock.  RigError if a running rig has it, or if the path is too long for `sockets`."""
        check_length(self.folder, sockets)
        try:
            self._check_whose()
            for part in ("log", "state"):
                part_of(self.folder, f"{part}/any")
                (self.folder / part).chmod(FOLDER_MODE)  # earlier versions made them for all to read
            lock = open_file(self.folder / RIG_LOCK, "a+", encoding="ascii")
        except OSError as cause:
            raise refused(cause) from cause
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
        with suppress(OSError):  # a full disk only loses the holder's name
            lock.truncate(0)
            os.write(lock.fileno(), f"{os.getpid()}\n".encode())

    def _check_whose(self) -> None:
        """RigError for a folder that is not ours, or that has other things in it than a rig."""
        own_folder(self.folder)
        names = {path.name for path in self.folder.iterdir()}
        if not names <= OURS and not names & {RIG_LOCK, PROCESSES_LOCK}:
            raise RigError(
                f"{self.folder} is no run folder: it has other files, such as {min(names - OURS)}",
                "name an empty folder, or one that does not exist yet: --set run=FOLDER",
            )

    def wait_for_the_last(self) -> None:
        """Wait for the processes of a killed rig.  RigError if they are still there after `LINGER_S`."""
        try:
            lock = open_file(self.folder / PROCESSES_LOCK, "ab")
        except OSError as cause:
            raise refused(cause) from cause
        with lock:
            if not _locked(lock, wait_s=LINGER_S):
                raise RigError(
                    f"processes of an earlier rig still run in {self.folder}",
                    "find them by `ps -e | grep rig:`, and end them",
                )
        self.sweep()

    def sweep(self) -> None:
        """Remove the sockets and pty links of processes that have ended."""
        for path in self.folder.rglob("*"):
            if stat.S_ISSOCK(path.lstat().st_mode) or _is_pty_link(path):
                path.unlink(missing_ok=True)

    def release(self) -> None:
        if self._lock is not None:
            self.sweep()
            self._lock.close()
            self._lock = None


def join_run(folder: Path) -> IO[Any]:
    """Return the lock of a process of the rig; keep it open.  RigError if the folder is not ours."""
    try:
        own_folder(folder)
        lock = open_file(folder / PROCESSES_LOCK, "ab")
    except OSError as cause:
        raise refused(cause) from cause
    lock_file(lock, is_shared=True)
    return lock


def _locked(file: IO[Any], wait_s: float) -> bool:
    """Return whether the lock was free."""
    give_up_s = time.monotonic() + wait_s
    while not lock_file(file):
        if time.monotonic() >= give_up_s:
            return False
        time.sleep(0.02)
    return True


def _is_pty_link(path: Path) -> bool:
    return path.is_symlink() and str(path.readlink()).startswith(("/dev/pts/", "/dev/tty"))
