"""Result codes of a modem, as text or number, from the bytes of its line.

Source: ITU-T V.250, 5.7.1 and table 1: `<CR><LF>OK<CR><LF>` with V1, `0<CR>` with V0.  Other lines, such as the echo
of a command, are skipped.
"""

from enum import Enum
from typing import Final, NamedTuple

LONGEST_LINE: Final = 256
"""Length in bytes up to which a line is read; only the end of a longer one is kept."""


class Result(Enum):
    """The result codes that the controller acts on."""

    OK = "OK"
    CONNECT = "CONNECT"
    RING = "RING"
    NO_CARRIER = "NO CARRIER"
    ERROR = "ERROR"


# V.250, table 1.  CONNECT may be followed by the speed.
NUMBERS: Final = {
    b"0": Result.OK,
    b"1": Result.CONNECT,
    b"2": Result.RING,
    b"3": Result.NO_CARRIER,
    b"4": Result.ERROR,
}
WORDS: Final = {result.value.encode(): result for result in Result}


class Read(NamedTuple):
    """A result code, and the bytes that follow it."""

    result: Result | None
    """None: all bytes are read, and no further result code is complete."""
    rest: bytes


class ResultReader:
    """Reads the lines of a modem in pieces of any size; no input is an error."""

    def __init__(self) -> None:
        self._line = b""

    def clear(self) -> None:
        self._line = b""

    def feed(self, data: bytes) -> Read:
        """Read up to the first result code.  After CONNECT, the rest is data of the call."""
        for at, byte in enumerate(data):
            if byte not in b"\r\n":
                self._line = (self._line + bytes((byte,)))[-LONGEST_LINE:]
                continue
            result, self._line = _result_of(self._line), b""
            if result is not None:
                return Read(result, data[at + 1 :])
        return Read(None, b"")


def _result_of(line: bytes) -> Result | None:
    line = line.strip().upper()
    if line in NUMBERS:
        return NUMBERS[line]
    return Result.CONNECT if line.startswith(b"CONNECT ") else WORDS.get(line)
