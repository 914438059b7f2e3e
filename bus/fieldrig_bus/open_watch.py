"""How often a file has been opened and closed by any process: inotify of Linux, by ctypes.

The descriptor becomes readable when there is something new.  Left out: other systems, which have nothing like it.
"""

import ctypes
import os
import struct
from collections.abc import Iterator
from typing import Final

OPENED: Final = 0x20
CLOSED: Final = 0x08 | 0x10  # after it was open for writing, and after it was not
_FLAGS: Final = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)
_EVENT: Final = struct.Struct("=iIII")
_MOST_BYTES: Final = 4096


class OpenWatch:
    """A watch of one file that exists.  OSError where the system has none, or no more of them."""

    def __init__(self, path: str) -> None:
        libc = ctypes.CDLL(None, use_errno=True)
        if not hasattr(libc, "inotify_init1"):
            raise OSError("this system does not report who opens a file")
        self.fd: int = libc.inotify_init1(_FLAGS)
        if self.fd < 0:
            raise OSError(ctypes.get_errno(), "inotify_init1")
        if libc.inotify_add_watch(self.fd, os.fsencode(path), OPENED | CLOSED) < 0:
            fault = OSError(ctypes.get_errno(), "inotify_add_watch")
            os.close(self.fd)
            raise fault

    def events(self) -> Iterator[bool]:
        """Yield True for opened and False for closed, in order.

        The kernel joins equal events that follow each other without a read between them, so a count may be too low.
        """
        while data := self._read():
            for offset in range(0, len(data), _EVENT.size):  # no names, as the file is not a folder
                _, mask, _, _ = _EVENT.unpack_from(data, offset)
                if mask & (OPENED | CLOSED):
                    yield bool(mask & OPENED)

    def close(self) -> None:
        os.close(self.fd)

    def _read(self) -> bytes:
        try:
            return os.read(self.fd, _MOST_BYTES)
        except BlockingIOError:
            return b""
