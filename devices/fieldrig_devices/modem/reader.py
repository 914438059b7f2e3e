"""The bytes of a terminal in the command state, as command lines (ITU-T V.250, 5.2).

A line begins with AT and ends with the character of S3.  Bit 7 is ignored, so parity does not matter; other control
characters are dropped, and that of S5 deletes the last character.  `A/` repeats the last line at once.
"""

from collections.abc import Callable, Iterator
from typing import Final, NamedTuple

LONGEST_LINE: Final = 255
"""Most characters of a line after AT; a longer one is an error."""


class Line(NamedTuple):
    body: str
    is_too_long: bool = False


class Repeat(NamedTuple):
    """A/ was typed."""


Event = Line | Repeat


class CommandReader:
    """`echo` gets the characters to echo; `register` returns the value of an S register."""

    def __init__(self, echo: Callable[[bytes], None], register: Callable[[int], int]) -> None:
        self._echo, self._register = echo, register
        self._begun = ""
        self._body = ""
        self._is_too_long = False

    def reset(self) -> None:
        self._begun, self._body, self._is_too_long = "", "", False

    def feed(self, data: bytes) -> Iterator[Event]:
        """Yield each line as it ends; what follows is read after it was carried out."""
        for byte in data:
            event = self._take(byte & 0x7F)
            if event is not None:
                yield event

    def _take(self, code: int) -> Event | None:
        letter = chr(code)
        if self._begun != "AT":
            return self._begin(letter)
        if code == self._register(3):
            self._echo(bytes((code,)))
            line = Line(self._body, self._is_too_long)
            self.reset()
            return line
        if code == self._register(5):
            if self._body:
                self._body = self._body[:-1]
                self._echo(bytes((code,)) + b" " + bytes((code,)))
        elif code >= 0x20:
            self._echo(bytes((code,)))
            self._is_too_long |= len(self._body) >= LONGEST_LINE
            if not self._is_too_long:
                self._body += letter
        return None

    def _begin(self, letter: str) -> Event | None:
        self._echo(letter.encode())
        if self._begun == "A" and letter == "/":
            self.reset()
            return Repeat()
        if self._begun == "A" and letter.upper() == "T":
            self._begun = "AT"
        else:
            self._begun = "A" if letter.upper() == "A" else ""
        return None
