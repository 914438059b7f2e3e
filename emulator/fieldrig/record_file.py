"""A file of records that ends at a whole record whatever the disk does.

Bytes wait in memory until `put_out`, which is called between two records.  If the disk doesn't take them (it is full,
say), the file is cut back to its last whole record and they go on waiting.
"""

import os
from contextlib import suppress
from pathlib import Path


class RecordFile:
    def __init__(self, path: Path) -> None:
        """OSError if it can't be opened."""
        self._fd = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0), 0o666)
        self._end = 0
        """Where the last whole record ends."""
        self._waiting = bytearray()
        self.trouble = ""
        """Why the disk took nothing at the last `put_out`; empty if it did."""

    @property
    def waiting(self) -> int:
        """Bytes that wait."""
        return len(self._waiting)

    def write(self, data: bytes) -> int:
        self._waiting += data
        return len(data)

    def put_out(self) -> bool:
        """Write what waits.  False, with the reason in `trouble`, if the disk doesn't take all of it."""
        done = 0
        try:
            os.lseek(self._fd, self._end, os.SEEK_SET)
            while done < len(self._waiting):
                done += os.write(self._fd, self._waiting[done:])
        except OSError as cause:
            with suppress(OSError):  # what is left over is overwritten when there is room
                os.ftruncate(self._fd, self._end)
            self.trouble = cause.strerror or str(cause)
            return False
        self._end += done
        self._waiting.clear()
        self.trouble = ""
        return True

    def close(self) -> None:
        """What still waits is dropped."""
        with suppress(OSError):
            os.close(self._fd)
