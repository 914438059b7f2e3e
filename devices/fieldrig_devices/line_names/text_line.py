"""A line of which no device says what it carries: Hayes commands and results, PPP, or text.

Source: ITU-T V.250, 5.2.1 (a command line begins with AT and ends with CR) and 5.7.1 (result codes), RFC 1662.  Results
are only recognised on a line on which a command was seen, because OK is a word of many protocols.
"""

import re
from collections.abc import Sequence
from typing import Final

from fieldrig_bus.traces.ppp_frames import PppFinder
from fieldrig_devices.line_names.characters import is_text, readable, text_or_hex
from fieldrig_devices.line_names.described import Part
from fieldrig_devices.ppp.frame_words import frame_words

MOST_ENDS: Final = 8
"""Ends of a line whose bytes are kept apart; outside programs that come and go are one."""
LONGEST_LINE: Final = 256
"""Bytes of a line that are kept until its end comes."""
COMMAND: Final = re.compile(rb"(?:.*[^ -~])?(A(?:T[ -~]*|/))", re.IGNORECASE | re.DOTALL)
RESULTS: Final = re.compile(
    r"OK|CONNECT(?: .*)?|RING|NO CARRIER|ERROR|NO DIAL ?TONE|BUSY|NO ANSWER|(?:CARRIER|PROTOCOL|COMPRESSION)[: ].*"
    r"|\+[A-Z0-9]+: .*"
)
NUMERIC: Final = {
    "0": "OK", "1": "CONNECT", "2": "RING", "3": "NO CARRIER", "4": "ERROR", "6": "NO DIALTONE", "7": "BUSY",
    "8": "NO ANSWER",
}  # fmt: skip
"""V.250, table 1."""
ESCAPE: Final = b"+++"
_AFTER_PPP: Final = re.compile(rb"\r[ -}\r\n]*|\+\+\+|AT[ -}]*\r?", re.IGNORECASE)
"""The words of a modem, or to it, after a call."""
_FLAG: Final = b"\x7e"


class TextLine:
    """Reads the bytes of one line."""

    def __init__(self) -> None:
        self._ppp, self._is_ppp = PppFinder(), False
        self._open: dict[str, bytes] = {}
        """The line of each end that has not ended yet."""
        self._in_frame: dict[str, bool] = {}
        """True for each end whose last bytes belong to a frame that has not ended."""
        self._commander: str | None = None
        """The end that gives commands to a modem."""

    def __call__(self, sender: str, data: bytes) -> Sequence[Part]:
        end = sender if sender in self._open or len(self._open) < MOST_ENDS else ""
        self._open.setdefault(end, b"")
        frames = self._ppp.feed(end, data)
        if frames:
            self._is_ppp = True
            self._open[end] = b""
            self._in_frame[end] = data[-1:] != _FLAG
            return [frame_words(frame) for frame in frames]
        self._is_ppp = self._is_ppp and not self._is_after_ppp(end, data)
        if self._is_ppp:
            self._in_frame[end] = data[-1:] != _FLAG
            return [("PPP", f"part of a frame, {len(data)} bytes")]
        *lines, rest = (self._open[end] + data).split(b"\r")
        self._open[end] = rest[-LONGEST_LINE:]
        found = [part for line in lines if (part := self._line(end, line)) is not None]
        if not found and data == ESCAPE and self._commander == end:
            return [("escape", readable(data))]
        return found or [("text" if is_text(data) else "data", text_or_hex(data))]

    def _is_after_ppp(self, end: str, data: bytes) -> bool:
        """Return whether these are words after a call, and no part of a frame, which may have any characters."""
        if _AFTER_PPP.fullmatch(data) is None:
            return False
        return not self._in_frame.get(end) or RESULTS.fullmatch(data.strip().decode("latin-1")) is not None

    def _line(self, end: str, line: bytes) -> Part | None:
        command = COMMAND.fullmatch(line)
        if command is not None:
            if self._commander is None:
                self._commander = end
            return "AT command" if self._commander == end else "AT echo", readable(command[1])
        if self._commander in (None, end):
            return None
        text = line.strip(b"\n ").decode("latin-1")
        if text in NUMERIC:
            return "AT result", f"{text} {NUMERIC[text]}"
        return ("AT result", readable(text.encode("latin-1"))) if RESULTS.fullmatch(text) else None
