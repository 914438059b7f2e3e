"""Folders and files of a rig that no other user may have prepared, opened without following links.

Another user who may write to a folder can put a link where a rig is about to write, and an archive that was unpacked
may bring one.  So a folder has to be this user's own and writable by no one else, and what is not a plain file of this
user is neither opened nor deleted.  Left out: Windows, which has neither owners nor links of this kind.
"""

import errno
import os
import stat
from pathlib import Path
from typing import IO, Any, Final

from fieldrig.errors import RigError

FOLDER_MODE: Final = 0o700
FILE_MODE: Final = 0o600
NO_LINK: Final = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0)
NO_WAIT: Final = getattr(os, "O_NONBLOCK", 0)
"""A named pipe would keep its opener waiting for another end; for a plain file the flag does nothing."""
OTHERS_MAY_WRITE: Final = stat.S_IWGRP | stat.S_IWOTH
HAS_OWNERS: Final = hasattr(os, "geteuid")

OUTSIDE_VARIABLE: Final = "FIELDRIG_OUTSIDE_PATHS"
"""Environment variable by which a user allows paths of a rig file outside the run folder."""


def own_folder(folder: Path) -> Path:
    """Make the folder if it is missing, and return it.

    RigError if it is another user's, if another user's link leads to it, or if others may write to it.  OSError if it
    cannot be made.
    """
    if hasattr(os, "geteuid") and folder.is_symlink() and (owner := folder.lstat().st_uid) not in (0, os.geteuid()):
        raise RigError(
            f"{folder} is a link of another user (id {owner})", "name a folder of your own: --set run=FOLDER"
        )
    folder.mkdir(parents=True, exist_ok=True, mode=FOLDER_MODE)
    about = folder.stat()
    if hasattr(os, "geteuid") and about.st_uid != os.geteuid():
        raise RigError(
            f"{folder} belongs to another user (id {about.st_uid})", "name a folder of your own: --set run=FOLDER"
        )
    if HAS_OWNERS and about.st_mode & OTHERS_MAY_WRITE:
        raise RigError(
            f"other users may write to {folder}", f"take the right from them: chmod go-w {folder}; or --set run=FOLDER"
        )
    return folder


def part_of(folder: Path, name: str) -> Path:
    """Return the path of a file in a folder, and make the folders between them.

    RigError if one of these is a link or another user's, or if the path leaves the folder and the user has not allowed
    that.  OSError if one cannot be made.
    """
    path = folder / name
    if leaves(folder, name):
        if not is_outside_allowed():
            raise RigError(f"{path} is outside the run folder {folder}", OUTSIDE_REMEDY)
        path.parent.mkdir(parents=True, exist_ok=True)
        return path
    between = path.parent.relative_to(folder)
    own_folder(folder)
    for place in [folder.joinpath(*between.parts[: count + 1]) for count in range(len(between.parts))]:
        if place.is_symlink():
            raise RigError(f"{place} is a link", "remove it, and start the rig again")
        own_folder(place)
    return path


def leaves(folder: Path, name: str) -> bool:
    """Return whether a path in a rig file leads out of the folder."""
    return ".." in Path(name).parts or not (folder / name).is_relative_to(folder)


OUTSIDE_REMEDY: Final = (
    f"expected a path in it; `fieldrig up --outside-paths`, or {OUTSIDE_VARIABLE}=1 in the environment, allows others"
)


def checked_path(path: str) -> str:
    """Return a path of a rig file.  ValueError if it leaves the run folder, and the user has not allowed that."""
    if not is_outside_allowed() and (Path(path).is_absolute() or ".." in Path(path).parts):
        raise ValueError(f"{path} is outside the run folder: {OUTSIDE_REMEDY}")
    return path


def is_outside_allowed() -> bool:
    return os.environ.get(OUTSIDE_VARIABLE, "") not in ("", "0")


def open_own(path: Path, flags: int) -> int:
    """Return a descriptor of a file of this user, made with `FILE_MODE` if `flags` have O_CREAT.

    OSError if that is not possible, also for a link; PermissionError for a file of another user, or one that is not a
    plain file.
    """
    try:
        fd = os.open(path, flags | NO_LINK | NO_WAIT, FILE_MODE)
    except OSError as cause:
        if cause.errno != errno.ENXIO:
            raise
        raise PermissionError(1, "not a plain file of this user", str(path)) from cause
    about = os.fstat(fd)
    is_ours = not hasattr(os, "geteuid") or about.st_uid == os.geteuid()
    if HAS_OWNERS and not (is_ours and stat.S_ISREG(about.st_mode) and about.st_nlink == 1):
        os.close(fd)
        raise PermissionError(1, "not a plain file of this user", str(path))
    if hasattr(os, "fchmod") and flags & (os.O_WRONLY | os.O_RDWR) and about.st_mode & 0o077:
        os.fchmod(fd, FILE_MODE)  # made by an earlier version, for all to read
    return fd


def refused(cause: OSError) -> RigError:
    """Return the error for a user in whose run folder a file or folder cannot be made or opened."""
    what = cause.filename if cause.filename is not None else "the run folder"
    if cause.errno == errno.ELOOP:
        return RigError(f"{what} is a link", "remove it, and start the rig again")
    if isinstance(cause, FileExistsError | NotADirectoryError):
        return RigError(f"{what} is no folder", "name another folder: --set run=FOLDER")
    return RigError(f"{what} cannot be made: {cause.strerror or cause}", "name another folder: --set run=FOLDER")


def open_file(path: Path, mode: str, encoding: str | None = None) -> IO[Any]:
    """Do as `Path.open` does, for a file of this user.  A text needs an encoding."""
    return open(path, mode, encoding=encoding, opener=lambda name, flags: open_own(Path(name), flags))


def remove_socket(path: Path) -> None:
    """Delete a socket that is left over.  FileExistsError if something else is there."""
    try:
        mode = path.lstat().st_mode
    except FileNotFoundError:
        return
    if not stat.S_ISSOCK(mode):
        raise FileExistsError(17, "not a socket", str(path))
    path.unlink(missing_ok=True)
