"""The log format of candump (`candump -L`), for CAN only; canplayer, log2asc, SavvyCAN and python-can read it.

A line has time in microseconds, bus, and frame, but no sender.  Lines are written and read here: python-can's writer
omits the number of bytes that a remote frame requests, and its reader takes error frames of most classes, and data of
half a byte, for frames of the bus.  Errors and changes of state are error frames of SocketCAN; an injected fault has no
frame and is left out.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from typing import BinaryIO, Final, cast

from fieldrig.clock import S
from fieldrig.errors import UsageError
from fieldrig.traces.limits import from_1970
from fieldrig.traces.log_lines import BYTE_ORDER_MARK, LogLines, text_of
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.read_again import ReadAgain
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.frame import EXTENDED_MASK, STANDARD_MASK
from fieldrig_bus.can.linux_flags import BIT_RATE_SWITCH, ERROR
from fieldrig_bus.traces import busmaster
from fieldrig_bus.traces.can_fields import fields_of
from fieldrig_bus.traces.candump_lines import STANDARD_DIGITS, has_differences, is_like_one, parse, says_nothing
from fieldrig_bus.traces.plain_heads import HEAD_BYTES, HeadsOfTexts, PlainHeads

HEAD: Final = 4096
"""Bytes that show whether times are differences."""
SUFFIXES = (".log", ".candump")
FAMILIES = frozenset({"can"})
REMEDY: Final = "write logs with `candump -L` or `fieldrig trace`, or take the line out"
_NO_NAME: Final = re.compile(r"[\s()#]")
MOST_BUSES: Final = 1_000
"""Interfaces whose names are remembered."""
PLAIN: Final = re.compile(
    r"\((\d{1,12})\.(\d{6})\) (\S+) ([0-9A-Fa-f]{8}|[0-9A-Fa-f]{3})#([0-9A-Fa-f]{0,16})\r?", re.ASCII
).fullmatch
"""A line of `candump -L` with a plain data frame, as nearly all are, if its digits are in pairs."""


def recognises(head: bytes) -> bool:
    """Return whether the first line that says something is one of candump, or the head of a log of BUSMASTER."""
    if busmaster.recognises(head):
        return True
    for line in head.decode("latin-1").removeprefix(BYTE_ORDER_MARK).split("\n")[:-1]:
        if not says_nothing(line):
            return is_like_one(line)
    return False


_TIME: Final = re.compile(r" ?\((\d{1,12})\.(\d{6})\) ", re.ASCII)


def line_clock(head: bytes) -> Callable[[str], int | None] | None:
    """A log whose times are those since the line before, or of another form, has to be read from its beginning."""
    if has_differences(head) or busmaster.recognises(head):
        return None

    def time_ns(line: str) -> int | None:
        match = _TIME.match(line)
        return int(match[1]) * S + int(match[2]) * 1000 if match else None

    return time_ns


def write(entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int, odd: Oddities | None = None) -> int:
    """Write entries; `start_unix_ns` is the time of day at their instant 0.  Returns the number of lines."""
    odd = Oddities() if odd is None else odd
    heads, written = PlainHeads(_head), 0
    second, second_ns, last, name = "(0.", 0, "", ""
    for time_ns, bus, family, _, message in entries:
        if family != "can":
            continue
        head = heads[message[:HEAD_BYTES]]
        if head is not None and message[4] == len(message) - HEAD_BYTES:
            body: str | None = head + message[HEAD_BYTES:].hex().upper()
        else:
            body = _body(message)
            if body is None:
                continue
        if bus != last or not name:
            last, name = bus, _name(bus, odd)
        part_ns = start_unix_ns + time_ns - second_ns
        if not 0 <= part_ns < S:
            seconds, part_ns = divmod(from_1970(start_unix_ns + time_ns, odd), S)
            second, second_ns = f"({seconds}.", seconds * S
        file.write(f"{second}{part_ns // 1000:06}) {name} {body}\n".encode())
        written += 1
    return written


def _name(bus: str, odd: Oddities) -> str:
    """Return the name of a bus as one word, as the fields of a line are separated by spaces."""
    name = _NO_NAME.sub("_", bus) or "can"
    if name != bus:
        odd.report("names of buses are one word in the format", f": {bus!r:.60} is {name:.60}")
    return name


def _head(identifier: int, is_extended: bool, length: int) -> str:
    return f"{identifier:08X}#" if is_extended else f"{identifier:03X}#"


def read(file: BinaryIO, odd: Oddities | None = None) -> Iterator[TraceEntry]:
    """Entries with the time of day as their instant.  UsageError, with the line, for a file that is not such a log."""
    odd = Oddities() if odd is None else odd
    begin = file.read(HEAD)
    if busmaster.recognises(begin):
        yield from busmaster.read(cast(BinaryIO, ReadAgain(begin, file)), odd)
        return
    lines, time_ns, buses = LogLines(cast(BinaryIO, ReadAgain(begin, file)), odd), 0, dict[str, str]()
    second, second_ns, new = "", 0, tuple.__new__
    heads, decoded = HeadsOfTexts(lambda text: len(text) != STANDARD_DIGITS), bytes.fromhex
    is_reported, adds_up = False, has_differences(begin)
    for line in lines:
        if match := PLAIN(line):
            seconds, microseconds, bus, identifier, digits = match.groups()
            head = heads[identifier]
            if head and not len(digits) % 2:
                if seconds != second:
                    second, second_ns = seconds, int(seconds) * S
                time_ns = second_ns + int(microseconds) * 1000
                message = head[len(digits) // 2] + decoded(digits)
                yield new(TraceEntry, (time_ns, buses.get(bus) or _bus(bus, buses, odd), "can", "", message))
                continue
        if says_nothing(line):
            continue
        try:
            entry = parse(line)
        except ValueError as wrong:
            if lines.is_cut and odd.number > 1:
                return
            how = "is cut off" if lines.is_cut else "is not a line of candump"
            raise UsageError(f"line {odd.number} {how}: {wrong}", REMEDY) from wrong
        if entry.is_time_wrong:
            odd.report("the time is not one, and the message has that of the line before")
        elif entry.time_ns is None:
            odd.report("lines are without a time (candump -t), and get that of the line before")
        if adds_up and not is_reported:
            is_reported = True
            odd.report("times are those since the line before (candump -t d), and are added up")
        time_ns = time_ns if entry.time_ns is None else entry.time_ns + (time_ns if adds_up else 0)
        if entry.message is not None:
            yield TraceEntry(time_ns, buses.get(entry.bus) or _bus(entry.bus, buses, odd), "can", "", entry.message)
        else:
            odd.report("error frames that report no error and no state of a controller are left out")


def _bus(name: str, buses: dict[str, str], odd: Oddities) -> str:
    """Return the real name of an interface, and tell of a second one."""
    if buses and len(buses) < MOST_BUSES:
        first = next(iter(buses.values()))
        odd.report("another interface begins", f", {text_of(name)}; the lines before are of {first}")
    if len(buses) < MOST_BUSES:
        buses[name] = text_of(name)
    return text_of(name)


def _body(message: bytes) -> str | None:
    """The message as candump shows it; None for a message that candump cannot represent."""
    fields = fields_of(message)
    if fields is None:
        return None
    word, data, length, is_fd, is_switched = fields
    identifier = f"{word:03X}" if word <= STANDARD_MASK else _flagged(word)
    if word & REMOTE:
        return f"{identifier}#R{length or ''}"
    if is_fd:
        return f"{identifier}##{BIT_RATE_SWITCH if is_switched else 0}{data.hex().upper()}"
    return f"{identifier}#{data.hex().upper()}"


def _flagged(word: int) -> str:
    if word & ERROR:
        return f"{word:08X}"
    return f"{word & EXTENDED_MASK:08X}" if word & EXTENDED else f"{word & STANDARD_MASK:03X}"
