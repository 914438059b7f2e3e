"""The ASC format of Vector's CANoe and CANalyzer, for CAN; python-can and asc2log of can-utils read it as well.

Lines are written and read here: python-can's writer leaves out which error it was and the names of buses, cuts the
milliseconds of its date, and writes a time before the first one as one since 1970; its reader takes relative times for
absolute ones, loses the first line after a header, and ends at a line that it does not understand.  Times have
microseconds; the date is in local time, as in Vector's files.  An injected fault has no line and is left out.
"""

import re
import time
from collections.abc import Callable, Iterable, Iterator
from typing import BinaryIO, Final

from fieldrig.clock import MS, S
from fieldrig.errors import UsageError
from fieldrig.traces.log_lines import LogLines, text_of
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.codec import decode
from fieldrig_bus.can.frame import EXTENDED_MASK, FD_LENGTHS, STANDARD_MASK
from fieldrig_bus.can.linux_flags import ERROR
from fieldrig_bus.can.notices import BusState, CanError
from fieldrig_bus.traces.asc_lines import PLAIN, STATES, base_of, date_of, parse, unix_ns
from fieldrig_bus.traces.can_fields import Fields, fields_of, plain_message
from fieldrig_bus.traces.channels import BusNames, Channels
from fieldrig_bus.traces.error_capture import code_of

SUFFIXES = (".asc",)
FAMILIES = frozenset({"can"})
REMEDY: Final = "expected a log of CANoe, CANalyzer, python-can or `fieldrig trace`"
_BEGINS: Final = re.compile(
    rb"^\s*(date\s+\w+\s+\w+\.?\s+\d|base\s+(hex|dec)\b|begin\s+trigger ?block\b|"
    rb"\d+\.\d+\s+\d+\s+[0-9A-F]+x?\s+(rx|tx)\s+[dr]\b|\d+\.\d+\s+CANFD\s)",
    re.IGNORECASE | re.MULTILINE,
)
_FD_TAIL: Final = "        0    0 {flags:>8X}        0        0        0        0        0"
_DAYS: Final = ["Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun"]
_MONTHS: Final = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"]


def recognises(head: bytes) -> bool:
    return b"\0" not in head and _BEGINS.search(head) is not None


_TIME: Final = re.compile(r"\s*(\d{1,12})\.(\d{1,9})\s+(?:\d{1,3}|CANFD)\s", re.ASCII)


def line_clock(head: bytes) -> Callable[[str], int | None] | None:
    """A log that names its buses in comments, or has relative times, has to be read from its beginning."""
    if b"fieldrig: channel" in head or re.search(rb"timestamps\s+relative", head, re.IGNORECASE):
        return None
    begin_ns = 0
    for line in head.decode("latin-1").splitlines():
        if (date := date_of(line)) is not None:
            begin_ns = _begin_ns(text_of(date), Oddities())

    def time_ns(line: str) -> int | None:
        match = _TIME.match(line)
        return begin_ns + int(match[1]) * S + int(match[2].ljust(9, "0")) if match else None

    return time_ns


