"""What a device keeps over power-off: its non-volatile memory, one blob of bytes, and RAM with a battery.

Nothing saved is lost when a process is killed: written aside, flushed to the disk, renamed over.  Buffered RAM is a
mapped file: what is written to it is there for the next process at once, however this one ends.
"""

import mmap
import os
from pathlib import Path
from typing import Protocol


class Store(Protocol):
    def load(self) -> bytes | None:
        """What was saved last; None if nothing ever was."""

    def save(self, data: bytes) -> None:
        """Keep `data`.  When this returns it survives SIGKILL and power-off; before, the old data does."""

    def buffered_ram(self, size: int) -> memoryview:
        """`size` bytes that keep what is written to them at every instant, over SIGKILL; zeros at first.

        A SIGKILL never tears an aligned word of 4 bytes.  The same bytes are given at every call.
        """


class MemoryStore:
    """Keeps in memory: for virtual time and tests, where a power cycle is a new device on the old store."""

    def __init__(self, data: bytes | None = None) -> None:
        self._data = data
        self._ram = bytearray()

    def load(self) -> bytes | None:
        return self._data

    def save(self, data: bytes) -> None:
        self._data = data

    def buffered_ram(self, size: int) -> memoryview:
        if len(self._ram) < size:
            self._ram = self._ram + bytes(size - len(self._ram))  # another one, for views of the old hold its size
        return memoryview(self._ram)[:size]


class FileStore:
    def __init__(self, path: Path) -> None:
        self._path = path

    def load(self) -> bytes | None:
        try:
            return self._path.read_bytes()
        except FileNotFoundError:
            return None

    def save(self, data: bytes) -> None:
        replace_file(self._path, data)

    def buffered_ram(self, size: int) -> memoryview:
        path = self._path.with_suffix(".ram")
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("a+b") as file:
            if os.fstat(file.fileno()).st_size < size:
                file.truncate(size)
            return memoryview(mmap.mmap(file.fileno(), size))


def replace_file(path: Path, data: bytes) -> None:
    """Put `data` in the place of `path` in one step: a reader, or a kill, sees the old file or the new one."""
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(path.name + ".new")
    with aside.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    aside.replace(path)
    if hasattr(os, "O_DIRECTORY"):  # the rename itself; Windows has no such call
        folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
