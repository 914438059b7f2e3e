"""Python-can's CSV for CAN: a line for each message, with its data in Base64.

Lines are written and read here: python-can's writer rounds the time to a quarter of a microsecond, and its reader ends
at a line that it does not understand.  What such a row cannot say is in `rows`, and is reported when it is written.
"""

import re
from base64 import b64decode
from binascii import a2b_base64, b2a_base64
from collections.abc import Callable, Iterable, Iterator
from typing import BinaryIO, Final

from fieldrig.clock import S
from fieldrig.errors import UsageError
from fieldrig.traces.log_lines import LogLines
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import EXTENDED
from fieldrig_bus.can.frame import EXTENDED_MASK, STANDARD_MASK
from fieldrig_bus.traces.can_fields import plain_message
from fieldrig_bus.traces.rows import BUS, Row, Rows, message_of_row

SUFFIXES = (".csv",)
FAMILIES = frozenset({"can"})
HEAD: Final = "timestamp,arbitration_id,extended,remote,error,dlc,data"
REMEDY: Final = "expected the CSV of python-can or `fieldrig trace`"
_TIME: Final = re.compile(r"(-?)(\d{1,12})(?:\.(\d{1,12}))?", re.ASCII)
_PLAIN: Final = re.compile(
    r"(\d{1,12})\.(\d{1,9}),0x([0-9a-f]{1,8}),([01]),0,0,\d,((?:[A-Za-z0-9+/]{4})*(?:[A-Za-z0-9+/]{2}==|[A-Za-z0-9+/]{3}=)?)\r?",
    re.ASCII,
).fullmatch
"""A classical data frame, as nearly all lines are."""
_TENS: Final = [10 ** (9 - digits) for digits in range(10)]
"""Nanoseconds of the last digit of a fraction, by its number of digits."""
_NUMBER: Final = re.compile(r"\d{1,3}", re.ASCII)


def recognises(head: bytes) -> bool:
    return head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(HEAD.encode())


def line_clock(head: bytes) -> Callable[[str], int | None]:
    def time_ns(line: str) -> int | None:
        match = _PLAIN(line.rstrip())
        return int(match[1]) * S + int(match[2]) * 10 ** (9 - len(match[2])) if match else None

    return time_ns


def write(entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int, odd: Oddities | None = None) -> int:
    """Write entries; `start_unix_ns` is the time of day at their instant 0.  Returns the number of messages."""
    rows, written = Rows(Oddities() if odd is None else odd), 0
    file.write(f"{HEAD}\n".encode())
    for entry in entries:
        row = rows.row(entry)
        if row is None:
            continue
        identifier, is_extended, is_remote, is_error, length, data = row
        clock = f"{start_unix_ns + entry.time_ns:010}"
        flags = f"{is_extended:d},{is_remote:d},{is_error:d}" if is_extended or is_remote or is_error else "0,0,0"
        text = b2a_base64(data, newline=False).decode()
        file.write(f"{clock[:-9]}.{clock[-9:]},0x{identifier:x},{flags},{length},{text}\n".encode())
        written += 1
    return written


def read(file: BinaryIO, odd: Oddities | None = None) -> Iterator[TraceEntry]:
    """Yield the entries.  A line that cannot be read is odd; UsageError, with the line, if none can."""
    odd = Oddities() if odd is None else odd
    lines, found, wrong, new = LogLines(file, odd), 0, "", tuple.__new__
    second, second_ns = "", 0
    for line in lines:
        if match := _PLAIN(line):
            seconds, fraction, digits, extended, text = match.groups()
            word, data = int(digits, 16), a2b_base64(text)
            if len(data) <= 8 and word <= (EXTENDED_MASK if extended == "1" else STANDARD_MASK):
                if seconds != second:
                    second, second_ns = seconds, int(seconds) * S
                time_ns = second_ns + int(fraction) * _TENS[len(fraction)]
                found += 1
                message = plain_message(word if extended == "0" else word | EXTENDED, data)
                yield new(TraceEntry, (time_ns, BUS, "can", "", message))
                continue
        if (odd.number == 1 and line.strip().startswith("timestamp")) or not line.strip():
            continue
        try:
            entry = _entry(line)
        except ValueError as cause:
            if not lines.is_cut:
                wrong = wrong or f"line {odd.number} is no line of python-can's CSV: {cause}"
                odd.report("lines that cannot be read are left out", f": {cause}")
            continue
        found += 1
        yield entry
    if wrong and not found:
        raise UsageError(wrong, REMEDY)


def _entry(line: str) -> TraceEntry:
    fields = line.strip().split(",")
    if len(fields) != 7:
        raise ValueError(f"{len(fields)} fields, expected 7")
    time_text, identifier, extended, remote, error, length, text = fields
    if (match := _TIME.fullmatch(time_text)) is not None:
        time_ns = int(match[2]) * S + int((match[3] or "0").ljust(9, "0")[:9])
        time_ns = -time_ns if match[1] else time_ns
    else:
        time_ns = _odd_time_ns(time_text)
    number, data = int(identifier, 16), b64decode(text, validate=True)
    if not _NUMBER.fullmatch(length):
        raise ValueError(f"{length!r:.20} is not a length")
    row = Row(number, extended == "1", remote == "1", error == "1", int(length), data)
    return TraceEntry(time_ns, BUS, "can", "", message_of_row(row))


def _odd_time_ns(text: str) -> int:
    """Return a time as Python writes small floats, such as 1e-05."""
    try:
        return round(float(text) * S)
    except (ValueError, OverflowError):
        raise ValueError(f"{text!r:.30} is not a time in seconds") from None
