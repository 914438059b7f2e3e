"""The instant of the rig at which a log begins."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import chain, islice
from typing import Final, NamedTuple

from fieldrig.clock import MS
from fieldrig.traces.trace import TraceEntry, is_time_of_day
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.dialogues.power_on import HEAD, is_boot_up, is_sdo_answer, requested_node, rig_instant_ns
from fieldrig_devices.replay.pace import Awaited
from fieldrig_devices.replay.sides import Sides

BEFORE_NS: Final = 100 * MS
"""How long before the log its nodes are started."""
LOOK: Final = 5_000
"""Messages at the beginning of a log that show which nodes are on."""
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
    heard_ns: int
    """The instant of the rig from which on its messages are compared: before, the log does not say what it sends."""
    ready_ns: int
    """The instant of the rig at which the awaited nodes have to have booted."""
    awaited: tuple[Awaited, ...]
    """The nodes that are on when the log begins."""
    started: Sequence[int]
    """The nodes that are started before, as they are operational when the log begins."""
    buses: Collection[str]
    """The buses of the rig that the first messages with a sender are of."""


def begin_of(
    entries: Iterable[TraceEntry], sides: Sides, now_ns: int, settle_ns: int | None, *, is_prepared: bool = False
) -> Beginning:
    """Return how a log begins.

    `settle_ns` is how long the rig runs before, and 0 for a log that begins with its rig.  With None, the log says it:
    the rig runs for as long as the machine of the log was on before (`rig_instant_ns`), and its nodes are awaited.
    A rig that `is_prepared` goes on at once.  UsageError is raised by the log itself.
    """
    rest = iter(entries)
    look = list(islice(rest, LOOK))
    head = look[:HEAD]
    log = chain(look, rest)
    sides.expect_buses(head)
    buses = {bus for entry in head if entry.sender and (bus := sides.bus_of(entry)) is not None}
    first_ns = min((entry.time_ns for entry in head), default=0)
    was_on_ns = first_ns - rig_instant_ns(head)
    awaits = not is_prepared and settle_ns != 0
    if settle_ns is None and now_ns == 0 and was_on_ns == first_ns:  # the clock of the log is that of its rig
        begin_ns, log_ns, before_ns = 0, 0, first_ns
    else:
        if settle_ns is None and is_prepared:
            settle_ns = 0
        elif settle_ns is None:  # a rig of real time may run already
            settle_ns = min(was_on_ns, 2 * BEFORE_NS) if now_ns else was_on_ns
        log_ns = first_ns if is_time_of_day(first_ns) else 0
        begin_ns, before_ns = now_ns + settle_ns - first_ns + log_ns, settle_ns
    awaited = tuple(_on_before(look, sides)) if awaits else ()
    heard_ns = begin_ns + first_ns - log_ns
    if before_ns < 2 * BEFORE_NS:  # the log begins with the rig
        return Beginning(log, begin_ns, log_ns, begin_ns, begin_ns + before_ns // 2, awaited, (), buses)
    ready_ns = heard_ns - 2 * BEFORE_NS
    running = _running(head, sides) if sides.selection.is_master else {}
    starts = [_start(first_ns - BEFORE_NS, bus, node) for bus, node in running]
    nodes = sorted({node for _, node in running})
    if not starts or log_ns == 0:
        return Beginning(chain(starts, log), begin_ns, log_ns, heard_ns, ready_ns, awaited, nodes, buses)
    begin_ns, log_ns = begin_ns - BEFORE_NS, first_ns - BEFORE_NS
    return Beginning(chain(starts, log), begin_ns, log_ns, heard_ns, ready_ns, awaited, nodes, buses)


def _on_before(look: Iterable[TraceEntry], sides: Sides) -> Iterator[Awaited]:
    """Yield the nodes of the rig whose first message is no boot-up; a trace of a rig begins with its nodes."""
    was_on: dict[tuple[str, int], bool] = {}
    answers: dict[tuple[str, int], bool] = {}
    """True if the first SDO of a node has an answer: one that loses its first SDO has none."""
    requested: set[tuple[str, int]] = set()
    for entry in look:
        bus, node = sides.bus_of(entry), sides.sending_node(entry)
        if bus is None:
            continue
        if to := requested_node(entry):
            if (bus, to) in requested:
                answers.setdefault((bus, to), False)
            requested.add((bus, to))
        if node is None or node in sides.selection.nodes:
            continue
        if (bus, node) not in was_on:
            is_of_rig = bool(entry.sender) and not is_time_of_day(entry.time_ns)
            was_on[bus, node] = not is_boot_up(entry) and not is_of_rig
        if is_sdo_answer(entry) and not sides.is_mastered(bus, node):
            answers.setdefault((bus, node), True)
    return (Awaited(*key, answers.get(key, False)) for key, is_on in was_on.items() if is_on)


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
