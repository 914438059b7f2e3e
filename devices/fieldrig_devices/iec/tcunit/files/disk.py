"""The disk: its files and folders, those that are open, and what each block does with them.

Each action returns its error, 0 if there is none, then what it has to give.
"""

import fnmatch
from dataclasses import dataclass, field
from typing import Final

from fieldrig_devices.iec import characters
from fieldrig_devices.iec.host import Results
from fieldrig_devices.iec.memory import Memory

LONGEST_LINE: Final = 255
READ, WRITE, APPEND, PLUS, TEXT = 0x01, 0x02, 0x04, 0x08, 0x20
SET, CURRENT, END = range(3)
MOST_OPEN: Final = 1_000
"""Files that may be open at a time: a suite that never closes one gets an error, not the memory of the host."""
NO_HANDLE: Final = 0x703
NO_ACCESS: Final = 0x704
NO_MEMORY: Final = 0x70A
NOT_FOUND: Final = 0x70C


@dataclass(slots=True)
class _Open:
    """An open file: what it has, and where in it the next access is."""

    path: str
    mode: int
    place: int = 0


@dataclass(slots=True)
class Disk:
    """`memory` is that of the program, once it is loaded."""

    memory: Memory | None = None
    contents: dict[str, bytearray] = field(default_factory=dict)
    """The bytes of each file, by its path in small letters."""
    names: dict[str, str] = field(default_factory=dict)
    """The paths as they were given, by the same."""
    folders: dict[str, str] = field(default_factory=dict)
    _open: dict[int, _Open] = field(default_factory=dict)

    def memory_of_program(self) -> Memory:
        """Return the memory that blocks read and write; they are called by a loaded program only."""
        assert self.memory is not None
        return self.memory

    def opened(self, path: str, mode: int, base: int) -> Results:
        key = _key(path)
        if not path or (mode & READ and key not in self.contents):
            return (NOT_FOUND,)
        if len(self._open) >= MOST_OPEN:
            return (NO_MEMORY,)
        if mode & WRITE:
            self.contents[key] = bytearray()
        self.contents.setdefault(key, bytearray())
        self.names.setdefault(key, path)
        handle = next(number for number in range(1, MOST_OPEN + 1) if number not in self._open)
        self._open[handle] = _Open(key, mode)
        return 0, handle

    def closed(self, handle: int) -> Results:
        return (0 if self._open.pop(handle, None) else NO_HANDLE,)

    def read(self, handle: int, address: int, size: int) -> Results:
        file = self._open.get(handle)
        if file is None:
            return (NO_HANDLE,)
        if not file.mode & (READ | PLUS):
            return (NO_ACCESS,)
        data = self._taken(file, size)
        if data:
            self.memory_of_program().put_bytes_at(address, data)
        return 0, len(data), len(data) < size and not data

    def _taken(self, file: _Open, size: int) -> bytes:
        """Read on in a file; as text, an end of a line is one character."""
        content = self.contents.get(file.path, bytearray())
        if not file.mode & TEXT:
            data = bytes(content[file.place : file.place + size])
            file.place += len(data)
            return data
        read = bytearray()
        while len(read) < size and file.place < len(content):
            is_end = content[file.place : file.place + 2] == b"\r\n"
            read.append(0x0A if is_end else content[file.place])
            file.place += 2 if is_end else 1
        return bytes(read)

    def write(self, handle: int, address: int, size: int) -> Results:
        error = self._written(handle, self.memory_of_program().bytes_at(address, size) if size else b"")
        return error, 0 if error else size

    def _written(self, handle: int, data: bytes) -> int:
        file = self._open.get(handle)
        if file is None:
            return NO_HANDLE
        if not file.mode & (WRITE | APPEND | PLUS):
            return NO_ACCESS
        if file.mode & TEXT:
            data = data.replace(b"\n", b"\r\n")
        content = self.contents.setdefault(file.path, bytearray())
        if file.mode & APPEND:
            file.place = len(content)
        content.extend(bytes(max(0, file.place - len(content))))
        content[file.place : file.place + len(data)] = data
        file.place += len(data)
        return 0

    def seek(self, handle: int, offset: int, origin: int) -> Results:
        file = self._open.get(handle)
        if file is None:
            return (NO_HANDLE,)
        base = {SET: 0, CURRENT: file.place, END: len(self.contents.get(file.path, b""))}.get(origin, 0)
        if base + offset < 0:
            return (NO_ACCESS,)
        file.place = base + offset
        return (0,)

    def tell(self, handle: int) -> Results:
        file = self._open.get(handle)
        return (NO_HANDLE,) if file is None else (0, file.place)

    def end(self, handle: int) -> Results:
        file = self._open.get(handle)
        return (NO_HANDLE,) if file is None else (0, file.place >= len(self.contents.get(file.path, b"")))

    def gets(self, handle: int) -> Results:
        file = self._open.get(handle)
        if file is None:
            return (NO_HANDLE,)
        line = bytearray()
        while len(line) < LONGEST_LINE and not line.endswith(b"\n") and (data := self._taken(file, 1)):
            line += data
        return 0, characters.decoded(bytes(line), is_wide=False), not line

    def puts(self, handle: int, line: str) -> Results:
        return (self._written(handle, characters.encoded(line, is_wide=False)),)

    def delete(self, path: str, base: int) -> Results:
        self.names.pop(_key(path), None)
        return (NOT_FOUND if self.contents.pop(_key(path), None) is None else 0,)

    def rename(self, old: str, new: str, base: int) -> Results:
        content = self.contents.pop(_key(old), None)
        if content is None:
            return (NOT_FOUND,)
        self.names.pop(_key(old), None)
        self.contents[_key(new)], self.names[_key(new)] = content, new
        return (0,)

    def create_folder(self, path: str, base: int) -> Results:
        self.folders[_key(path).rstrip("\\")] = path.replace("/", "\\").rstrip("\\")
        return (0,)

    def remove_folder(self, path: str, base: int) -> Results:
        return (NOT_FOUND if self.folders.pop(_key(path).rstrip("\\"), None) is None else 0,)

    def find(self, pattern: str, number: int) -> Results:
        folder, _, wanted = _key(pattern).rpartition("\\")
        wanted = "*" if wanted == "*.*" else wanted.replace("[", "[[]")
        found = [(key, name, False) for key, name in self.names.items()]
        found += [(key, name, True) for key, name in self.folders.items()]
        matches = [
            (name.replace("/", "\\").rpartition("\\")[2], len(self.contents.get(key, b"")), is_folder)
            for key, name, is_folder in sorted(found)
            if key.rpartition("\\")[0] == folder and fnmatch.fnmatchcase(key.rpartition("\\")[2], wanted)
        ]
        return (True, *matches[number]) if number < len(matches) else (False, "", 0, False)


def _key(path: str) -> str:
    return path.replace("/", "\\").replace("\\\\", "\\").casefold()
