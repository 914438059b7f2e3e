"""Files of the flash disk that a program has opened.

A file that is written is on the disk when it has been closed; the disk has no folders, and a name without a leading
backslash gets one.
"""

from typing import Final

from fieldrig_devices.iec.host import Results
from fieldrig_devices.max4.storage.disk import FlashDisk

MOST: Final = 16
LONGEST: Final = 1 << 20
"""Largest file that a program can write, in bytes."""
UNKNOWN: Final = -1
REFUSED: Final = -2
WRONG: Final = -3
_LONGEST_TEXT: Final = 255


class _File:
    def __init__(self, name: str, mode: str, data: bytes) -> None:
        self.name, self.mode = name, mode
        self.data = bytearray(data)
        self.at = 0


class OpenFiles:
    """The open files of one program, by their numbers from 1."""

    def __init__(self, disk: FlashDisk) -> None:
        self._disk = disk
        self._open: dict[int, _File] = {}

    def drop(self) -> None:
        self._open.clear()

    def open(self, name: str, mode: str) -> Results:
        name, mode = disk_name(name), mode.lower()
        number = next((number for number in range(1, MOST + 1) if number not in self._open), None)
        if mode not in ("r", "w", "a"):
            return (WRONG,)
        if number is None:
            return (REFUSED,)
        try:
            data = self._disk.read(name) if mode == "r" or (mode == "a" and name in self._disk) else b""
        except ValueError:
            return (UNKNOWN,)
        self._open[number] = _File(name, mode, data)
        return (number,)

    def read(self, number: int, length: int) -> Results:
        """Return the next characters; an empty text at the end of the file."""
        file = self._open.get(number)
        if file is None or file.mode != "r":
            return ("",)
        end = file.at + min(max(length, 0), _LONGEST_TEXT)
        data = bytes(file.data[file.at : end])
        file.at += len(data)
        return (data.decode("latin-1"),)

    def write(self, number: int, text: str) -> Results:
        file = self._open.get(number)
        if file is None or file.mode == "r":
            return (WRONG,)
        data = text.encode("latin-1", "replace")
        if len(file.data) + len(data) > LONGEST:
            return (REFUSED,)
        file.data += data
        return (len(data),)

    def is_at_end(self, number: int) -> bool:
        """True at the end of a file, and for a number that is not open."""
        file = self._open.get(number)
        return file is None or file.at >= len(file.data)

    def close(self, number: int) -> Results:
        file = self._open.pop(number, None)
        if file is None:
            return (WRONG,)
        if file.mode != "r":
            try:
                self._disk.write(file.name, bytes(file.data))
            except ValueError:
                return (REFUSED,)
        return (0,)

    def append(self, name: str, text: str) -> None:
        """Append a text to a file, which is created if necessary.  ValueError if the disk refuses it."""
        name = disk_name(name)
        before = self._disk.read(name) if name in self._disk else b""
        data = before + text.encode("latin-1", "replace")
        if len(data) > LONGEST:
            raise ValueError(f"expected a file of at most {LONGEST} bytes, got {len(data)}")
        self._disk.write(name, data)

    def size(self, name: str) -> Results:
        try:
            return (len(self._disk.read(disk_name(name))),)
        except ValueError:
            return (UNKNOWN,)


def disk_name(name: str) -> str:
    """The name in capitals with its backslash; names that are not valid are refused by the disk."""
    return (name if name.startswith("\\") else f"\\{name}").upper()
