"""A file that is written as a whole or not at all."""

import logging
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import copymode
from typing import BinaryIO, cast

from fieldrig.system.own_files import open_file

log = logging.getLogger(__name__)


@contextmanager
def whole_file(path: Path) -> Iterator[BinaryIO]:
    """Yield a file that takes the place of `path` at the end, and is removed by an exception, as by a full disk."""
    if path.exists() and not path.is_file():  # a pipe or a device has no other in its place
        with path.open("wb") as file:
            yield file
        return
    target = path.resolve()
    with _aside(target, lambda part: part.open("x+b")) as file:
        yield file
        if target.exists():
            copymode(target, file.name)


def replace_file(path: Path, data: bytes) -> None:
    """Replace the content of a file in one step: a reader, or a kill, sees the old one or the new one.

    The folder is made.  OSError, with the old content unchanged, if that fails.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as file:
        file.write(data)


def replace_own_file(path: Path, data: bytes) -> None:
    """Replace a file of a rig, which is for this user only, as `replace_file` does; no link is followed."""
    with _aside(path, lambda part: cast(BinaryIO, open_file(part, "wb"))) as file:
        file.write(data)


@contextmanager
def _aside(target: Path, opened: Callable[[Path], BinaryIO]) -> Iterator[BinaryIO]:
    part = target.with_name(f".{target.name}.{os.getpid()}")
    part.unlink(missing_ok=True)  # in a container, the process that was killed here may have had the same number
    try:
        with opened(part) as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        part.replace(target)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
    sync_folder(target.parent)


def sync_folder(folder: Path) -> None:
    """Make renames in `folder` survive power-off; they survive everything else without it."""
    if not hasattr(os, "O_DIRECTORY"):  # Windows
        return
    try:
        fd = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(fd)
        finally:
            os.close(fd)
    except OSError as cause:
        log.warning("%s: its entries may not survive power-off: %s", folder, cause)
