"""The logs of CANHacker and of the CARBUS Analyzer, which end in .trc as those of PEAK do; they are only read.

Sources: the head of a log of CANHacker, which names its columns; "Trace format (version 3)" in the wiki of the CARBUS
Analyzer (redmine.devnet.ru); `framefileio.cpp` of SavvyCAN, commit 11b7b08d, loadCARBUSAnalyzerFile, for version 2 and
for lines that end with CR alone:

    Time   ID     DLC Data                    Comment
    00,000 00D00422 8 00 00 00 00 00 00 00 00

    @ TEXT @ 3 @ 64 @ 0 @ 3008 @ 82453 @ 00:01:22.453 @
    26,678369  1  80000004  001  8  00 00 00 00 00 00 00 00  00000000

The second one has tabs between time, channel, flags, ID, DLC, data, CRC, text and comment.  Times are seconds.
An identifier of more than four digits, or above 7FFh, is an extended one, as SavvyCAN reads it.
Left out: what no document explains, such as the flags, and what follows the data.
"""

import re
from collections.abc import Iterator
from typing import BinaryIO, Final

from fieldrig.clock import S
from fieldrig.traces.log_lines import LogLines
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import EXTENDED
from fieldrig_bus.can.frame import EXTENDED_MASK, STANDARD_MASK
from fieldrig_bus.traces.can_fields import message_of
from fieldrig_bus.traces.channels import BusNames

REMEDY: Final = "expected a log of CANHacker or of the CARBUS Analyzer"
_BEGINS: Final = re.compile(rb"(?:\xef\xbb\xbf)?(@ TEXT @ [23] @|Time\s+ID\s+DLC\s+Data\s+Comment\b)", re.IGNORECASE)
_TIME: Final = re.compile(r"(\d{1,10})[,.](\d{1,9})", re.ASCII)
_BYTE: Final = re.compile(r"[0-9A-Fa-f]{2}")


def recognises(head: bytes) -> bool:
    return _BEGINS.match(head) is not None


def read(file: BinaryIO, odd: Oddities) -> Iterator[TraceEntry]:
    """Yield the entries.  A line that cannot be read is odd; UsageError, with the line, if none can."""
    lines, names, found, has_channel = LogLines(file, odd), BusNames(), 0, False
    for line in lines:
        if odd.number == 1:
            has_channel = line.startswith("@")
            continue
        if not line.strip() or line.startswith(("#", "@")):
            continue
        try:
            entry = _entry(line.split(), names, has_channel=has_channel)
        except ValueError as cause:
            lines.leave_out("lines that cannot be read are left out", "is not a frame of a log of CANHacker", cause)
            continue
        found += 1
        yield entry
    if not found:
        lines.refuse(REMEDY)


def _entry(words: list[str], names: BusNames, *, has_channel: bool) -> TraceEntry:
    """Return the frame of a line.  ValueError, in words, if it has none."""
    if len(words) < (5 if has_channel else 3):
        raise ValueError("expected time, identifier, length and data")
    time, channel, digits, length, data = (
        (words[0], int(words[1]), words[3], int(words[4]), words[5:])
        if has_channel
        else (words[0], 1, words[1], int(words[2]), words[3:])
    )
    clock = _TIME.fullmatch(time)
    if clock is None:
        raise ValueError(f"{time!r:.20} is not a time in seconds")
    word = int(digits, 16)
    if len(digits) > 4 or word > STANDARD_MASK:
        word |= EXTENDED
    if word & ~EXTENDED > EXTENDED_MASK or not 0 <= length <= 8:
        raise ValueError(f"identifier {digits:.20} with {length} bytes: expected at most {EXTENDED_MASK:X}, and 0 to 8")
    given = [digits for digits in data[:length] if _BYTE.fullmatch(digits)]
    if len(given) < length:
        raise ValueError(f"{len(given)} bytes of data, and {length} are announced")
    message = message_of(word, bytes.fromhex("".join(given)))
    assert message is not None  # only error frames can be nothing
    time_ns = int(clock[1]) * S + int(clock[2].ljust(9, "0"))
    return TraceEntry(time_ns, names[channel], "can", "", message)
