"""The CSV of SavvyCAN and of GVRET firmware, for CAN, which SavvyCAN calls its native format.

Source: `framefileio.cpp` of SavvyCAN, commit 11b7b08d, loadNativeCSVFile and saveNativeCSVFile.  The direction came
with the second version:

    Time Stamp,ID,Extended,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8
    166064000,0000021A,false,0,8,FE,36,12,FE,69,05,07,AD,
    Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8
    166064000,0000021A,false,Rx,0,8,FE,36,12,FE,69,05,07,AD,

Times are in microseconds.  Remote frames, FD frames, errors, names of buses and senders are not in it.  An identifier
above 7FFh is an extended one, whatever its line says, as SavvyCAN reads it.  A file that is written has another ending
than that of python-can's CSV; SavvyCAN wants `.csv`.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from typing import BinaryIO, Final

from fieldrig.clock import US
from fieldrig.traces.limits import from_1970
from fieldrig.traces.log_lines import LogLines
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.frame import EXTENDED_MASK, STANDARD_MASK
from fieldrig_bus.can.linux_flags import ERROR
from fieldrig_bus.traces.can_fields import fields_of, message_of
from fieldrig_bus.traces.channels import BusNames, Channels

SUFFIXES = (".gvret",)
FAMILIES = frozenset({"can"})
HEAD: Final = "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8"
REMEDY: Final = "expected the CSV of SavvyCAN or GVRET"
_BEGINS: Final = re.compile(rb"(?:\xef\xbb\xbf)?Time Stamp,ID,Extended,(?:Dir,)?Bus,LEN,D1\b", re.IGNORECASE)
_TIME: Final = re.compile(r"(\d{1,18}),", re.ASCII)
_LINE: Final = re.compile(
    r"(-?\d{1,18}),([0-9A-F]{1,8}),(true|false|0|1),(?:(?:Rx|Tx|R|T),)?(\d{1,3}),(\d{1,2}),?([0-9A-F,]*)\s*",
    re.IGNORECASE | re.ASCII,
)


def recognises(head: bytes) -> bool:
    return _BEGINS.match(head) is not None


def line_clock(head: bytes) -> Callable[[str], int | None]:
    def time_ns(line: str) -> int | None:
        match = _TIME.match(line)
        return int(match[1]) * US if match else None

    return time_ns


def write(entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int, odd: Oddities | None = None) -> int:
    """Write entries; `start_unix_ns` is the time of day at their instant 0.  Returns the number of messages."""
    odd, channels, written = Oddities() if odd is None else odd, Channels(), 0
    file.write(f"{HEAD}\n".encode())
    for entry in entries:
        fields = fields_of(entry.data) if entry.family == "can" else None
        if fields is None or fields.is_fd or fields.word & (REMOTE | ERROR):
            continue
        if channels.get(entry.bus) is None:
            channels.add(entry.bus)
            if entry.bus != BusNames()[channels[entry.bus]]:
                odd.report("buses have only numbers in the format", f": {entry.bus} is {channels[entry.bus] - 1}")
        flag = "true" if fields.word & EXTENDED else "false"
        numbers = f"{fields.word & EXTENDED_MASK:08X},{flag},Rx,{channels[entry.bus] - 1},{fields.length}"
        data = fields.data.ljust(8, b"\0").hex(",").upper()
        time_us = from_1970(start_unix_ns + entry.time_ns, odd) // US
        file.write(f"{time_us},{numbers},{data},\n".encode())
        written += 1
    return written


def read(file: BinaryIO, odd: Oddities | None = None) -> Iterator[TraceEntry]:
    """Yield the entries.  A line that cannot be read is odd; UsageError, with the line, if none can."""
    odd = Oddities() if odd is None else odd
    lines, names, found = LogLines(file, odd), BusNames(), 0
    for line in lines:
        if not line.strip() or (odd.number == 1 and recognises(line.encode("latin-1"))):
            continue
        try:
            entry = _entry(line, names)
        except ValueError as cause:
            lines.leave_out("lines that cannot be read are left out", "is no line of SavvyCAN's CSV", cause)
            continue
        found += 1
        yield entry
    if not found:
        lines.refuse(REMEDY)


def _entry(line: str, names: BusNames) -> TraceEntry:
    match = _LINE.fullmatch(line)
    if match is None:
        raise ValueError("expected time, identifier, true or false, bus, length and data")
    time_us, identifier, extended, bus, length, text = match.groups()
    word, size = int(identifier, 16), int(length)
    data = bytes(int(digits, 16) for digits in text.split(",")[:size] if digits)
    if len(data) < size:
        raise ValueError(f"{len(data)} bytes of data, and {size} are announced")
    if extended.lower() in ("true", "1") or word > STANDARD_MASK:
        word |= EXTENDED
    if word & EXTENDED_MASK != word & ~EXTENDED:
        raise ValueError(f"identifier {identifier}: expected at most {EXTENDED_MASK:X}")
    message = message_of(word, data, is_fd=size > 8)
    assert message is not None  # only error frames can be nothing
    return TraceEntry(int(time_us) * US, names[int(bus) + 1], "can", "", message)
