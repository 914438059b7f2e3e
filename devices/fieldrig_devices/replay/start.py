"""The instant of the rig at which a log begins."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import chain, islice
from typing import Final, NamedTuple

from fieldrig.clock import MS
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.dialogues.power_on import HEAD, rig_instant_ns
from fieldrig_devices.replay.sides import Sides

BEFORE_NS: Final = 100 * MS
"""How long before the log its nodes are started."""
START: Final = 1
NMT_COMMAND: Final = bytes(4)
"""The identifier of NMT commands, as the first bytes of a message in a trace."""


class Beginning(NamedTuple):
    """How a log begins."""

    log: Iterator[TraceEntry]
    begin_ns: int
    """The instant of the rig at which it begins."""
    log_ns: int
    """The instant of the log that this is."""
    heard_ns: int = 0
    """The instant of the rig from which on its messages are compared: before, the log does not say what it sends."""
    started: Sequence[int] = ()
    """The nodes that are started before, as they are operational when the log begins."""
    buses: Collection[str] = ()
    """The buses of the rig that the first messages with a sender are of."""


def begin_of(entries: Iterable[TraceEntry], sides: Sides, now_ns: int, settle_ns: int | None) -> Beginning:
    """Return how a log begins.

    `settle_ns` is how long the rig runs before, or None for as long as the machine of the log was on before
    (`rig_instant_ns`).
    UsageError is raised by the log itself.
    """
    rest = iter(entries)
    head = list(islice(rest, HEAD))
    log = chain(head, rest)
    sides.expect_buses(head)
    buses = {bus for entry in head if entry.sender and (bus := sides.bus_of(entry)) is not None}
    first_ns = min((entry.time_ns for entry in head), default=0)
    if settle_ns is None and now_ns == 0 and rig_instant_ns(head) == 0:  # the clock of the log is that of its rig
        begin_ns, log_ns, before_ns = 0, 0, first_ns
    else:
        if settle_ns is None:
            settle_ns = 0 if now_ns else first_ns - rig_instant_ns(head)
        begin_ns, log_ns, before_ns = now_ns + settle_ns, first_ns, settle_ns
    if before_ns < 2 * BEFORE_NS:  # the log begins with the rig
        return Beginning(log, begin_ns, log_ns, begin_ns, buses=buses)
    running = _running(head, sides) if sides.selection.is_master else {}
    starts = [_start(first_ns - BEFORE_NS, bus, node) for bus, node in running]
    nodes = sorted({node for _, node in running})
    heard_ns = begin_ns + first_ns - log_ns
    if not starts or begin_ns == 0:
        return Beginning(chain(starts, log), begin_ns, log_ns, heard_ns, nodes, buses)
    return Beginning(chain(starts, log), begin_ns - BEFORE_NS, first_ns - BEFORE_NS, heard_ns, nodes, buses)


def _running(head: Sequence[TraceEntry], sides: Sides) -> dict[tuple[str, int], None]:
    """Return the nodes that are operational before the log has any NMT command."""
    found: dict[tuple[str, int], None] = {}
    for entry in head:
        if entry.family == "can" and entry.data[:4] == NMT_COMMAND:
            break
        node = sides.running_node(entry)
        if node is not None:
            found[entry.bus, node] = None
    return found


def _start(time_ns: int, bus: str, node: int) -> TraceEntry:
    return TraceEntry(time_ns, bus, "can", "", encode(CanFrame(0, bytes((START, node)))))
