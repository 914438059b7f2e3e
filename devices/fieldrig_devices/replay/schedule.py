"""The messages of a log in the order in which a player needs them: when they are sent, or expected to arrive."""

from collections.abc import Iterable, Iterator, Mapping
from heapq import heappop, heappush
from typing import Any, Final, NamedTuple

from fieldrig.bus import Bus
from fieldrig.traces.order import in_order
from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.replay.lead import LONGEST_NS, Leads
from fieldrig_devices.replay.replay_result import ReplayResult
from fieldrig_devices.replay.sides import Side, Sides
from fieldrig_devices.replay.streams import COMPARED

MOST_WAITING: Final = 100_000


class Due(NamedTuple):
    """One message of the log."""

    due_ns: int
    """When it has to be sent, or when it arrives, by the clock of the log."""
    number: int
    lead_ns: int
    """How much later it arrives."""
    entry: TraceEntry
    """The message, with the bus of the rig."""
    message: Any
    """The message to send; None for one that is expected."""


def schedule(
    entries: Iterable[TraceEntry], sides: Sides, buses: Mapping[str, Bus[Any]], result: ReplayResult
) -> Iterator[Due]:
    """Yield the messages that are played or expected; the others are counted in a note."""
    waiting: list[Due] = []
    leads, left_out = Leads(buses), dict[tuple[str, str], int]()
    for number, entry in enumerate(in_order(entries)):
        due = _due(number, entry, sides, buses, leads)
        if due is None and sides.bus_of(entry) is None and entry.family in COMPARED:
            continue  # reported as a bus that the rig does not have
        if due is None:
            key = (entry.bus, entry.family) if len(left_out) < MOST_NOTES else ("further buses", "any")
            left_out[key] = left_out.get(key, 0) + 1
            continue
        heappush(waiting, due)
        while waiting and (waiting[0].due_ns <= entry.time_ns - LONGEST_NS or len(waiting) > MOST_WAITING):
            yield heappop(waiting)
    while waiting:
        yield heappop(waiting)
    for (bus, family), count in left_out.items():
        result.note(f"{count} messages of {bus} ({family}) are neither played nor expected")


MOST_NOTES: Final = 20


def _due(number: int, entry: TraceEntry, sides: Sides, buses: Mapping[str, Bus[Any]], leads: Leads) -> Due | None:
    side, bus = sides.side(entry), sides.bus_of(entry)
    if side is Side.OUTSIDE or bus is None:
        return None
    renamed = TraceEntry(entry.time_ns, bus, entry.family, entry.sender, entry.data)
    if side is Side.EXPECTED:
        return Due(entry.time_ns, number, 0, renamed, None)
    try:
        message = buses[bus].decode(entry.data)
        buses[bus].check(message)
    except (TypeError, ValueError):
        return None
    lead_ns = leads.lead_ns(bus, message)
    return Due(entry.time_ns - lead_ns, number, lead_ns, renamed, message)
