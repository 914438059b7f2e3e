"""The beginning of a trace, for formats that count from their first message and have nothing before it."""

from collections.abc import Iterator

from fieldrig.traces.order import MOST_WAITING
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.window import DISORDER_NS


def beginning(entries: Iterator[TraceEntry]) -> tuple[list[TraceEntry], Iterator[TraceEntry]]:
    """Return the messages of the first seconds, among which is the earliest one of all, and those after them."""
    first: list[TraceEntry] = []
    for entry in entries:
        first.append(entry)
        if entry.time_ns > first[0].time_ns + DISORDER_NS or len(first) >= MOST_WAITING:
            break
    return first, entries
