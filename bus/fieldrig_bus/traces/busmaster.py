"""The logs of BUSMASTER, of CAN; they end in .log as those of candump do, and they are only read.

Sources: the logs that BUSMASTER writes, and the file format "BUSMASTER log file" of Wireshark, which reads them too.
A head says how numbers and times are written, and may come again in the file, with each session:

    ***BUSMASTER Ver 3.2.2***
    ***PROTOCOL CAN***
    ***START DATE AND TIME 8:8:2014 11:49:7:965***
    ***HEX***
    ***SYSTEM MODE***
    11:49:12:9420 Rx 1 0x023 s 1 40
    11:49:12:9440 Tx 1 0x18FEF100 x 2 03 E0

A line has the time in hours, minutes, seconds and 100 us, the direction, the channel, the identifier, the type (s or
x, with r for a remote frame and -fd for one of CAN FD), the length and the data.  Times are those of the local day
(SYSTEM MODE), since the start of the session (ABSOLUTE MODE), or since the line before (RELATIVE MODE).  The length of
an FD frame may be decimal where the data is hexadecimal; the number of its bytes says which.
Left out: the switch of the bit rate of FD frames, which is not in a log; logs of J1939 and LIN are refused.
"""

import re
import time
from collections.abc import Iterator
from datetime import datetime
from typing import BinaryIO, Final

from fieldrig.clock import MS, US, S
from fieldrig.errors import UsageError
from fieldrig.traces.log_lines import LogLines
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import EXTENDED_MASK
from fieldrig_bus.traces.can_fields import message_of
from fieldrig_bus.traces.channels import BusNames
from fieldrig_bus.traces.error_capture import unknown_error

REMEDY: Final = "expected a log of BUSMASTER of the protocol CAN"
DAY_NS: Final = 86_400 * S
_BEGINS: Final = re.compile(rb"(?:\xef\xbb\xbf)?\s*\*\*\*\s*BUSMASTER\b")
_PROTOCOL: Final = re.compile(r"\*\*\*PROTOCOL (\w+)\*\*\*")
_BASE: Final = re.compile(r"\*\*\*(HEX|DEC)\*\*\*")
_MODE: Final = re.compile(r"\*\*\*(SYSTEM|ABSOLUTE|RELATIVE) MODE\*\*\*")
_START: Final = re.compile(
    r"\*\*\*START DATE AND TIME (\d{1,2}):(\d{1,2}):(\d{4}) (\d{1,2}):(\d{1,2}):(\d{1,2}):(\d{1,3})\*\*\*", re.ASCII
)
_LINE: Final = re.compile(
    r"(\d{1,6}):(\d{1,2}):(\d{1,2}):(\d{1,6})\s+[RT]x\s+(\d{1,3})\s+(?:(?:\S+\s+)?(?P<error>ERR)\b.*|"
    r"(?:0x)?(?P<id>[0-9A-F]{1,10})\s+(?P<kind>[sx])(?P<form>r|-fd)?\s+(?P<length>[0-9A-F]{1,2})\b\s*(?P<data>.*))",
    re.IGNORECASE | re.ASCII,
)


def recognises(head: bytes) -> bool:
    return _BEGINS.match(head) is not None


class _Session:
    """The head of a session, which says how its lines are read, and the instant of the last line."""

    def __init__(self, odd: Oddities) -> None:
        self._odd = odd
        self.base = 16
        self._mode = "SYSTEM"
        self._start_ns = self._last_ns = 0

    def learn(self, line: str) -> None:
        """Take a line of a head.  UsageError for a protocol that is not read."""
        if match := _BASE.match(line):
            self.base = 16 if match[1] == "HEX" else 10
        elif match := _MODE.match(line):
            self._mode = match[1]
        elif match := _START.match(line):
            self._start_ns = self._last_ns = self._begin_ns([int(number) for number in match.groups()])
        elif (match := _PROTOCOL.match(line)) and match[1] != "CAN":
            raise UsageError(f"line {self._odd.number}: a log of {match[1]:.20}, of BUSMASTER, is not read", REMEDY)

    def _begin_ns(self, numbers: list[int]) -> int:
        day, month, year, hour, minute, second, ms = numbers
        try:
            local = datetime(year, month, day, hour, minute, second).astimezone()
            return int(local.timestamp()) * S + ms * MS
        except (ValueError, OverflowError, OSError):
            self._odd.report("the date is none, and times count from 0")
            return 0

    def instant(self, clock_ns: int) -> int:
        """Return the instant of a line whose clock shows this."""
        if self._mode == "RELATIVE":
            self._odd.report("times are those since the line before (RELATIVE MODE), and are added up")
            self._last_ns += clock_ns
        elif self._mode == "ABSOLUTE":
            self._last_ns = self._start_ns + clock_ns
        else:
            self._last_ns = self._of_day(clock_ns)
        return self._last_ns

    def _of_day(self, clock_ns: int) -> int:
        """Return the instant nearest to that of the line before at which a local clock shows this."""
        last = time.localtime(self._last_ns // S)
        shown_ns = (last.tm_hour * 3600 + last.tm_min * 60 + last.tm_sec) * S + self._last_ns % S
        ahead_ns = (clock_ns - shown_ns + DAY_NS // 2) % DAY_NS - DAY_NS // 2
        return self._last_ns + ahead_ns


def read(file: BinaryIO, odd: Oddities) -> Iterator[TraceEntry]:
    """Yield the entries.  A line that cannot be read is odd; UsageError, with the line, if none can."""
    lines, names, session, found = LogLines(file, odd), BusNames(), _Session(odd), 0
    for line in lines:
        text = line.strip()
        if text.startswith("***"):
            session.learn(text)
        elif text:
            try:
                entry = _entry(text, session, names)
            except ValueError as cause:
                lines.leave_out("lines that cannot be read are left out", "is not a frame of BUSMASTER", cause)
                continue
            found += 1
            yield entry
    if not found:
        lines.refuse(REMEDY)


def _entry(text: str, session: _Session, names: BusNames) -> TraceEntry:
    match = _LINE.fullmatch(text)
    if match is None:
        raise ValueError("expected time, Rx or Tx, channel, identifier, type, length and data")
    hours, minutes, seconds, fraction, channel = match.group(1, 2, 3, 4, 5)
    message = encode(unknown_error()) if match["error"] else _message(match, session.base)
    part_ns = int(fraction) * (MS if len(fraction) == 3 else 100 * US)  # SavvyCAN writes milliseconds
    clock_ns = (int(hours) * 3600 + int(minutes) * 60 + int(seconds)) * S + part_ns
    return TraceEntry(session.instant(clock_ns), names[int(channel)], "can", "", message)


def _message(match: re.Match[str], base: int) -> bytes:
    word, form = int(match["id"], base), (match["form"] or "").lower()
    if word > EXTENDED_MASK:
        raise ValueError(f"identifier {match['id']}: expected at most {EXTENDED_MASK:#x}")
    if match["kind"] in "xX":
        word |= EXTENDED
    digits = match["data"].split()
    length = int(match["length"], base)
    if form == "-fd" and match["length"].isdecimal() and int(match["length"]) == len(digits):
        length = len(digits)
    data = b"" if form == "r" else bytes(int(number, base) for number in digits[:length])
    if form != "r" and len(data) < length:
        raise ValueError(f"{len(data)} bytes of data, and {length} are announced")
    message = message_of(word | (REMOTE if form == "r" else 0), data, length, is_fd=form == "-fd")
    assert message is not None  # only error frames can be nothing
    return message
