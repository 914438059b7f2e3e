"""The bytes of a terminal: command lines (ITU-T V.250, 5.2), and the escape sequence among the data of a call.

A line begins with AT and ends with the character of S3.  Bit 7 is ignored, so parity does not matter; other control
characters are dropped, and that of S5 deletes the last character.  `A/` repeats the last line at once.
"""

from collections.abc import Callable, Iterator
from typing import Final, NamedTuple

from fieldrig.clock import MS

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


GUARD_UNIT_NS: Final = 20 * MS
"""The unit of S12."""
HIGHEST_CHARACTER = 127


class Escape:
    """Three characters of S2 alone, with silence around them, lead from a call to the command state.

    Source: the Hayes command set (S2, S12).  The characters belong to the data as well, as the modem sends them before
    it knows what follows.  Data arrive in chunks; the characters of one chunk count as of one instant.
    """

    def __init__(self) -> None:
        self._last_ns = 0
        self._count = 0

    def restart(self, now_ns: int) -> None:
        """Begin with a call, or with the return to it."""
        self._last_ns, self._count = now_ns, 0

    def hear(self, now_ns: int, data: bytes, character: int, guard_ns: int) -> bool:
        """Return whether the sequence is complete, if nothing follows for `guard_ns` from now."""
        if character > HIGHEST_CHARACTER:
            return False
        if guard_ns and now_ns - self._last_ns >= guard_ns:
            self._count = 0
            is_alone = True
        else:
            is_alone = not guard_ns
        for byte in data:
            continues = 0 < self._count < 3 or (is_alone and self._count in (0, 3))
            if byte == character and continues:
                self._count = self._count % 3 + 1
            else:
                # -1: after other data, a sequence begins only behind a silence; without a guard time, it may at once.
                self._count = -1 if guard_ns else 0
            is_alone = not guard_ns
        self._last_ns = now_ns
        return self._count == 3
