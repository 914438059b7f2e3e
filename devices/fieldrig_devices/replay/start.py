"""The instant of the rig at which a log begins."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, islice
from typing import Final, NamedTuple

from fieldrig.clock import MS, S
from fieldrig.traces.trace import TraceEntry, is_time_of_day
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.names import ERROR_CONTROL, NODES
from fieldrig_devices.replay.sides import Sides

SETTLE_NS: Final = S
"""Time for a rig to boot before a log begins that was recorded of a machine that was on already."""
BEFORE_NS: Final = 100 * MS
"""How long before the log its nodes are started."""
START: Final = 1
NMT_COMMAND: Final = bytes(4)
"""The identifier of NMT commands, as the first bytes of a message in a trace."""
HEAD: Final = 500
BOOT_UP: Final = b"\x01\x00"
"""Length and data of a boot-up message (CiA 301, 7.2.8.3.2.1)."""


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


def begin_of(entries: Iterable[TraceEntry], sides: Sides, now_ns: int, settle_ns: int | None) -> Beginning:
    """Return how a log begins.

    A trace of virtual time begins with its rig.  Elsewhere the rig boots first, except if the log shows that its nodes
    boot; `settle_ns` is how long.  UsageError is raised by the log itself.
    """
    rest = iter(entries)
    head = list(islice(rest, HEAD))
    log = chain(head, rest)
    first_ns = min((entry.time_ns for entry in head), default=0)
    if not is_time_of_day(first_ns) and now_ns == 0 and settle_ns is None:
        begin_ns, log_ns, before_ns = 0, 0, first_ns
    else:
        if settle_ns is None:
            settle_ns = 0 if now_ns or any(map(_is_boot_up, head)) else SETTLE_NS
        begin_ns, log_ns, before_ns = now_ns + settle_ns, first_ns, settle_ns
    if before_ns < 2 * BEFORE_NS:  # the log begins with the rig
        return Beginning(log, begin_ns, log_ns, begin_ns)
    running = _running(head, sides) if sides.selection.is_master else {}
    starts = [_start(first_ns - BEFORE_NS, bus, node) for bus, node in running]
    nodes = sorted({node for _, node in running})
    heard_ns = begin_ns + first_ns - log_ns
    if not starts or begin_ns == 0:
        return Beginning(chain(starts, log), begin_ns, log_ns, heard_ns, nodes)
    return Beginning(chain(starts, log), begin_ns - BEFORE_NS, first_ns - BEFORE_NS, heard_ns - BEFORE_NS, nodes)


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


def _is_boot_up(entry: TraceEntry) -> bool:
    word = int.from_bytes(entry.data[:4], "little")
    return entry.family == "can" and word - ERROR_CONTROL in NODES and entry.data[4:] == BOOT_UP
