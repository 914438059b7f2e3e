"""The flash disk: files by name, in the store of the device.

Source: PacDrive manual 4099-4105, 4175, 5217 (digest PD-043, PD-046).  Names begin with a backslash and are not
case-sensitive; there are no folders.  A file occupies whole clusters.  Sizes match the Diskfree of the manual.  Each
write of a file is a write cycle of its cells, which take as many as the manual gives for the UPS; a file of a new name
gets cells that are unused (our reading).
"""

import struct
from collections.abc import Callable, Mapping
from contextlib import suppress
from errno import ENOSPC
from typing import Final, TypeVar

from fieldrig.storage.store import MemoryStore, Part, Store, StoreError, restore

CLUSTER: Final = 512
WRITE_CYCLES: Final = 100_000
"""Write cycles of a file (manual 6033, digest PD-049)."""
_FILE: Final = struct.Struct("<HI")  # lengths of name and data
_HIDDEN: Final = "$"
_CYCLES: Final = "$CYCLES"
"""Hidden file with the write cycles of the others, which occupies no cluster; its format is that of the disk itself."""
LONGEST_NAME: Final = 40


class FlashDisk:
    """The flash disk of one controller."""

    def __init__(self, store: Store, size: int, on_write: Callable[[str], None] = lambda _name: None) -> None:
        """`on_write` is called with the name of each file that is written.  A disk that cannot be read is empty."""
        self._store, self._size, self.on_write = store, size, on_write
        self._files = restore(store, _unpacked).content or {}
        self._cycles = _cycles_in(self._files)

    @property
    def names(self) -> list[str]:
        return sorted(name for name in self._files if not name.startswith(_HIDDEN))

    @property
    def free(self) -> int:
        """Diskfree, in bytes."""
        return self._size - sum(_on_disk(data) for name, data in self._files.items() if name != _CYCLES)

    def write_cycles(self, name: str) -> int:
        """Return how many times a file was written."""
        return self._cycles.get(name.upper(), 0)

    @property
    def most_cycles(self) -> int:
        """The write cycles of the file that was written most often."""
        return max(self._cycles.values(), default=0)

    def write(self, name: str, data: bytes) -> None:
        """Write a file.  ValueError for a name that is not valid, and for a disk that does not accept the file."""
        name = file_name(name)
        cycles = self.write_cycles(name) + 1
        if cycles > WRITE_CYCLES:
            raise ValueError(f"the flash disk is worn out: {name} has reached its {WRITE_CYCLES} write cycles")
        self._put(name, data, {**self._cycles, name: cycles})
        self.on_write(name)

    def read(self, name: str) -> bytes:
        """Read a file.  ValueError if it does not exist."""
        return self._files[self._known(name)]

    def __contains__(self, name: str) -> bool:
        return name.upper() in self._files

    def install(self, files: Mapping[str, bytes]) -> None:
        """Install files of the rig file, some of them hidden.  ValueError if they do not fit.

        They are on the disk even if the store does not accept them; the next write that it accepts includes them.
        """
        before = self._files
        self._files = {**before, **files}
        if self.free < 0:
            self._files = before
            raise ValueError(
                f"expected a project of at most {self._size} bytes, the size of the disk, got {self._size - self.free}"
            )
        with suppress(StoreError):
            self._store.save(_packed(self._files))

    def delete(self, name: str) -> None:
        """Delete a file.  ValueError if it does not exist, or if the disk cannot be written."""
        known = self._known(name)
        self._change(_without(self._files, known), _without(self._cycles, known))

    def rename(self, name: str, new: str) -> None:
        """Rename a file; a file of the new name is replaced.  ValueError as for `read` and `write`."""
        known, new = self._known(name), file_name(new)
        data, cycles = self._files[known], self.write_cycles(known)
        self._change({**_without(self._files, known), new: data}, {**_without(self._cycles, known), new: cycles})
        self.on_write(new)

    def section(self, name: str) -> Store:
        """Memory for a part of the controller, in a hidden file."""
        return _Section(self, _HIDDEN + name)

    def hidden(self, name: str) -> bytes | None:
        return self._files.get(name)

    def put_hidden(self, name: str, data: bytes) -> None:
        self._put(name, data, self._cycles)

    def _known(self, name: str) -> str:
        name = name.upper()
        if name not in self._files or name.startswith(_HIDDEN):
            there = ", ".join(self.names) or "none"
            raise ValueError(f"expected the name of a file ({there}), got {name}")
        return name

    def _put(self, name: str, data: bytes, cycles: dict[str, int]) -> None:
        before = _on_disk(self._files[name]) if name in self._files else 0
        if _on_disk(data) - before > self.free:
            raise ValueError(f"the flash disk is full: {name} needs {_on_disk(data)} bytes, and {self.free} are free")
        self._change({**self._files, name: bytes(data)}, cycles)

    def _change(self, files: dict[str, bytes], cycles: dict[str, int]) -> None:
        if cycles != self._cycles:
            files = {**files, _CYCLES: _packed({name: count.to_bytes(4, "big") for name, count in cycles.items()})}
        try:
            self._store.save(_packed(files))
        except StoreError as cause:
            reason = f"the flash disk cannot be written: {cause.strerror}"
            raise ValueError(f"{reason}\nits files are unchanged") from cause
        self._files, self._cycles = files, cycles


