"""Logs whose lines end with CR alone, as terminals and old Macs write them, read as if they ended with LF.

Each byte stays in its place, so a jump in time finds the same lines.
"""

import io
from typing import BinaryIO, cast


def has_old_line_ends(head: bytes) -> bool:
    """Return whether a file that begins with these bytes is a text whose lines end with CR alone."""
    return b"\r" in head and b"\n" not in head and b"\0" not in head


def with_line_feeds(file: BinaryIO) -> BinaryIO:
    """Return the file with LF for each CR."""
    return cast(BinaryIO, io.BufferedReader(_LineFeeds(file)))


class _LineFeeds(io.RawIOBase):
    def __init__(self, file: BinaryIO) -> None:
        self._file = file

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return self._file.seekable()

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        return self._file.tell()

    def readinto(self, buffer: "memoryview | bytearray") -> int:  # type: ignore[override]  # the buffers that io gives
        data = self._file.read(len(buffer)).replace(b"\r", b"\n")
        buffer[: len(data)] = data
        return len(data)
