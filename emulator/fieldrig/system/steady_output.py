"""Output to a disk that may be full, a pipe whose reader may be gone, or a file that is closed.

None of these is a reason to end a rig, so logs, and what `fieldrig up` prints, are steady: what cannot be written is
left out, and once there is room again, a line says how many bytes are missing, and why.  Other commands are strict:
they end with a message and an exit code.
"""

import io
import os
import sys
from collections.abc import Callable
from typing import Any, Final, TextIO

from fieldrig.errors import UsageError

STANDARD: Final = (("stdin", 0, os.O_RDONLY), ("stdout", 1, os.O_WRONLY), ("stderr", 2, os.O_WRONLY))


class SteadyFile(io.FileIO):
    """The file of a descriptor, which stays open when this is closed."""

    def __init__(self, fd: int, on_trouble: Callable[[str], None] = lambda _why: None) -> None:
        """`on_trouble` is called with the reason when something is left out for the first time, and at each outage."""
        super().__init__(fd, "w", closefd=False)
        self._on_trouble = on_trouble
        self._missing, self._why = 0, ""

    def write(self, data: Any, /) -> int:
        """Write the data, or leave it out.  It always counts as written."""
        size = memoryview(data).nbytes
        try:
            if self._missing:
                self._write_all(f"\n[{self._missing} bytes are missing here: {self._why}]\n".encode())
                self._missing = 0
            self._write_all(bytes(data))
        except OSError as cause:
            self._leave_out(size, cause)
        return size

    def _write_all(self, data: bytes) -> None:
        left = memoryview(data)
        while left:
            left = left[super().write(left) or 0 :]

    def _leave_out(self, size: int, cause: OSError) -> None:
        is_first = not self._missing
        self._missing += size
        self._why = cause.strerror or str(cause)
        if is_first:
            self._on_trouble(self._why)


class StrictFile(io.FileIO):
    """The file of a descriptor, which stays open when this is closed.  OutputError says that it cannot be written.

    Everything after that is dropped: Python writes what is left at its end, and would end with another traceback.
    """

    def __init__(self, fd: int) -> None:
        super().__init__(fd, "w", closefd=False)
        self._is_lost = False

    def write(self, data: Any, /) -> int:
        """Write the data.  BrokenPipeError, which ends a command in silence, if its reader has gone."""
        if self._is_lost:
            return memoryview(data).nbytes
        try:
            return super().write(data) or 0
        except BrokenPipeError:
            raise
        except OSError as cause:
            self._is_lost = True
            raise OutputError(f"the output cannot be written: {cause.strerror or cause}") from cause


class OutputError(UsageError):
    """The output of a command cannot be written."""


def strict(stream: TextIO) -> TextIO:
    """Return a text stream like `stream` that raises OutputError; itself if it has no descriptor.

    What its encoding has not, as the code page of a pipe on Windows, is written as an escape, and is no error.
    """
    is_lossless = (stream.errors or "strict") == "strict"
    return _like(stream, StrictFile, "backslashreplace" if is_lossless else stream.errors or "strict")


def steady(stream: TextIO, on_trouble: Callable[[str], None] = lambda _why: None) -> TextIO:
    """Return a text stream to the file of `stream` that never raises; itself if it has no descriptor."""
    return _like(stream, lambda fd: SteadyFile(fd, on_trouble), "backslashreplace")


def _like(stream: TextIO, opened: Callable[[int], io.FileIO], errors: str) -> TextIO:
    buffer = getattr(stream, "buffer", None)
    if not isinstance(getattr(buffer, "raw", buffer), io.FileIO):  # the console of Windows, which is never full
        return stream
    try:
        raw = opened(stream.fileno())
    except (OSError, ValueError):  # in memory
        return stream
    is_by_line = bool(stream.line_buffering)
    return io.TextIOWrapper(io.BufferedWriter(raw), encoding=stream.encoding, errors=errors, line_buffering=is_by_line)


def open_missing() -> None:
    """Open the null device instead of standard files that are closed.

    Otherwise Python has None for them, and the next file or socket gets their number, which a child process takes for
    its output.
    """
    for name, fd, flags in STANDARD:
        try:
            os.fstat(fd)
        except OSError:
            null = os.open(os.devnull, flags)
            if null != fd:
                os.dup2(null, fd)
                os.close(null)
        if getattr(sys, name) is None:
            setattr(sys, name, open(fd, "r" if fd == 0 else "w", closefd=False))  # noqa: SIM115  as long as we live
