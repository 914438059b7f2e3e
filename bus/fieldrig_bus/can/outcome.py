"""What comes of one frame on the wire, or of an error without a frame: counters, states, deliveries.

Source: ISO 11898-1:2015, 12.1.4 (fault confinement).  Entering bus-off, a controller gives up what waits; with
`recovery: auto` it asks to come back at once, and 11 recessive bits after the error flag are the first of the 128
times 11 that it waits for.  Each end of a frame has 11 recessive bits too.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from fieldrig.bus import Delivery
from fieldrig_bus.can.acceptance import passes, received
from fieldrig_bus.can.bits import Place, Stream, stream
from fieldrig_bus.can.confinement import (
    FLAG_BITS,
    PASSIVE,
    REC_AFTER_PASSIVE,
    SUSPEND_BITS,
    Disturbance,
    Node,
    Role,
)
from fieldrig_bus.can.faults import Corrupt, Drop, Duplicate, ErrorFrame, Fault, Replace, Short
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.length import INTERMISSION_BITS
from fieldrig_bus.can.member import Member, Request
from fieldrig_bus.can.notices import CanError, CanState, ErrorKind, FaultNote, state_of

if TYPE_CHECKING:
    from fieldrig_bus.can.disturbed import Disturbed
    from fieldrig_bus.can.model import CanBusModel

NEVER: Final = 1 << 80
"""A tick that doesn't come."""
SEQUENCE_BITS: Final = 11
"""Recessive bits in a row, of which a controller in bus-off counts `SEQUENCES`."""
SEQUENCES: Final = 128

_Nodes = list[tuple[Member | None, Node]]


@dataclass(slots=True)
class Strike:
    """What faults do to one frame on the wire, or to the idle bus."""

    start: int  # tick
    faults: list[tuple[Fault, str]] = field(default_factory=list)
    disturbance: Disturbance = field(default_factory=Disturbance)
    frame: CanFrame | None = None
    """What others get, if not what was sent."""
    deaf: frozenset[str] | None = frozenset()
    """Who doesn't get it; None: nobody does."""
    is_doubled: bool = False

    def add(self, fault: Fault, frame: CanFrame, wire: Stream, key: int) -> None:
        match fault.settings:
            case Drop(receivers=None):
                self.deaf = None
                self.faults.append((fault, "dropped"))
            case Drop(receivers=list(receivers)):
                if self.deaf is not None:
                    self.deaf |= frozenset(receivers)
                self.faults.append((fault, f"dropped for {', '.join(receivers)}"))
            case Duplicate() if not self.is_doubled:
                self.is_doubled = True
                self.faults.append((fault, "duplicated"))
            case Replace() as settings:
                self.frame = settings.of(self.frame or frame)
                self.faults.append((fault, f"data replaced, was {frame.data.hex(' ')}"))
            case Corrupt(bit=bit) if self.disturbance.first() is None:
                flipped = _bit(bit, fault, wire, key)
                self.disturbance = Disturbance(flipped=flipped)
                self.faults.append((fault, f"bit {flipped} turned over"))
            case ErrorFrame(bit=bit) if self.disturbance.first() is None:
                first = _bit(bit, fault, wire, key)
                self.disturbance = Disturbance(dominant=range(first, first + FLAG_BITS))
                self.faults.append((fault, f"error flag from bit {first} on"))


def _bit(given: int | None, fault: Fault, wire: Stream, key: int) -> int:
    if given is not None:
        return min(given, len(wire.bits) - 1)
    return wire.arbitration + fault.chance(~key) % (wire.delimiter - wire.arbitration)


