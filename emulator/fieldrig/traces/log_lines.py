"""The lines of a log of text, with their numbers, in constant memory.

A log may come from any program and any system: its lines end with LF or CR LF, it may begin with a byte order mark, and
its names may be in UTF-8 or in the code page of Windows.  Bytes are read as Latin-1, which never fails and keeps each
byte, and `text_of` gives a name its real letters.
"""

from collections.abc import Iterator
from typing import BinaryIO, Final

from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities

LONGEST: Final = 1 << 16
"""Bytes of a line, at most."""
CHUNK: Final = 1 << 20
BYTE_ORDER_MARK: Final = "\xef\xbb\xbf"
NO_LOG: Final = "expected a log of text; `fieldrig trace convert --help` lists the formats"


class LogLines:
    """The lines of a file without their ends.  `is_cut` is true at a last line that has no end, which is reported."""

    def __init__(self, file: BinaryIO, odd: Oddities, longest: int = LONGEST) -> None:
        self._file, self._odd, self._longest = file, odd, longest
        self.is_cut = False
        self._wrong = ""
        odd.unit, odd.number = "line", 0

    def __iter__(self) -> Iterator[str]:
        """Yield the lines.  UsageError for one that is too long to be one of a log."""
        odd, rest = self._odd, ""
        read = getattr(self._file, "read1", self._file.read)
        while chunk := read(CHUNK):
            rest += chunk.decode("latin-1")
            *lines, rest = rest.split("\n")
            for line in lines:
                odd.number += 1
                yield line if odd.number > 1 else line.removeprefix(BYTE_ORDER_MARK)
            if len(rest) > self._longest:
                if odd.number and not rest.strip("\0"):  # room on a disk that was never written: its power failed
                    odd.number += 1
                    odd.report("the rest of the file is zeros")
                    return
                what = f"line {odd.number + 1} has more than {self._longest} bytes"
                raise UsageError(what, NO_LOG)
        if not rest and odd.number == 0:
            odd.report("the file is empty")
        if rest:
            odd.number += 1
            self.is_cut = True
            odd.report("the last line has no end, and may be cut off")
            yield rest if odd.number > 1 else rest.removeprefix(BYTE_ORDER_MARK)

    def leave_out(self, what: str, is_none: str, cause: Exception) -> None:
        """Report that the present line is left out, unless it is cut, which is reported already.

        `what` is the kind of oddity, and `is_none` says what the line is not, such as `is not a frame of a TRC log`.
        """
        if not self.is_cut or self._odd.number == 1:  # a file of one line that is none is no log that was cut
            self._wrong = self._wrong or f"line {self._odd.number} {is_none}: {cause}"
        if not self.is_cut:
            self._odd.report(what, f": {cause}")

    def refuse(self, remedy: str) -> None:
        """Raise UsageError with the first line that was left out, if there is one: the file is no such log."""
        if self._wrong:
            raise UsageError(self._wrong, remedy)


def text_of(latin: str) -> str:
    """Return a text of a log with its real letters: UTF-8 if it is that, else the code page of Windows."""
    if latin.isascii():
        return latin
    data = latin.encode("latin-1", "replace")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace")