class _Section(Part):
    def __init__(self, disk: FlashDisk, name: str) -> None:
        self._disk, self._name = disk, name
        self._ram = MemoryStore()

    def load(self) -> bytes | None:
        return self._disk.hidden(self._name)

    def save(self, data: bytes) -> None:
        try:
            self._disk.put_hidden(self._name, data)
        except ValueError as full:
            raise StoreError(ENOSPC, str(full).partition("\n")[0]) from full

    def buffered_ram(self, size: int) -> memoryview:
        """Ordinary memory, because the controller has only 1 kB of buffered memory in total."""
        return self._ram.buffered_ram(size)


def file_name(name: str) -> str:
    """The name in the form of the disk.  ValueError for a name that is not valid."""
    name = name.upper()
    rest = name[1:]
    if (
        not name.startswith("\\")
        or not rest
        or len(name) > LONGEST_NAME
        or not rest.isascii()
        or not rest.isprintable()
    ):
        raise ValueError(f"expected a file name such as \\TEST.PAR, got {name!r}")
    if any(sign in rest for sign in '\\/:*?"<>| '):
        raise ValueError(f"expected a file name of letters, digits and points, got {name!r}")
    return name


def _on_disk(data: bytes) -> int:
    return -(-len(data) // CLUSTER) * CLUSTER


V = TypeVar("V")


def _without(table: dict[str, V], name: str) -> dict[str, V]:
    return {other: value for other, value in table.items() if other != name}


def _cycles_in(files: Mapping[str, bytes]) -> dict[str, int]:
    """The write cycles by name; none if the file with them is damaged."""
    with suppress(ValueError):
        return {name: int.from_bytes(count, "big") for name, count in _unpacked(files.get(_CYCLES, b"")).items()}
    return {}


def _packed(files: dict[str, bytes]) -> bytes:
    return b"".join(
        _FILE.pack(len(name.encode()), len(data)) + name.encode() + data for name, data in sorted(files.items())
    )


def _unpacked(blob: bytes) -> dict[str, bytes]:
    """The files in a blob.  ValueError for data that `_packed` cannot have written."""
    files: dict[str, bytes] = {}
    at = 0
    while at < len(blob):
        if at + _FILE.size > len(blob):
            raise ValueError("the head of a file is cut short")
        name_length, length = _FILE.unpack_from(blob, at)
        start = at + _FILE.size + name_length
        if start + length > len(blob):
            raise ValueError("a file is cut short")
        files[blob[at + _FILE.size : start].decode()] = blob[start : start + length]
        at = start + length
    return files
