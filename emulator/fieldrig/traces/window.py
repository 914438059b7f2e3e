"""A part of a trace by its time."""

from collections.abc import Iterable, Iterator
from typing import Final

from fieldrig.clock import NEVER_NS, S
from fieldrig.traces.trace import TraceEntry, is_time_of_day

DISORDER_NS: Final = 10 * S
"""Buses that are recorded side by side, and clocks that are set, bring messages out of order by less than this."""


def within(entries: Iterable[TraceEntry], begin_ns: int | None, duration_ns: int | None) -> Iterator[TraceEntry]:
    """Yield the messages from `begin_ns` for `duration_ns`; None is the beginning, or the end.

    `begin_ns` counts from the first message, or from the start of a rig in virtual time.  Reading ends when the time is
    past the end by more than `DISORDER_NS`.
    """
    from_ns = until_ns = None
    for entry in entries:
        now_ns = entry.time_ns
        if until_ns is None:
            start_ns = origin_ns(now_ns) + (begin_ns or 0)
            from_ns = None if begin_ns is None else start_ns
            until_ns = NEVER_NS if duration_ns is None else start_ns + duration_ns
        if now_ns < until_ns and (from_ns is None or now_ns >= from_ns):
            yield entry
        elif now_ns > until_ns + DISORDER_NS:
            return


def origin_ns(first_ns: int) -> int:
    """Return the instant from which a trace counts whose first message is at `first_ns`."""
    return first_ns if is_time_of_day(first_ns) else min(first_ns, 0)