def write(entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int, odd: Oddities | None = None) -> int:
    """Write entries; `start_unix_ns` is the time of day at their instant 0.  Returns the number of messages."""
    written, begin_ns, channels = 0, None, Channels()
    for entry in entries:
        text = _text(entry.data) if entry.family == "can" else None
        if text is None:
            continue
        time_ns = start_unix_ns + entry.time_ns
        if begin_ns is None or time_ns < begin_ns:
            file.write((_head(time_ns) if begin_ns is None else "End TriggerBlock\n").encode())
            begin_ns = time_ns - time_ns % MS
            file.write(f"Begin Triggerblock {_date(begin_ns)}\n   0.000000 Start of measurement\n".encode())
        if channels.get(entry.bus) is None:
            file.write(f"// {channels.add(entry.bus)}\n".encode())
        seconds, microseconds = divmod((time_ns - begin_ns) // 1000, 1_000_000)
        file.write(f"{seconds:4}.{microseconds:06} {text.format(channel=channels[entry.bus])}\n".encode())
        written += 1
    file.write((_head(0) if begin_ns is None else "End TriggerBlock\n").encode())
    return written


def read(file: BinaryIO, odd: Oddities | None = None) -> Iterator[TraceEntry]:
    """Yield the entries.  What is no CAN frame is odd; UsageError, with the line, if nothing is one."""
    odd = Oddities() if odd is None else odd
    lines, names, begin_ns, last_ns = LogLines(file, odd), BusNames(), 0, 0
    is_hex, is_relative, found, has_head = True, False, 0, False
    new = tuple.__new__
    for line in lines:
        match = PLAIN(line) if is_hex and not is_relative else None
        if match is not None:
            seconds, fraction, channel, digits, extended, length, data = match.groups()
            word = int(digits, 16)
            if len(data) == 3 * int(length) and word <= (EXTENDED_MASK if extended else STANDARD_MASK):
                offset_ns = int(seconds) * S + int(fraction) * 10 ** (9 - len(fraction))
                message = plain_message(word | EXTENDED if extended else word, bytes.fromhex(data))
                found += 1
                yield new(TraceEntry, (begin_ns + offset_ns, names[int(channel)], "can", "", message))
                continue
        if (date := date_of(line)) is not None:
            begin_ns, has_head = _begin_ns(text_of(date), odd), True
            last_ns = begin_ns
        elif (base := base_of(line)) is not None:
            (is_hex, is_relative), has_head = base, True
        elif line.lstrip().startswith("//"):
            names.learn(line)
        else:
            try:
                parsed = parse(line, is_hex)
            except ValueError as cause:
                lines.leave_out("frames that cannot be read are left out", "is not a frame of an ASC log", cause)
                continue
            if parsed.what:
                odd.report(parsed.what)
            if parsed.message is not None:
                last_ns = (last_ns if is_relative else begin_ns) + parsed.offset_ns
                found += 1
                yield TraceEntry(last_ns, names[parsed.channel], "can", "", parsed.message)
    if not found:
        lines.refuse(REMEDY)
        if not has_head and odd.number:
            raise UsageError(f"none of its lines is one of an ASC log, up to line {odd.number}", REMEDY)


def _begin_ns(date: str, odd: Oddities) -> int:
    try:
        return unix_ns(date)
    except (ValueError, OverflowError, OSError):
        odd.report("the date is none, and times count from 0", f": {date:.60}")
        return 0


def _head(time_ns: int) -> str:
    return f"date {_date(time_ns)}\nbase hex  timestamps absolute\ninternal events logged\n"


def _date(time_ns: int) -> str:
    """Return a date in English, whatever the language of the system is."""
    seconds, rest_ns = divmod(time_ns, S)
    day = time.localtime(seconds)
    clock = f"{day.tm_hour:02}:{day.tm_min:02}:{day.tm_sec:02}.{rest_ns // MS:03}"
    return f"{_DAYS[day.tm_wday]} {_MONTHS[day.tm_mon - 1]} {day.tm_mday:02} {clock} {day.tm_year}"


def _text(message: bytes) -> str | None:
    """The line of a message without its time, with a place for the channel; None for one that has no line."""
    fields = fields_of(message)
    if fields is None:
        return None
    word, data, length, is_fd, _ = fields
    if word & ERROR:
        return _notice(message)
    identifier = f"{word & EXTENDED_MASK:X}{'x' if word & EXTENDED else ''}"
    if is_fd:
        return _fd(fields, identifier)
    if word & REMOTE:
        return f"{{channel}}  {identifier:<15} Rx   r {length:x}"
    return f"{{channel}}  {identifier:<15} Rx   d {length:x} {data.hex(' ').upper()}".rstrip()


def _fd(fields: Fields, identifier: str) -> str:
    """A line as python-can and Vector's tools read it; bits 12 and 13 of the flags are FDF and BRS."""
    flags = 1 << 12 | fields.is_switched << 13
    code = FD_LENGTHS.index(fields.length)
    data = fields.data.hex(" ").upper()
    head = f"CANFD {{channel:>3}} Rx   {identifier:>8}  {'':>32} {fields.is_switched:d} 0 {code:x} {fields.length:>2}"
    return f"{head} {data} {_FD_TAIL.format(flags=flags)}"


def _notice(message: bytes) -> str:
    notice = decode(message)
    if isinstance(notice, BusState):
        counters = f"TxErr: {min(notice.tec, 255)} RxErr: {notice.rec}"
        return f"CAN {{channel}} Status:chip status {STATES[notice.state]} - {counters}"
    code = code_of(notice) if isinstance(notice, CanError) else 0
    return f"{{channel}}  ErrorFrame Flags = 0x1 CodeExt = 0x0 Code = 0x{code:x} ID = 0 DLC = 0 Position = 0 Length = 0"
