"""A file of records that always ends at a whole record, whatever the disk does.

Bytes wait in memory until `put_out`, which is called between two records.  If the disk does not accept them (because it
is full, for example), the file is cut back to its last whole record and the bytes wait on.
"""

import os
from contextlib import suppress
from pathlib import Path


class RecordFile:
    def __init__(self, path: Path) -> None:
        """OSError if the file cannot be opened."""
        self._fd = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0), 0o666)
        self._end = 0
        """Position after the last whole record."""
        self._waiting = bytearray()
        self.trouble = ""
        """Why the disk accepted nothing at the last `put_out`; empty if it did."""

    @property
    def waiting(self) -> int:
        """Number of bytes that wait."""
        return len(self._waiting)

    def write(self, data: bytes) -> int:
        self._waiting += data
        return len(data)

    def put_out(self) -> bool:
        """Write the waiting bytes.  False, with the reason in `trouble`, if the disk does not accept all of them."""
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
        """Close the file, and drop the bytes that still wait."""
        with suppress(OSError):
            os.close(self._fd)
