"""Our own form of a trace: JSON lines, every family of messages, readable by any script.

    {"time_ns": 1795000000123456789, "bus": "can0", "family": "can", "sender": "io", "data": "0501"}

`time_ns` is the time of day (Unix), or for virtual time the time since the start of the rig.
"""

import json
import re
from collections.abc import Callable, Iterable, Iterator
from typing import BinaryIO, Final

from fieldrig.errors import UsageError
from fieldrig.outside.untrusted import read_json
from fieldrig.traces.log_lines import LogLines
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry

SUFFIXES = (".jsonl",)
FAMILIES: frozenset[str] = frozenset()  # all
LONGEST_LINE = 4 << 20  # bytes; the longest message is half of it as hex


def write(entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int, odd: Oddities | None = None) -> int:
    """Write entries, and return how many.  `start_unix_ns` is the time of day at instant 0 of the entries."""
    written = 0
    for entry in entries:
        line = {
            "time_ns": start_unix_ns + entry.time_ns,
            "bus": entry.bus,
            "family": entry.family,
            "sender": entry.sender,
            "data": entry.data.hex(),
        }
        file.write(json.dumps(line, separators=(",", ":")).encode() + b"\n")
        written += 1
    return written


def recognises(head: bytes) -> bool:
    line = head.partition(b"\n")[0]
    return line.lstrip().startswith(b"{") and b'"time_ns"' in line


_TIME: Final = re.compile(r'\{"time_ns":(-?\d{1,19}),')


def line_clock(head: bytes) -> Callable[[str], int | None]:
    def time_ns(line: str) -> int | None:
        match = _TIME.match(line)
        return int(match[1]) if match else None

    return time_ns


def read(file: BinaryIO, odd: Oddities | None = None) -> Iterator[TraceEntry]:
    """Yield the entries.  UsageError, with the line, for one that `write` does not write; a cut last line is odd."""
    odd = Oddities() if odd is None else odd
    lines = LogLines(file, odd, LONGEST_LINE)
    for line in lines:
        try:
            yield _entry(line)
        except ValueError as cause:
            if lines.is_cut and odd.number > 1:
                return
            what = f"line {odd.number} is not a message of a trace: {cause}"
            raise UsageError(what, "a .jsonl trace is written by `fieldrig trace record`") from cause


def _entry(line: str) -> TraceEntry:
    match read_json(line.encode("latin-1"), LONGEST_LINE):
        case {
            "time_ns": int(time_ns),
            "bus": str(bus),
            "family": str(family),
            "sender": str(sender),
            "data": str(data),
        }:
            return TraceEntry(time_ns, bus, family, sender, bytes.fromhex(data))
    raise ValueError("a key is missing, or has another type")
