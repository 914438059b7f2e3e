"""Logs whose lines may end with CR alone, for `LogLines`."""

from fieldrig.traces.read_again import ReadAgain


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
