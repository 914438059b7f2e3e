"""The ASC format of Vector's CANoe and CANalyzer, for CAN; python-can and asc2log of can-utils read it as well.

Lines are written and read here: python-can's writer leaves out which error it was and the names of buses, cuts the
milliseconds of its date, and writes a time before the first one as one since 1970; its reader takes relative times for
absolute ones, loses the first line after a header, and ends at a line that it does not understand.  Times have
microseconds; the date is in local time, as in Vector's files.  An injected fault has no line and is left out.
"""

import re
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from typing import BinaryIO, Final

from fieldrig.clock import MS, S
from fieldrig.errors import UsageError
from fieldrig.traces.limits import from_1970
from fieldrig.traces.log_lines import LogLines, text_of
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import EXTENDED
from fieldrig_bus.can.codec import decode
from fieldrig_bus.can.frame import EXTENDED_MASK, FD_LENGTHS
from fieldrig_bus.can.linux_flags import ERROR
from fieldrig_bus.can.notices import BusState, CanError
from fieldrig_bus.traces.asc_lines import PLAIN, STATES, base_of, date_of, offset_ns_of, parse, unix_ns
from fieldrig_bus.traces.can_fields import Fields, fields_of
from fieldrig_bus.traces.channels import BusNames, Channels
from fieldrig_bus.traces.error_capture import code_of
from fieldrig_bus.traces.plain_heads import HEAD_BYTES, HeadsOfTexts, PlainHeads

SUFFIXES = (".asc",)
FAMILIES = frozenset({"can"})
REMEDY: Final = "expected a log of CANoe, CANalyzer, python-can or `fieldrig trace`"
_BEGINS: Final = re.compile(
    rb"^\s*(date\s+\w+\s+\w+\.?\s+\d|base\s+(hex|dec)\b|begin\s+trigger ?block\b|"
    rb"\d+\.\d+\s+\d+\s+[0-9A-F]+x?\s+(rx|tx)\s+[dr]\b|\d+\.\d+\s+CANFD\s)",
    re.IGNORECASE | re.MULTILINE,
)
_FD_TAIL: Final = "       0    0 {flags:>8X}        0        0        0        0        0"
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
    odd = Oddities() if odd is None else odd
    written, begin_ns, channels, heads = 0, None, Channels(), PlainHeads(_head_of)
    second, second_ns = "   0.", 0
    for time_ns, bus, family, _, message in entries:
        if family != "can":
            continue
        head, form = heads[message[:HEAD_BYTES]], ""
        if head is not None and message[4] == len(message) - HEAD_BYTES:
            text = f"{head}{message[HEAD_BYTES:].hex(' ').upper()}" if message[4] else head[:-1]
        elif (special := _text(message)) is not None:
            form = special
        else:
            continue
        now_ns = start_unix_ns + time_ns
        if now_ns < 0:
            now_ns = from_1970(now_ns, odd)
        if begin_ns is None or now_ns < begin_ns:
            file.write((_head(now_ns) if begin_ns is None else "End TriggerBlock\n").encode())
            begin_ns = now_ns - now_ns % MS
            _report_twice(begin_ns, odd)
            second, second_ns = "   0.", begin_ns
            file.write(f"Begin Triggerblock {_date(begin_ns)}\n   0.000000 Start of measurement\n".encode())
        channel = channels.get(bus)
        if channel is None:
            file.write(f"// {channels.add(bus)}\n".encode())
            channel = channels[bus]
        part_ns = now_ns - second_ns
        if not 0 <= part_ns < S:
            seconds, part_ns = divmod(now_ns - begin_ns, S)
            second, second_ns = f"{seconds:4}.", begin_ns + seconds * S
        line = form.format(channel=channel) if form else f"{channel}  {text}"
        file.write(f"{second}{part_ns // 1000:06} {line}\n".encode())
        written += 1
    file.write((_head(0) if begin_ns is None else "End TriggerBlock\n").encode())
    return written


def read(file: BinaryIO, odd: Oddities | None = None) -> Iterator[TraceEntry]:
    """Yield the entries.  What is no CAN frame is odd; UsageError, with the line, if nothing is one."""
    odd = Oddities() if odd is None else odd
    lines, names, begin_ns, last_ns = LogLines(file, odd), BusNames(), 0, 0
    is_hex, is_relative, found, has_head = True, False, 0, False
    new = tuple.__new__
    standard, extended = HeadsOfTexts(lambda text: False), HeadsOfTexts(lambda text: True)
    for line in lines:
        match = PLAIN(line) if is_hex and not is_relative else None
        if match is not None:
            seconds, fraction, channel, digits, flag, length, text = match.groups()
            try:
                head, data = (extended if flag else standard)[digits], bytes.fromhex(text)
            except ValueError:  # half a byte, as the line below says
                head, data = (), b""
            if head and len(data) == int(length):
                offset_ns = int(seconds) * S + int(fraction) * 10 ** (9 - len(fraction))
                found += 1
                yield new(TraceEntry, (begin_ns + offset_ns, names[int(channel)], "can", "", head[len(data)] + data))
                continue
        if (date := date_of(line)) is not None:
            begin_ns, has_head = _begin_ns(text_of(date), odd), True
            last_ns = begin_ns
        elif (base := base_of(line)) is not None:
            (is_hex, is_relative), has_head = base, True
        elif line.lstrip().startswith("//"):
            names.learn(line)
        else:
            if is_relative:
                last_ns += offset_ns_of(line)
            try:
                parsed = parse(line, is_hex)
            except ValueError as cause:
                lines.leave_out("frames that cannot be read are left out", "is not a frame of an ASC log", cause)
                continue
            if parsed.what:
                odd.report(parsed.what)
            if parsed.message is not None:
                found += 1
                time_ns = last_ns if is_relative else begin_ns + parsed.offset_ns
                yield TraceEntry(time_ns, names[parsed.channel], "can", "", parsed.message)
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
    day = _local(seconds)
    clock = f"{day.tm_hour:02}:{day.tm_min:02}:{day.tm_sec:02}.{rest_ns // MS:03}"
    return f"{_DAYS[day.tm_wday]} {_MONTHS[day.tm_mon - 1]} {day.tm_mday:02} {clock} {day.tm_year}"


def _report_twice(begin_ns: int, odd: Oddities) -> None:
    """Report a local time that is read as another instant: that of the hour which comes twice when summer ends."""
    with suppress(ValueError, OverflowError, OSError):
        if unix_ns(_date(begin_ns).partition(" ")[2]) != begin_ns:
            odd.report("the local time comes twice on this day, and is read as the first one", f": {_date(begin_ns)}")


def _local(seconds: int) -> time.struct_time:
    """Return the local day and time; UTC where the system has none, as on Windows at the beginning of 1970."""
    with suppress(ValueError, OverflowError, OSError):
        return time.localtime(seconds)
    return time.gmtime(seconds)


def _head_of(identifier: int, is_extended: bool, length: int) -> str:
    digits = f"{identifier:X}{'x' if is_extended else ''}"
    return f"{digits:<15} Rx   d {length:x} "


def _text(message: bytes) -> str | None:
    """The line of a message without its time, with a place for the channel; None for one that has no line."""
    fields = fields_of(message)
    if fields is None:
        return None
    word, _, length, is_fd, _ = fields
    if word & ERROR:
        return _notice(message)
    identifier = f"{word & EXTENDED_MASK:X}{'x' if word & EXTENDED else ''}"
    if is_fd:
        return _fd(fields, identifier)
    return f"{{channel}}  {identifier:<15} Rx   r {length:x}"  # plain data frames have their text already


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
