"""A file by its name, for libraries that open files themselves, such as SQLite."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import BinaryIO


@contextmanager
def path_to_read(file: BinaryIO) -> Iterator[Path]:
    """Yield the path of a file, or of a copy of it."""
    name = getattr(file, "name", None)
    if isinstance(name, str) and Path(name).is_file():
        yield Path(name).resolve()
        return
    with TemporaryDirectory() as folder:
        path = Path(folder) / "copy"
        with path.open("wb") as copy:
            shutil.copyfileobj(file, copy)
        yield path


@contextmanager
def path_to_write(file: BinaryIO) -> Iterator[Path]:
    """Yield the path of an empty file, or of one that is copied into it."""
    name = getattr(file, "name", None)
    if isinstance(name, str) and Path(name).is_file():
        yield Path(name)
        return
    with TemporaryDirectory() as folder:
        path = Path(folder) / "made"
        yield path
        with path.open("rb") as made:
            shutil.copyfileobj(made, file)
