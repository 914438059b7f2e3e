"""The step-by-step way through the CAN bus model, with everything that may be wrong on a bus.

Source: ISO 11898-1:2015, 10.9 and 12.1.4.  `confinement` plays what the nodes do from the first wrong bit on; `outcome`
says what comes of it, `settlement` applies it, and `bus_off` recovers controllers.  `model` comes here only while
something is not plain: an injected fault, an error counter that is not 0, a controller with a special setup, no member
to acknowledge, or two members that send the same identifier at once.

A step is worked out before it happens, from what is known by then, and done when its end has come.  Looking at it
changes nothing, so it does not matter how often `next_ns` is called.

A lone transmitter retransmits endlessly.  Once it is error passive, its state no longer changes.  From then on its
attempts are not steps: they are counted on demand, so that a rig in virtual time can end.
"""

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from functools import partial
from typing import Any, Final, NamedTuple

from fieldrig.bus import Delivery
from fieldrig_bus.can.bits import Place, Stream, stream
from fieldrig_bus.can.bus_off import BusOff
from fieldrig_bus.can.confinement import Node, play, played
from fieldrig_bus.can.faults import Fault
from fieldrig_bus.can.injection import ENDLESS, Injection, Injector
from fieldrig_bus.can.medium import NEVER, Medium
from fieldrig_bus.can.member import Member, Request
from fieldrig_bus.can.notices import ErrorKind
from fieldrig_bus.can.outcome import Nodes, Outcome
from fieldrig_bus.can.settlement import Settlement
from fieldrig_bus.can.skew import blind_at, seen_of

_IDLE: Final = Stream(
    b"\1" * 32, bytes([Place.UNSPECIFIED]) * 32, 0, ENDLESS, frozenset(), ENDLESS, -1, range(0)
)  # the idle bus, as a receiver sees it that takes a dominant bit for a start of frame


class Step(NamedTuple):
    """The next thing that happens on the bus."""

    end: int  # tick
    act: Callable[[], list[Delivery[Any]]]
    senders: tuple[Request, ...] = ()


