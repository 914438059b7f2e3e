"""A node's end of a PAM's ring.

It answers `Identify`, configurations and `Run`, knows the group of the node, notices when no cycle arrives, and hands
everything else to the program of the node.  Source: section 3.1 of the digest of the language, and B.2 of the manual.
The manual gives no time after which a node shows that the ring is inactive; `INACTIVE_NS` is ours, and a setting of
the nodes.
"""

import logging
from collections.abc import Callable, Iterable, Iterator
from enum import Enum, auto
from typing import Final, get_args

from fieldrig.clock import MS, Clock
from fieldrig.link import Link, patience_of
from fieldrig_bus.ring.pam.message import BROADCAST, GROUP, LONGEST_BUFFER, MOST_GROUP, Cycle, Reception, RingMessage
from fieldrig_devices.pamring import codec, frames
from fieldrig_devices.pamring.ends import NodeProgram, RingFault
from fieldrig_devices.pamring.frames import Configuration, Identify, NodeType, Order, Report, Run

log = logging.getLogger(__name__)

INACTIVE_NS: Final = 50 * MS
"""Time without a cycle after which the ring is inactive."""


class NodeState(Enum):
    """The state of a node since power-on."""

    UNKNOWN = auto()
    """It has not been identified."""
    IDENTIFIED = auto()
    """It takes items."""
    RUNNING = auto()


# A pair that is not listed changes nothing.
NEXT_STATE: Final = {
    (NodeState.UNKNOWN, Identify): NodeState.IDENTIFIED,
    (NodeState.IDENTIFIED, Identify): NodeState.IDENTIFIED,
    (NodeState.RUNNING, Identify): NodeState.IDENTIFIED,
    (NodeState.IDENTIFIED, Run): NodeState.RUNNING,
}

FAULTS: Final = {Reception.NO_CARRIER: RingFault.CARRIER, Reception.CRC_ERROR: RingFault.CRC}
ITEMS: Final = frozenset(get_args(Configuration))
BEFORE_RUN: Final = frozenset({frames.Read})
"""Orders that a node carries out before `Run`."""


class RingNode:
    """The end of one node; it is the `NodePort` of the node's program."""

    def __init__(
        self,
        clock: Clock,
        link: Link[RingMessage],
        address: int,
        node_type: NodeType,
        firmware: int,
        program: NodeProgram,
        inactive_ns: int = INACTIVE_NS,
    ) -> None:
        """`address` is 1 to 255."""
        self._clock, self._lay = clock, link.send
        self.address, self._program = address, program
        self._identity = frames.Identity(node_type, firmware)
        self.state = NodeState.UNKNOWN
        self.fault = RingFault.NONE
        self._group = 0
        self._reports: list[bytes] = []
        """Reports of the present cycle."""
        self._is_in_cycle = False
        self.end_of_cycle: Callable[[], None] | None = None
        """Called after each cycle of the ring, if it is set."""
        self._inactive_ns = inactive_ns + patience_of(link)
        self._watchdog = clock.watch(self._on_silence)
        link.on_receive(self._on_message, [["node", address]])

    def start(self) -> None:
        """Power on: the ring is inactive if no cycle arrives."""
        self._watchdog.due_ns = self._clock.now_ns() + self._inactive_ns

    def send(self, report: Report) -> None:
        """Lay a report into the buffer.  During a cycle, all of its reports go there together."""
        self._reports.append(codec.encode(report))
        if not self._is_in_cycle:
            self._lay_reports()

    def _lay_reports(self) -> None:
        reports, self._reports = self._reports, []
        for buffer in _buffers(reports):
            self._lay(buffer)

    # ---- the ring

    def _on_message(self, message: RingMessage) -> None:
        if message.__class__ is not Cycle:
            return
        if message.reception:
            self._see(FAULTS[message.reception])
            return
        self._watchdog.due_ns = self._clock.now_ns() + self._inactive_ns
        if self.fault is not RingFault.NONE:
            self._see(RingFault.NONE)
        self._is_in_cycle = True
        if message.frames:
            for contents in self._mine(message):
                self._on_frame(contents)
        self._program.cycle()
        self._is_in_cycle = False
        if self._reports:
            self._lay_reports()
        if self.end_of_cycle is not None:
            self.end_of_cycle()

    def _mine(self, cycle: Cycle) -> Iterable[bytes]:
        """The frames of a cycle that are for this node, in the order in which they were sent."""
        orders_of = cycle.by_target.get
        own = orders_of(self.address, ())
        if BROADCAST in cycle.by_target or (own and cycle.has_groups):
            return self._mine_in_order(cycle)
        return own or (orders_of(GROUP + self._group, ()) if self._group else ())

    def _mine_in_order(self, cycle: Cycle) -> Iterator[bytes]:
        """The group is looked at for each frame, because one of them may change it."""
        for target, contents in cycle.frames:
            if target in (self.address, BROADCAST) or (self._group and target == GROUP + self._group):
                yield contents

    def _on_silence(self) -> None:
        """The program reacts to the silence; but the first node behind a fault goes on showing the fault (B.2)."""
        shown = self.fault
        if shown is not RingFault.CARRIER:
            self._see(RingFault.INACTIVE)
        if shown is RingFault.CRC:
            self._see(RingFault.CRC)

    def _see(self, fault: RingFault) -> None:
        if fault is not self.fault:
            self.fault = fault
            if fault is not RingFault.NONE:
                log.info("node %d: the ring has failed: %s", self.address, fault.name.lower())
            self._program.ring(fault)

    # ---- frames

    def _on_frame(self, contents: bytes) -> None:
        try:
            order = codec.decode_order(contents)
        except ValueError as fault:
            log.debug("node %d: %s", self.address, fault)
            return
        order_class = order.__class__
        if self.state is NodeState.RUNNING and order_class not in _OWN:
            self._program.order(order)
        else:
            self._on_own(order)

    def _on_own(self, order: Order) -> None:
        order_class = type(order)
        following = NEXT_STATE.get((self.state, order_class))
        if following is not None:
            self.state = following
            self._begin()
        elif isinstance(order, frames.Group):
            self._join(order.number)
        elif order_class in ITEMS:
            self._configure(order)  # type: ignore[arg-type]  # ITEMS are the types of a Configuration
        elif order_class in BEFORE_RUN and self.state is not NodeState.UNKNOWN:
            self._program.order(order)
        else:
            log.debug("node %d is %s and cannot carry out %s", self.address, self.state.name, order)

    def _begin(self) -> None:
        if self.state is NodeState.IDENTIFIED:
            self._group = 0
            self._program.forget()
            self.send(self._identity)
        else:
            self.send(frames.Running())
            self._program.run()

    def _join(self, group: int) -> None:
        if group > MOST_GROUP:
            log.debug("node %d: there is no group %d", self.address, group)
        else:
            self._group = group

    def _configure(self, item: Configuration) -> None:
        """Items are taken between `Identify` and `Run`."""
        is_taken = self.state is NodeState.IDENTIFIED and self._program.accept(item)
        self.send(frames.Accepted(item.item) if is_taken else frames.Refused(item.item))


_OWN: Final = ITEMS | {Identify, Run, frames.Group}
"""Orders that the end carries out itself."""


def _buffers(reports: list[bytes]) -> Iterator[bytes]:
    """The reports of a cycle in pieces that the chip takes."""
    first = length = 0
    for index, report in enumerate(reports):
        length += len(report) + 1
        if length > LONGEST_BUFFER:
            yield codec.join(reports[first:index])
            first, length = index, len(report) + 1
    if reports:
        yield codec.join(reports[first:])