@dataclass(slots=True)
class Outcome:
    model: "CanBusModel"
    start: int  # ticks
    senders: tuple[Request, ...]
    losers: tuple[Request, ...]
    nodes: _Nodes
    wire: Stream
    strike: Strike
    is_smooth: bool = False
    """Nothing is wrong; there are no nodes and no wire, but `touched`: the sender, and those that receive."""
    touched: list[Member] = field(default_factory=list)
    end: int = 0
    """When it is told."""
    free: int = 0

    @property
    def length(self) -> int:
        return self.senders[0].bits - INTERMISSION_BITS if self.is_smooth else len(self.wire.bits)

    @property
    def is_troubled(self) -> bool:
        """Whether it has to be played bit by bit."""
        receivers = [node for _, node in self.nodes if not node.is_transmitter]
        return (
            not receivers
            or self.strike.disturbance.first() is not None
            or any(node.fails is not None for node in receivers)
            or any(node.stream is not None and node.stream.bits != self.wire.bits for _, node in self.nodes)
        )

    def all_is_well(self) -> None:
        for _, node in self.nodes:
            node.role, node.done, node.is_sent = Role.DONE, self.length, node.is_transmitter

    @property
    def is_sent(self) -> bool:
        return not self.nodes or any(node.is_sent for _, node in self.nodes)

    def end_at(self, last: int) -> None:
        """The nodes were done with bit `last`."""
        model, wire = self.model, self.wire
        if self.is_smooth:
            self.end = self.start + self.senders[0].ticks - INTERMISSION_BITS * model.nominal
        elif self.senders and self.is_sent:
            self.end = self.start + wire.ticks(len(wire.bits), model.nominal, model.switched)
        else:
            seen = min((node.at for _, node in self.nodes if node.kind is not None), default=last) + 1
            seen = min(seen, last)
            self.end = self.start + wire.ticks(seen, model.nominal, model.switched) + (last - seen) * model.nominal
        self.free = self.end + INTERMISSION_BITS * model.nominal
        if last in self.strike.disturbance.dominant and self._short is not None:
            self.free = self._after(self._short)

    @property
    def _short(self) -> Fault | None:
        fault = self.strike.faults[-1][0] if self.strike.faults else None
        return fault if fault is not None and isinstance(fault.settings, Short) else None

    def _after(self, short: Fault) -> int:
        model, until_ns = self.model, short.until_ns
        return NEVER if until_ns is None else until_ns * model.per_ns + SEQUENCE_BITS * model.nominal

    def act(self, disturbed: "Disturbed") -> list[Delivery[Any]]:
        model, end_ns = self.model, -(-self.end // self.model.per_ns)
        self._count_sequences(disturbed)
        model.load.add(end_ns * model.per_ns, min(self.free, self.end + SEQUENCE_BITS * model.nominal) - self.start)
        model.free = self.free
        deliveries = [
            *self._notes(disturbed, end_ns),
            *self._lost_arbitration(end_ns),
            *self._frames(disturbed, end_ns),
        ]
        is_lone = len(self.nodes) == 1 == len(self.senders) and self.senders[0].member.tec >= PASSIVE
        if not self.is_sent:
            model.error_frames += 1
        if self.is_smooth:
            self._settle_smoothly()
        for member, node in self._members():
            self._settle(member, node)
            self.touched.append(member)
        deliveries += self._errors(end_ns)
        deliveries += self._states(end_ns)
        if is_lone and not self.is_sent:
            disturbed.stay_alone(self.senders[0].member, self.start)
        return deliveries

    def _members(self) -> Iterator[tuple[Member, Node]]:
        return ((member, node) for member, node in self.nodes if member is not None)

    def _count_sequences(self, disturbed: "Disturbed") -> None:
        """For those in bus-off: idle bits before the start, and one sequence at the end."""
        model = self.model
        for member in disturbed.everybody():
            if member.recovering is not None:
                idle = max(0, self.start - max(model.free, member.count_from))
                member.recovering = max(0, member.recovering - idle // (SEQUENCE_BITS * model.nominal) - 1)

    def _notes(self, disturbed: "Disturbed", end_ns: int) -> Iterator[Delivery[Any]]:
        struck = self.senders[0].member.name if self.senders else ""
        for fault, what in self.strike.faults:
            if self.is_sent or not isinstance(fault.settings, Drop | Duplicate | Replace):
                fault.applied += 1
                if self.strike.disturbance.dominant and isinstance(fault.settings, Short):
                    disturbed.shorts.add(fault.number)
                yield Delivery(end_ns, struck, FaultNote(fault.number, what), ())

    def _lost_arbitration(self, end_ns: int) -> Iterator[Delivery[Any]]:
        for request in self.losers:
            member = request.member
            self.model.arbitration_lost += 1
            if member.is_one_shot and member.is_first(request):
                self._give_up(member)
                yield self._error_of(end_ns, member, ErrorKind.ARBITRATION_LOST, self._lost_at(request), True, True)

    def _lost_at(self, loser: Request) -> int:
        """The first bit at which it sent a recessive one in vain."""
        pairs = zip(stream(loser.frame).bits, stream(self.senders[0].frame).bits, strict=False)
        return next((bit for bit, (ours, theirs) in enumerate(pairs) if ours > theirs), 0)

    def _give_up(self, member: Member) -> None:
        member.queue.popleft()
        member.discarded += 1
        member.attempts = 0
        self.model.lost += 1

    # frames

    def _frames(self, disturbed: "Disturbed", end_ns: int) -> Iterator[Delivery[Any]]:
        nodes = {member.order: node for member, node in self._members()}
        for request in self.senders:
            node = nodes.get(request.member.order)
            if node is None or node.is_sent:
                yield from self._deliver(request, nodes, end_ns)
                self._finish(disturbed, request)
            else:
                if not self.is_sent and any(self._is_accepted(each) for each in nodes.values()):
                    yield from self._deliver(request, nodes, end_ns)  # they had it before the error
                self._fail(request)

    def _finish(self, disturbed: "Disturbed", request: Request) -> None:
        model, member = self.model, request.member
        model.frames += 1
        model.bits += request.bits
        member.frames += 1
        member.attempts = 0
        if not member.is_first(request):
            disturbed.babbled(member, self.start)
        elif self.strike.is_doubled and request is self.senders[0]:
            member.copy = True
        else:
            member.copy = False
            member.queue.popleft()

    def _fail(self, request: Request) -> None:
        member = request.member
        if member.is_first(request) and (member.is_one_shot or member.is_gone):
            self._give_up(member)
        else:
            member.attempts += 1
            member.retransmissions += 1

    def _deliver(self, request: Request, nodes: dict[int, Node], end_ns: int) -> Iterator[Delivery[Any]]:
        sender, strike, identifier = request.member, self.strike, received(request.frame)
        is_confirmed = sender.wants_own and not sender.copy and not sender.is_gone
        is_confirmed = is_confirmed and (sender.order not in nodes or nodes[sender.order].is_sent)
        others = tuple(
            member.name
            for member in self.model.members.values()
            if member is not sender and self._hears(member, nodes) and passes(identifier, member.filters)
        )
        if strike.deaf is None:
            others = ()
        elif strike.deaf:
            others = tuple(name for name in others if name not in strike.deaf)
        if strike.frame is not None:
            yield Delivery(end_ns, sender.name, strike.frame, others)
            if is_confirmed:
                yield Delivery(end_ns, sender.name, request.frame, (sender.name,))
        elif is_confirmed:
            both = {sender.name, *others}
            yield Delivery(end_ns, sender.name, request.frame, tuple(n for n in self.model.members if n in both))
        else:
            yield Delivery(end_ns, sender.name, request.frame, others)

    def _hears(self, member: Member, nodes: dict[int, Node]) -> bool:
        node = nodes.get(member.order)
        if node is not None:
            return self._is_accepted(node)
        return self.is_sent and (not nodes or (member.is_listen_only and member.skew is None)) and not member.is_off

    # counters

    def _settle_smoothly(self) -> None:
        for member in self.touched[1:]:
            if member.rec:
                member.rec = min(member.rec - 1, REC_AFTER_PASSIVE)
        for member in self.touched[:1]:
            member.tec = max(0, member.tec - 1)
            is_suspended = max(member.tec, member.rec) >= PASSIVE
            member.resume = self.free + SUSPEND_BITS * is_suspended * self.model.nominal

    def _settle(self, member: Member, node: Node) -> None:
        nominal = self.model.nominal
        member.tec, member.rec = node.tec, node.rec
        if node.kind is not None:
            member.error_frames += 1
        if node.is_sent:
            member.tec = max(0, node.tec - 1)
        elif self.senders and self._is_accepted(node):
            member.rec = max(0, min(node.rec - 1, REC_AFTER_PASSIVE))
        if any(request.member is member for request in self.senders):
            behind = max(0, node.done - self.length) if self.is_sent else 0
            is_suspended = max(member.tec, member.rec) >= PASSIVE
            member.resume = self.free + (behind + SUSPEND_BITS * is_suspended) * nominal

    def _errors(self, end_ns: int) -> Iterator[Delivery[Any]]:
        for member, node in self._members():
            is_sender = any(request.member is member for request in self.senders)
            if node.kind is not None and (member.wants_errors or is_sender):
                is_given_up = is_sender and member.is_one_shot
                yield self._error_of(end_ns, member, node.kind, node.at, node.is_transmitter, is_given_up)

    def _error_of(
        self, end_ns: int, member: Member, kind: ErrorKind, bit: int, is_transmitter: bool, is_given_up: bool
    ) -> Delivery[Any]:
        place = Place(self.wire.places[bit]) if bit < len(self.wire.places) else Place.INTERMISSION
        identifier = received(self.senders[0].frame) if self.senders else 0
        error = CanError(kind, place, bit, identifier, is_transmitter, is_given_up, member.tec, member.rec)
        return Delivery(end_ns, member.name, error, (member.name,) if member.wants_errors else ())

    def _states(self, end_ns: int) -> Iterator[Delivery[Any]]:
        for member in self.touched:
            if not (member.tec or member.rec) and member.state is CanState.ACTIVE:
                continue  # most are so
            state = state_of(member.tec, member.rec)
            if state is not member.state:
                member.state = state
                if state is CanState.BUS_OFF:
                    self._switch_off(member)
                yield member.tell_state(end_ns)

    def _switch_off(self, member: Member) -> None:
        waiting = len(member.queue)
        member.queue.clear()
        member.discarded += waiting
        self.model.lost += waiting
        member.attempts, member.copy = 0, False
        member.recovering = SEQUENCES - 1 if self.model.is_recovering_by_itself else None

    def _is_accepted(self, node: Node) -> bool:
        """It received the whole frame.  From the last but one bit of the end of frame on that is so for good."""
        return node.kind is None and not node.is_transmitter and node.done == self.length
