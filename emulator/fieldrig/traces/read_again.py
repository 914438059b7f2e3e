"""A file of a log whose head was read before, for `LogLines` and readers like it."""

from typing import Any


class ReadAgain:
    """`head`, and then the file from where it stands."""

    def __init__(self, head: bytes, file: Any) -> None:
        self._head, self._read = head, getattr(file, "read1", file.read)

    def read1(self, size: int) -> bytes:
        """Return the next bytes, as they come; none at the end."""
        head, self._head = self._head, b""
        return head or bytes(self._read(size))

    read = read1