class Stepwise:
    """The step-by-step way of one bus."""

    def __init__(self, medium: Medium, bus_off: BusOff) -> None:
        self._medium, self._bus_off = medium, bus_off
        self._injector = Injector(medium)
        self._settlement = Settlement(medium, self._injector, bus_off)
        self._step: Step | None = None
        self._is_planned = False
        self._lone: Member | None = None
        self._period = 0  # ticks from one attempt of a lone passive transmitter to the next

    def enter(self, departed: Iterable[Member]) -> None:
        """Take over from the fast way.  `departed` are members that left while their frame was on the wire."""
        for member in departed:
            self._depart(member)
        self.replan()

    def replan(self) -> None:
        """Discard the step that was worked out, because something has changed since."""
        self._is_planned = False

    @property
    def is_empty(self) -> bool:
        """True if nothing is under way that the fast way could not take over."""
        return not self._medium.departed and self._lone is None and self._medium.free < NEVER

    def next_ns(self) -> int | None:
        """The instant at which the next step ends; None while nothing is under way."""
        medium = self._medium
        if self._lone is not None and not self._is_alone(self._lone):
            return medium.free // medium.per_ns  # long past, so the caller collects at once, which catches up
        step = self._plan()
        return None if step is None else medium.instant_ns(step.end)

    def collect(self, now_ns: int) -> list[Delivery[Any]] | None:
        """The deliveries of the next step; None if its end has not come."""
        self.catch_up(now_ns)
        step = self._plan()
        if step is None or self._medium.instant_ns(step.end) > now_ns:
            return None
        self.replan()
        deliveries = step.act()
        if step.senders:
            senders = [request.member for request in step.senders]
            self._medium.departed = [member for member in self._medium.departed if member not in senders]
        return deliveries

    def catch_up(self, now_ns: int) -> None:
        """Count the attempts of a lone transmitter that began before now."""
        lone, medium = self._lone, self._medium
        if lone is None:
            return
        behind = now_ns * medium.per_ns - lone.resume
        attempts = max(0, -(-behind // self._period))
        medium.free += attempts * self._period
        lone.resume += attempts * self._period
        lone.count_failed(attempts)
        medium.error_frames += attempts
        medium.load.add(now_ns * medium.per_ns, attempts * self._period)
        if not self._is_alone(lone):
            self._lone = None
            self.replan()

    def leave(self, leaver: Member) -> None:
        """Remove a member; its frame that is on the wire is finished."""
        step = self._plan()
        if self._lone is leaver:
            self._lone = None
        elif step is not None and any(request.member is leaver for request in step.senders):
            while len(leaver.queue) > 1:
                leaver.queue.pop()
            self._depart(leaver)
        self.replan()

    def release(self, now_ns: int, fault: Fault) -> None:
        """Release what a cleared fault held."""
        self._injector.release(now_ns, fault)
        self.replan()

    def recover(self, now_ns: int, member: Member) -> None:
        """Recover the controller of a member from bus-off, as the member asks."""
        if self._bus_off.recover(now_ns, member):
            self.replan()

    def _depart(self, member: Member) -> None:
        member.is_gone = True
        self._medium.departed.append(member)

    # what comes next

    def _plan(self) -> Step | None:
        if not self._is_planned:
            self._step, self._is_planned = self._work_out(), True
        return self._step

    def _work_out(self) -> Step | None:
        """The earliest of a recovery, a short circuit of the idle bus, and a frame."""
        if self._medium.free >= NEVER:
            return None
        contenders = [] if self._lone is not None else self._contenders()
        start = min((at for at, _ in contenders), default=NEVER)
        short_at, _, short = min(self._injector.shorts_to_come(), key=lambda it: it[:2], default=(NEVER, 0, None))
        recovery = self._bus_off.next()
        if recovery is not None and recovery[0] <= min(start, short_at):
            tick, member = recovery
            return Step(tick, partial(self._bus_off.end, member, tick))
        if short is not None and short_at <= start:
            return self._short_of_idle_bus(short_at, short)
        if start < NEVER:
            return self._contest(start, [request for at, request in contenders if at <= start])
        return None

    def _contenders(self) -> list[tuple[int, Request]]:
        """The first frame of each member, and the tick from which it may start."""
        free = self._medium.free
        babbles = self._injector.babbles()
        contenders = []
        for member in self._medium.everybody():
            if member.may_send and (babbles or member.queue):
                request = self._injector.first_of(member, babbles) if babbles else member.queue[0]
                if request is not None:
                    contenders.append((max(request.asked, free, member.resume), request))
        return contenders

    def _stay_alone(self, lone: Member, start: int) -> None:
        """A passive transmitter got no acknowledgement in an attempt that began at `start`: no counter changes."""
        if self._is_alone(lone):
            self._lone, self._period = lone, lone.resume - start

    def _is_alone(self, sender: Member) -> bool:
        medium = self._medium
        return (
            not medium.is_acknowledged
            and not medium.departed
            and not sender.is_one_shot
            and sender.may_send
            and not medium.faults.is_any_left(medium.free // medium.per_ns)
            and all(
                member is sender or member.is_listen_only or (member.is_off and not self._bus_off.is_recovering(member))
                for member in medium.members.values()
            )
        )

    # steps

    def _short_of_idle_bus(self, at: int, fault: Fault) -> Step:
        """No member sends; the first dominant bit looks like a start of frame."""
        injection = self._injector.of_idle_bus(at, fault)
        nodes = self._receivers(())
        last = play([node for _, node in nodes], _IDLE, injection.disturbance) if nodes else 0
        return self._step_of(Outcome(at, (), (), nodes, _IDLE, injection), last)

    def _contest(self, start: int, rivals: list[Request]) -> Step:
        medium = self._medium
        lowest = min(request.priority for request in rivals)
        senders = tuple(request for request in rivals if request.priority == lowest)
        if not medium.nominal:  # without bit times there is no error; they are sent one after the other
            senders = (min(senders),)
        losers = tuple(request for request in rivals if request not in senders)
        if len(senders) == 1 and not self._injector.may_apply(start, senders[0]):
            smooth = self._smooth(start, senders, losers)
            if smooth is not None:
                return self._step_of(smooth, 0)
        rates = self._injector.wrong_rates(start)
        streams = [self._stream_of(request, rates) for request in senders]
        wire = min(streams, key=lambda each: each.bits)
        lead = streams.index(wire)  # its sender sees only its own bits
        senders = (senders[lead], *senders[:lead], *senders[lead + 1 :])
        streams = [wire, *streams[:lead], *streams[lead + 1 :]]
        injection = self._injector.of_frame(start, senders[0], wire)
        outcome = Outcome(start, senders, losers, [], wire, injection)
        if not medium.nominal:
            return self._step_of(outcome, 0)
        recessive = injection.disturbance.recessive
        if recessive.start > 0 or not recessive:  # otherwise no receiver sees the frame
            outcome.nodes = self._receivers(tuple(request.member for request in senders))
        for member, node in outcome.nodes:
            if member is not None:
                node.fails = self._failure(member, senders[0], wire, rates.get(member.name))
        own: Nodes = [
            (request.member, Node(request.member.tec, request.member.rec, each))
            for request, each in zip(senders, streams, strict=True)
        ]
        outcome.nodes = own + outcome.nodes
        is_garbled = any(request.member.name in rates for request in senders)
        return self._step_of(outcome, self._play(outcome, is_garbled))

    def _play(self, outcome: Outcome, is_garbled: bool) -> int:
        """Let the nodes act; the bit at which the last one is done."""
        wire, disturbance = outcome.wire, outcome.injection.disturbance
        if not is_garbled and not outcome.is_troubled:
            outcome.mark_all_done()
            return len(wire.bits)
        last, nodes = played(tuple(node.setup for _, node in outcome.nodes), wire, disturbance, is_garbled)
        outcome.nodes = [(member, node) for (member, _), node in zip(outcome.nodes, nodes, strict=True)]
        return last

    def _smooth(self, start: int, senders: tuple[Request, ...], losers: tuple[Request, ...]) -> Outcome | None:
        """The outcome of a frame that needs no playing, as most don't; None for any other."""
        request, medium = senders[0], self._medium
        outcome = Outcome(start, senders, losers, [], _IDLE, Injection(), is_smooth=True)
        if medium.nominal:
            sender = request.member
            others = [each for each in medium.everybody() if each.may_send and not each.is_gone and each is not sender]
            if not others and not medium.is_acknowledged:
                return None
            if request.frame.is_fd and any(each.is_classical for each in others):
                return None
            outcome.touched = [sender, *others]
        return outcome

    def _step_of(self, outcome: Outcome, last: int) -> Step:
        medium, short = self._medium, outcome.injection.short
        outcome.end = outcome.start + outcome.ticks(last, medium.nominal, medium.switched)
        if short is not None and last in outcome.injection.disturbance.dominant:
            outcome.free = self._injector.free_after(short)
        else:
            outcome.free = outcome.end + medium.intermission
        return Step(outcome.end, partial(self._act, outcome), outcome.senders)

    def _act(self, outcome: Outcome) -> list[Delivery[Any]]:
        lone = outcome.lone_sender
        deliveries = self._settlement.settle(outcome)
        if lone is not None:
            self._stay_alone(lone, outcome.start)
        return deliveries

    # nodes

    def _receivers(self, senders: tuple[Member, ...]) -> Nodes:
        """A node for each other controller on the bus; without a member it is the one that always acknowledges."""
        nodes: Nodes = [(None, Node(0, 0))] if self._medium.is_acknowledged else []
        nodes += (
            (member, Node(member.tec, member.rec))
            for member in self._medium.everybody()
            if member.may_send and not member.is_gone and member not in senders
        )
        return nodes

    def _stream_of(self, request: Request, rates: Mapping[str, Fraction]) -> Stream:
        rate = rates.get(request.member.name)
        return stream(request.frame) if rate is None else seen_of(stream(request.frame), rate)

    def _failure(
        self, receiver: Member, request: Request, wire: Stream, rate: Fraction | None
    ) -> tuple[int, ErrorKind] | None:
        """The bit at which this receiver alone sees an error, and which one."""
        if rate is not None:
            return blind_at(wire, rate)
        if receiver.is_classical and request.frame.is_fd:
            return wire.fd_format, ErrorKind.FORM
        return None
