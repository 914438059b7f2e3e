"""The messages of a log in the order in which a player needs them: when they are sent, or expected to arrive."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from heapq import heappop, heappush
from typing import Any, Final, NamedTuple

from fieldrig.bus import Bus
from fieldrig.faults import note
from fieldrig.points.values import counted
from fieldrig.traces.order import in_order
from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.replay.families import COMPARED, INNER, OUTER
from fieldrig_devices.replay.lead import LONGEST_NS, Leads
from fieldrig_devices.replay.replay_result import ReplayResult
from fieldrig_devices.replay.sides import Side, Sides

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
    entries: Iterable[TraceEntry],
    sides: Sides,
    buses: Mapping[str, Bus[Any]],
    result: ReplayResult,
    compared: Collection[str] = COMPARED,
) -> Iterator[Due]:
    """Yield the messages that are played or expected; the others are counted by bus.

    Nothing is expected of families that are not `compared`.
    """
    waiting: list[Due] = []
    leads, left_out, before_ns = Leads(buses), dict[tuple[str, str], int](), dict[str, int]()
    for number, entry in enumerate(in_order(entries)):
        due = _due(number, entry, sides, buses, leads, compared)
        if due is None and sides.bus_of(entry) is None and entry.family in OUTER:
            continue  # reported as a bus that the rig does not have
        if due is None:
            key = (entry.bus, entry.family) if len(left_out) < MOST_NOTES else ("further buses", "any")
            left_out[key] = left_out.get(key, 0) + 1
            continue
        bus = due.entry.bus
        if due.due_ns < before_ns.get(bus, due.due_ns):  # by the rounded times of a log a frame may begin too early
            due = due._replace(due_ns=before_ns[bus])
        before_ns[bus] = entry.time_ns
        heappush(waiting, due)
        while waiting and (waiting[0].due_ns <= entry.time_ns - LONGEST_NS or len(waiting) > MOST_WAITING):
            yield heappop(waiting)
    while waiting:
        yield heappop(waiting)
    for (bus, family), count in left_out.items():
        result.left_out.append(f"{counted(count, 'message')} of {bus} ({family}): neither played nor compared")


MOST_NOTES: Final = 20


def _due(
    number: int,
    entry: TraceEntry,
    sides: Sides,
    buses: Mapping[str, Bus[Any]],
    leads: Leads,
    compared: Collection[str],
) -> Due | None:
    side, bus = sides.side(entry), sides.bus_of(entry)
    if side is Side.OUTSIDE or bus is None:
        return None
    is_note = entry.family in INNER and entry.data.startswith(note.LEAD)
    if side is Side.EXPECTED and (entry.family not in compared or is_note):
        return None  # a fault that was injected is no message of a device
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
