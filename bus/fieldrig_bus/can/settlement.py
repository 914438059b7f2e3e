"""Settlement: carries an outcome over to queues, error counters, states, statistics, and deliveries."""

from collections.abc import Iterator
from typing import Any

from fieldrig.bus import Delivery
from fieldrig_bus.can.acceptance import passes, received
from fieldrig_bus.can.bus_off import SEQUENCE_BITS, BusOff
from fieldrig_bus.can.confinement import Node
from fieldrig_bus.can.error_counters import REC_AFTER_PASSIVE, state_of
from fieldrig_bus.can.faults import Drop, Replace
from fieldrig_bus.can.injection import Injection, Injector
from fieldrig_bus.can.medium import Medium
from fieldrig_bus.can.member import Member, Request
from fieldrig_bus.can.notices import CanError, CanState, ErrorKind, FaultNote
from fieldrig_bus.can.outcome import Outcome, suspension


class Settlement:
    """Carries outcomes over to one bus."""

    def __init__(self, medium: Medium, injector: Injector, bus_off: BusOff) -> None:
        self._medium, self._injector, self._bus_off = medium, injector, bus_off

    def settle(self, outcome: Outcome) -> list[Delivery[Any]]:
        """Change everything that the outcome changes.  Returns what the members and the trace get."""
        medium, end_ns = self._medium, self._medium.instant_ns(outcome.end)
        self._bus_off.count(outcome.start)
        busy = min(outcome.free, outcome.end + SEQUENCE_BITS * medium.nominal) - outcome.start
        medium.load.add(end_ns * medium.per_ns, busy)
        medium.free = outcome.free
        deliveries = [
            *self._fault_notes(outcome, end_ns),
            *self._lost_arbitration(outcome, end_ns),
            *self._frames(outcome, end_ns),
        ]
        if not outcome.is_sent:
            medium.error_frames += 1
            if not outcome.injection.faults:
                self._injector.count_wrong_rates(outcome.start, [each.member.name for each in outcome.senders])
        if outcome.is_smooth:
            self._count_smooth(outcome)
        for member, node in outcome.members():
            self._count(outcome, member, node)
            outcome.touched.append(member)
        deliveries += self._errors(outcome, end_ns)
        deliveries += self._states(outcome, end_ns)
        return deliveries

    def _fault_notes(self, outcome: Outcome, end_ns: int) -> Iterator[Delivery[Any]]:
        concerned = outcome.senders[0].member.name if outcome.senders else ""
        for fault, what in self._injector.applied(outcome.injection, is_sent=outcome.is_sent):
            yield Delivery(end_ns, concerned, FaultNote(fault.number, what), ())
        for request in outcome.senders[1:]:
            own = self._of_copy(outcome, request)
            own.faults = [each for each in own.faults if each not in outcome.injection.faults]
            for fault, what in self._injector.applied(own, is_sent=outcome.is_sent):
                yield Delivery(end_ns, request.member.name, FaultNote(fault.number, what), ())

    def _of_copy(self, outcome: Outcome, request: Request) -> Injection:
        """Return which faults concern the messages of one sender, where several send the same bits at once."""
        if request is outcome.senders[0]:
            return outcome.injection
        own = self._injector.of_frame(outcome.start, request, outcome.wire)
        own.faults = [each for each in own.faults if isinstance(each[0].settings, Drop | Replace)]
        return own

    def _lost_arbitration(self, outcome: Outcome, end_ns: int) -> Iterator[Delivery[Any]]:
        for request in outcome.losers:
            member = request.member
            self._medium.arbitration_lost += 1
            if member.is_one_shot and member.is_first(request):
                self._give_up(member)
                bit = outcome.lost_at(request)
                error = outcome.error(member, ErrorKind.ARBITRATION_LOST, bit, is_transmitter=True, is_given_up=True)
                yield _error_delivery(end_ns, member, error)

    def _give_up(self, member: Member) -> None:
        member.give_up()
        self._medium.lost += 1

    # frames

    def _frames(self, outcome: Outcome, end_ns: int) -> Iterator[Delivery[Any]]:
        nodes = {member.order: node for member, node in outcome.members()}
        for request in outcome.senders:
            node = nodes.get(request.member.order)
            if node is None or node.is_sent:
                yield from self._deliver(outcome, request, nodes, end_ns)
                self._finish(outcome, request)
            else:
                if not outcome.is_sent and any(outcome.is_accepted(each) for each in nodes.values()):
                    yield from self._deliver(outcome, request, nodes, end_ns)  # they had it before the error
                self._fail(request)

    def _finish(self, outcome: Outcome, request: Request) -> None:
        medium, member = self._medium, request.member
        medium.frames += 1
        medium.bits += request.bits
        member.frames += 1
        member.attempts = 0
        if not member.is_first(request):
            self._injector.babbled(member, outcome.start)
        elif outcome.injection.is_doubled and request is outcome.senders[0]:
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

    def _deliver(
        self, outcome: Outcome, request: Request, nodes: dict[int, Node], end_ns: int
    ) -> Iterator[Delivery[Any]]:
        sender, injection, members = request.member, self._of_copy(outcome, request), self._medium.members
        identifier = received(request.frame)
        is_confirmed = sender.wants_own and not sender.copy and not sender.is_gone
        is_confirmed = is_confirmed and (sender.order not in nodes or nodes[sender.order].is_sent)
        others = tuple(
            member.name
            for member in members.values()
            if member is not sender
            and outcome.hears(member, nodes.get(member.order))
            and passes(identifier, member.filters)
        )
        if injection.deaf is None:
            others = ()
        elif injection.deaf:
            others = tuple(name for name in others if name not in injection.deaf)
        if injection.frame is not None:
            yield Delivery(end_ns, sender.name, injection.frame, others)
            if is_confirmed:
                yield Delivery(end_ns, sender.name, request.frame, (sender.name,))
        elif is_confirmed:
            both = {sender.name, *others}
            yield Delivery(end_ns, sender.name, request.frame, tuple(name for name in members if name in both))
        else:
            yield Delivery(end_ns, sender.name, request.frame, others)

    # error counters

    def _count_smooth(self, outcome: Outcome) -> None:
        for member in outcome.touched[1:]:
            if member.rec:
                member.rec = min(member.rec - 1, REC_AFTER_PASSIVE)
        for member in outcome.touched[:1]:
            member.tec = max(0, member.tec - 1)
            member.resume = outcome.free + suspension(member.tec, member.rec) * self._medium.nominal

    def _count(self, outcome: Outcome, member: Member, node: Node) -> None:
        counters = member.tec, member.rec = outcome.counters(node)
        if node.kind is not None:
            member.error_frames += 1
        if outcome.is_sender(member):
            member.resume = outcome.free + outcome.bits_to_wait(node, counters) * self._medium.nominal

    def _errors(self, outcome: Outcome, end_ns: int) -> Iterator[Delivery[Any]]:
        for member, node in outcome.members():
            is_sender = outcome.is_sender(member)
            if node.kind is not None and (member.wants_errors or is_sender):
                is_given_up = is_sender and member.is_one_shot
                error = outcome.error(
                    member, node.kind, node.at, is_transmitter=node.is_transmitter, is_given_up=is_given_up
                )
                yield _error_delivery(end_ns, member, error)

    def _states(self, outcome: Outcome, end_ns: int) -> Iterator[Delivery[Any]]:
        for member in outcome.touched:
            if not (member.tec or member.rec) and member.state is CanState.ACTIVE:
                continue  # most members are active with counters of 0
            state = state_of(member.tec, member.rec)
            if state is not member.state:
                member.state = state
                if state is CanState.BUS_OFF:
                    self._bus_off.enter(member)
                yield member.state_delivery(end_ns)


def _error_delivery(end_ns: int, member: Member, error: CanError) -> Delivery[Any]:
    return Delivery(end_ns, member.name, error, (member.name,) if member.wants_errors else ())
