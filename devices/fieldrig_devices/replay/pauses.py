"""Jumps of more than a day in the time of a log, which become short pauses: a rig that runs for years would never end.

They come from a clock that was wrong for a while, or from logs that were put together.
"""

from collections.abc import Callable, Iterable, Iterator
from typing import Final

from fieldrig.clock import S
from fieldrig.traces.instants import span
from fieldrig.traces.oddities import DAY_NS
from fieldrig.traces.trace import TraceEntry

KEPT_NS: Final = 60 * S
"""The time that is played instead of a jump: longer than the time-outs of devices and masters."""


def shortened(entries: Iterable[TraceEntry], note: Callable[[str], None]) -> Iterator[TraceEntry]:
    """Yield the entries, those after a jump earlier or later by its length, and `note` each jump."""
    before_ns = first_ns = None
    earlier_ns = 0
    for entry in entries:
        if first_ns is None or before_ns is None:
            first_ns = before_ns = entry.time_ns
        pause_ns = entry.time_ns - before_ns
        if abs(pause_ns) > DAY_NS:
            at = span(before_ns - earlier_ns - first_ns)
            note(f"the time of the log jumps by {span(pause_ns)} after {at}: {span(KEPT_NS)} are played instead")
            earlier_ns += pause_ns - KEPT_NS
        before_ns = entry.time_ns
        yield entry._replace(time_ns=before_ns - earlier_ns) if earlier_ns else entry
