"""The flash disk: files by name, in the device's store.

Source: PacDrive manual 4099-4105, 4175, 5217 (digest PD-043, PD-046).  Names begin with a backslash and know no case;
there are no folders.  A file takes whole clusters.  Sizes are those that give the manual's Diskfree.
"""

import struct
import zlib
from collections.abc import Callable
from typing import Final

from fieldrig.store import MemoryStore, Store

CLUSTER: Final = 512
_MAGIC: Final = b"MAX4DISK"
_FILE: Final = struct.Struct("<HI")  # lengths of name and data
_HIDDEN: Final = "$"
LONGEST_NAME: Final = 40


class FlashDisk:
    def __init__(self, store: Store, size: int, on_write: Callable[[str], None] = lambda _name: None) -> None:
        """`on_write` hears of each file that was written.  What can't be read back is an empty disk."""
        self._store, self._size, self.on_write = store, size, on_write
        self._files = _unpacked(store.load() or b"")

    @property
    def names(self) -> list[str]:
        return sorted(name for name in self._files if not name.startswith(_HIDDEN))

    @property
    def free(self) -> int:
        """Diskfree, in bytes."""
        return self._size - sum(map(_on_disk, self._files.values()))

    def write(self, name: str, data: bytes) -> None:
        """ValueError, with what would be right."""
        name = file_name(name)
        self._put(name, data)
        self.on_write(name)

    def read(self, name: str) -> bytes:
        """ValueError if there is none of this name."""
        return self._files[self._known(name)]

    def __contains__(self, name: str) -> bool:
        return name.upper() in self._files

    def delete(self, name: str) -> None:
        del self._files[self._known(name)]
        self._save()

    def section(self, name: str) -> Store:
        """Memory for a part of the controller: a file that nobody sees."""
        return _Section(self, _HIDDEN + name)

    def hidden(self, name: str) -> bytes | None:
        return self._files.get(name)

    def put_hidden(self, name: str, data: bytes) -> None:
        self._put(name, data)

    def _known(self, name: str) -> str:
        name = name.upper()
        if name not in self._files or name.startswith(_HIDDEN):
            there = ", ".join(self.names) or "none"
            raise ValueError(f"there is no file {name}: there are {there}")
        return name

    def _put(self, name: str, data: bytes) -> None:
        before = _on_disk(self._files[name]) if name in self._files else 0
        if _on_disk(data) - before > self.free:
            raise ValueError(f"the flash disk has {self.free} bytes left, {name} needs {_on_disk(data)}")
        files = self._files
        self._files = {**files, name: bytes(data)}
        try:
            self._save()
        except OSError:
            self._files = files
            raise

    def _save(self) -> None:
        self._store.save(_packed(self._files))


class _Section:
    def __init__(self, disk: FlashDisk, name: str) -> None:
        self._disk, self._name = disk, name
        self._ram = MemoryStore()

    def load(self) -> bytes | None:
        return self._disk.hidden(self._name)

    def save(self, data: bytes) -> None:
        """OSError if the disk is full."""
        try:
            self._disk.put_hidden(self._name, data)
        except ValueError as full:
            raise OSError(str(full)) from full

    def buffered_ram(self, size: int) -> memoryview:
        """Not buffered: the controller has 1 kB of that in all."""
        return self._ram.buffered_ram(size)


def file_name(name: str) -> str:
    """As the disk has it.  ValueError, with what would be right."""
    name = name.upper()
    rest = name[1:]
    if (
        not name.startswith("\\")
        or not rest
        or len(name) > LONGEST_NAME
        or not rest.isascii()
        or not rest.isprintable()
    ):
        raise ValueError(f"{name!r} is no file: right would be a name like \\TEST.PAR")
    if any(sign in rest for sign in '\\/:*?"<>| '):
        raise ValueError(f"{name!r} is no file: right would be letters, digits, points")
    return name


def _on_disk(data: bytes) -> int:
    return -(-len(data) // CLUSTER) * CLUSTER


def _packed(files: dict[str, bytes]) -> bytes:
    body = b"".join(
        _FILE.pack(len(name.encode()), len(data)) + name.encode() + data for name, data in sorted(files.items())
    )
    return _MAGIC + zlib.crc32(body).to_bytes(4, "little") + body


def _unpacked(blob: bytes) -> dict[str, bytes]:
    body = blob[len(_MAGIC) + 4 :]
    if blob[: len(_MAGIC)] != _MAGIC or zlib.crc32(body).to_bytes(4, "little") != blob[len(_MAGIC) : len(_MAGIC) + 4]:
        return {}
    files, at = {}, 0
    while at < len(body):
        name_length, length = _FILE.unpack_from(body, at)
        at += _FILE.size
        name = body[at : at + name_length].decode()
        files[name] = body[at + name_length : at + name_length + length]
        at += name_length + length
    return files
