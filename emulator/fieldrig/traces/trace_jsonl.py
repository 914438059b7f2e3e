"""Our own form of a trace: JSON lines, every family of messages, readable by any script.

    {"time_ns": 1795000000123456789, "bus": "can0", "family": "can", "sender": "io", "data": "0501"}

`time_ns` is the time of day (Unix), or for virtual time the time since the start of the rig.
"""

import json
from collections.abc import Iterable, Iterator
from typing import BinaryIO

from fieldrig.errors import UsageError
from fieldrig.outside.untrusted import read_json
from fieldrig.traces.trace import TraceEntry

SUFFIX = ".jsonl"
FAMILIES: frozenset[str] = frozenset()  # all
LONGEST_LINE = 4 << 20  # bytes; the longest message is half of it as hex


def write(entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int) -> int:
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


def read(file: BinaryIO) -> Iterator[TraceEntry]:
    """Yield the entries.  UsageError, with the line, for anything that `write` does not write."""
    for number, line in enumerate(file, 1):
        try:
            match read_json(line, LONGEST_LINE):
                case {
                    "time_ns": int(time_ns),
                    "bus": str(bus),
                    "family": str(family),
                    "sender": str(sender),
                    "data": str(data),
                }:
                    entry = TraceEntry(time_ns, bus, family, sender, bytes.fromhex(data))
                case _:
                    raise ValueError("a key is missing, or has another type")
        except ValueError as cause:
            what = f"line {number} is not a message of a trace: {cause}"
            raise UsageError(what, "a .jsonl trace is written by `fieldrig trace record`") from cause
        yield entry
