"""Python-can's CSV for CAN: a line for each message, with its data in Base64.

Lines are written and read here: python-can's writer rounds the time to a quarter of a microsecond, and its reader ends
at a line that it does not understand.  What such a row cannot say is in `rows`, and is reported when it is written.
"""

import re
from base64 import b64decode
from binascii import a2b_base64, b2a_base64
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import BinaryIO, Final

from fieldrig.clock import S
from fieldrig.traces.log_lines import LogLines
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.traces.can_fields import Fields
from fieldrig_bus.traces.plain_heads import HEAD_BYTES, HeadsOfTexts, PlainHeads
from fieldrig_bus.traces.rows import BUS, Columns, Row, message_of_row, row_of

SUFFIXES = (".csv",)
FAMILIES = frozenset({"can"})
HEAD: Final = "timestamp,arbitration_id,extended,remote,error,dlc,data"
REMEDY: Final = "expected the CSV of python-can or `fieldrig trace`"
_NO_SECOND_NS: Final = 1 << 100
"""The beginning of no second, after which each time is written again."""
_TIME: Final = re.compile(r"(-?)(\d{1,12})(?:\.(\d{1,12}))?", re.ASCII)
_NUMBER: Final = re.compile(r"\d{1,3}", re.ASCII)


def recognises(head: bytes) -> bool:
    return head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(HEAD.encode())


def line_clock(head: bytes) -> Callable[[str], int | None]:
    def time_ns(line: str) -> int | None:
        match = _TIME.match(line)
        return int(match[2]) * S + int((match[3] or "0").ljust(9, "0")[:9]) if match else None

    return time_ns


def write(entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int, odd: Oddities | None = None) -> int:
    """Write entries; `start_unix_ns` is the time of day at their instant 0.  Returns the number of messages."""
    columns, heads, written = Columns(Oddities() if odd is None else odd), PlainHeads(_head), 0
    second, second_ns = b"0.", 0
    file.write(f"{HEAD}\n".encode())
    for entry in entries:
        time_ns, bus, family, _, message = entry
        head = heads[message[:HEAD_BYTES]] if family == "can" and bus == columns.bus else None
        if head is not None and message[4] == len(message) - HEAD_BYTES:
            data = message[HEAD_BYTES:]
        else:
            fields = columns.fields(entry)
            if fields is None:
                continue
            head, data = _odd_head(fields), fields.data
        now_ns = start_unix_ns + time_ns
        part_ns = now_ns - second_ns
        if not 0 <= part_ns < S:
            seconds, part_ns = divmod(abs(now_ns), S)
            second, second_ns = (b"%d." % seconds, seconds * S) if now_ns >= 0 else (b"-%d." % seconds, _NO_SECOND_NS)
        file.write(b"%b%09d,%b%b" % (second, part_ns, head, b2a_base64(data)))  # bytes take half the time of texts
        written += 1
    return written


def _head(identifier: int, is_extended: bool, length: int) -> bytes:
    return b"0x%x,%d,0,0,%d," % (identifier, is_extended, length)


def _odd_head(fields: Fields) -> bytes:
    row = row_of(fields)
    return b"0x%x,%d,%d,%d,%d," % (row.identifier, row.is_extended, row.is_remote, row.is_error, row.length)


def read(file: BinaryIO, odd: Oddities | None = None) -> Iterator[TraceEntry]:
    """Yield the entries.  A line that cannot be read is odd; UsageError, with the line, if none can."""
    odd = Oddities() if odd is None else odd
    lines, found, new = LogLines(file, odd), 0, tuple.__new__
    standard, extended = HeadsOfTexts(lambda text: False), HeadsOfTexts(lambda text: True)
    heads = {"0": standard, "1": extended}
    for line in lines:
        if (plain := _plain(line, heads)) is not None:
            found += 1
            yield new(TraceEntry, (plain[0], BUS, "can", "", plain[1]))
            continue
        if (odd.number == 1 and line.strip().startswith("timestamp")) or not line.strip():
            continue
        try:
            entry = _entry(line)
        except ValueError as cause:
            lines.leave_out("lines that cannot be read are left out", "is no line of python-can's CSV", cause)
            continue
        found += 1
        yield entry
    if not found:
        lines.refuse(REMEDY)


def _plain(line: str, heads: Mapping[str, HeadsOfTexts]) -> tuple[int, bytes] | None:
    """Return the instant and the message of a classical data frame, as nearly all lines are; None for any other."""
    try:
        clock, digits, extended, remote, error, length, text = line.split(",")
        if remote != "0" or error != "0" or clock[-10] != ".":  # nanoseconds, as they are written here
            return None
        data = a2b_base64(text.rstrip(), strict_mode=True)
        size = int(length)
        if len(data) != size:
            return None
        return int(clock[:-10] + clock[-9:]), heads[extended][digits][size] + data
    except (ValueError, LookupError):
        return None


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
