"""Files of logs for `LogLines`: with a beginning that was read before, or with other ends of lines."""

from typing import Any


class ReadAgain:
    """A file of which `head` was read, from its beginning again."""

    def __init__(self, head: bytes, file: Any) -> None:
        self._head, self._read = head, getattr(file, "read1", file.read)

    def read1(self, size: int) -> bytes:
        """Return the next bytes, as they come; none at the end."""
        head, self._head = self._head, b""
        return head or bytes(self._read(size))

    read = read1


class PlainEnds:
    """A file whose lines end with CR LF, LF or CR, as one whose lines end with LF."""

    def __init__(self, file: ReadAgain) -> None:
        self._file, self._is_after_cr = file, False

    def read1(self, size: int) -> bytes:
        """Return the next bytes, as they come; none at the end."""
        while chunk := self._file.read1(size):
            rest = chunk.removeprefix(b"\n") if self._is_after_cr else chunk
            self._is_after_cr = chunk.endswith(b"\r")
            if rest:
                return rest.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        return b""

    read = read1
