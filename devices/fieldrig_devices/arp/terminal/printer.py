"""The printer at the terminal's serial port: it prints one line for each message.

Source: manual 5.12 (PRINT).  The format of date and time is ours.  Left out: a printer that is busy or has no paper.
"""

from collections import deque
from datetime import datetime
from typing import Final

from fieldrig.link import Link

_KEPT: Final = 20  # number of lines
_END_OF_LINE: Final = b"\r\n"


class Printer:
    """The printer.  If `line` is None, nothing is connected; the last lines are kept all the same."""

    def __init__(self, line: Link[bytes] | None) -> None:
        self._line = line
        self.lines: deque[str] = deque(maxlen=_KEPT)

    def print(self, text: str) -> None:
        self.lines.append(text)
        if self._line is not None:
            self._line.send(text.encode("latin-1", "replace") + _END_OF_LINE)

    def print_time(self, now: datetime) -> None:
        self.print(f"{now:%d/%m/%Y}")
        self.print(f"{now:%H:%M:%S}")
