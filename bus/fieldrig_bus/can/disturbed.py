"""The careful way through the bus model: one step after the other, with all that may be wrong with it.

Source: ISO 11898-1:2015, 10.9 and 12.1.4; what the nodes do from the first wrong bit on is played by `confinement`,
what comes of it is in `outcome`.  `model` comes here only while something is not plain: a fault, a counter that is not
0, a controller that is set up in a special way, nobody to acknowledge, two members with one identifier at once.

A step is worked out before it happens, from what is known by then, and done when its end has come.  Looking at it
changes nothing, so it doesn't matter how often one asks for `next_ns`.

A lone transmitter retransmits for ever.  Once it is error passive nothing about it changes any more; then its attempts
are no steps, they are counted when somebody asks, and a rig in virtual time comes to its end.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from fieldrig.bus import Delivery
from fieldrig.clock import MS
from fieldrig_bus.can.bits import Place, Stream, stream
from fieldrig_bus.can.confinement import Disturbance, Node, play, undisturbed
from fieldrig_bus.can.faults import Babble, Corrupt, Drop, Duplicate, ErrorFrame, Fault, Replace, Short, WrongBitRate
from fieldrig_bus.can.member import Member, Request
from fieldrig_bus.can.notices import CanState, ErrorKind
from fieldrig_bus.can.outcome import NEVER, SEQUENCE_BITS, SEQUENCES, Outcome, Strike
from fieldrig_bus.can.skew import blind_at, seen_of

if TYPE_CHECKING:
    from fieldrig_bus.can.model import CanBusModel

_ENDLESS: Final = 1 << 40  # bits
_IDLE: Final = Stream(
    b"\1" * 32, bytes([Place.UNSPECIFIED]) * 32, 0, _ENDLESS, frozenset(), _ENDLESS, -1, range(0)
)  # as a receiver sees it that takes a dominant bit for a start of frame


class Step(NamedTuple):
    end: int  # tick
    act: Callable[[], list[Delivery[Any]]]
    senders: tuple[Request, ...] = ()


class Disturbed:
    def __init__(self, model: "CanBusModel") -> None:
        self._model = model
        self._step: Step | None = None
        self._is_planned = False
        self._ghosts: list[Member] = []  # they left with their frame on the wire
        self._lone: Member | None = None
        self._period = 0  # ticks from one attempt of a lone passive transmitter to the next
        self.shorts: set[int] = set()
        """The faults that hold the bus dominant and were told."""
        self.due: dict[int, int] = {}
        """Tick of a babbling member's next frame, by fault."""

    def enter(self, ghosts: Iterable[Member]) -> None:
        for ghost in ghosts:
            ghost.is_gone = True
            self._ghosts.append(ghost)
        self.touch()

    def touch(self) -> None:
        """Something is other than when the step was worked out."""
        self._is_planned = False

    @property
    def is_empty(self) -> bool:
        return not self._ghosts and self._lone is None and self._model.free < NEVER

    def next_ns(self) -> int | None:
        model = self._model
        if self._lone is not None and not self._is_alone(self._lone):
            return model.free // model.per_ns  # long past: whoever asks collects at once, which catches up
        step = self._plan()
        return None if step is None else -(-step.end // model.per_ns)

    def collect(self, now_ns: int) -> list[Delivery[Any]] | None:
        """What the next step brings; None if its end has not come."""
        self.catch_up(now_ns)
        step = self._plan()
        if step is None or -(-step.end // self._model.per_ns) > now_ns:
            return None
        self.touch()
        deliveries = step.act()
        if step.senders:
            self._ghosts = [ghost for ghost in self._ghosts if all(ghost is not each.member for each in step.senders)]
        return deliveries

    def catch_up(self, now_ns: int) -> None:
        """Count the attempts of a lone transmitter that began before now."""
        lone, model = self._lone, self._model
        if lone is None:
            return
        behind = now_ns * model.per_ns - lone.resume
        attempts = max(0, -(-behind // self._period))
        model.free += attempts * self._period
        lone.resume += attempts * self._period
        lone.count_errors(attempts)
        model.error_frames += attempts
        model.load.add(now_ns * model.per_ns, attempts * self._period)
        if not self._is_alone(lone):
            self._lone = None
            self.touch()

    def stay_alone(self, lone: Member, start: int) -> None:
        """A passive transmitter got no acknowledge in an attempt that began at `start`; nothing changes by it."""
        if self._is_alone(lone):
            self._lone, self._period = lone, lone.resume - start

    def leave(self, leaver: Member) -> None:
        """What is on the wire is finished."""
        step = self._plan()
        if self._lone is leaver:
            self._lone = None
        elif step is not None and any(request.member is leaver for request in step.senders):
            while len(leaver.queue) > 1:
                leaver.queue.pop()
            leaver.is_gone = True
            self._ghosts.append(leaver)
        self.touch()

    def release(self, now_ns: int, fault: Fault) -> None:
        """The fault was taken away."""
        model = self._model
        if fault.number in self.shorts:
            model.free = min(model.free, now_ns * model.per_ns + SEQUENCE_BITS * model.nominal)
        self.touch()

    def babbled(self, member: Member, start: int) -> None:
        model = self._model
        for fault in model.faults.of(Babble):
            settings = fault.settings
            if (
                isinstance(settings, Babble)
                and settings.node == member.name
                and not fault.is_over(start // model.per_ns)
            ):
                fault.applied += 1
                self.due[fault.number] = start + round(settings.period_ms * MS) * model.per_ns
                return

    def recover(self, now_ns: int, member: Member) -> None:
        if member.is_off and member.recovering is None:
            member.recovering, member.count_from = SEQUENCES, now_ns * self._model.per_ns
            self.touch()

    # what comes next

    def everybody(self) -> Iterable[Member]:
        return (*self._model.members.values(), *self._ghosts)

    def _plan(self) -> Step | None:
        if not self._is_planned:
            self._step, self._is_planned = self._work_out(), True
        return self._step

    def _work_out(self) -> Step | None:
        """The earliest of a recovery, a short circuit of the idle bus, and a frame."""
        if self._model.free >= NEVER:
            return None
        contenders = [] if self._lone is not None else self._contenders()
        start = min((at for at, _ in contenders), default=NEVER)
        short_at, _, short = min(self._shorts_to_come(), key=lambda it: it[:2], default=(NEVER, 0, None))
        back_at, _, back = min(self._recoveries(), key=lambda it: it[:2], default=(NEVER, 0, None))
        if back is not None and back_at <= min(start, short_at):
            return Step(back_at, partial(self._recovered, back, back_at))
        if short is not None and short_at <= start:
            return self._short_of_idle_bus(short_at, short)
        if start < NEVER:
            return self._contest(start, [request for at, request in contenders if at <= start])
        return None

    def _contenders(self) -> list[tuple[int, Request]]:
        """The first frame of everybody, and the tick from which it may start."""
        free = self._model.free
        babbles = list(self._model.faults.of(Babble))
        found = []
        for member in self.everybody():
            if member.may_send and (babbles or member.queue):
                request = self._first_of(member, babbles) if babbles else member.queue[0]
                if request is not None:
                    found.append((max(request.asked, free, member.resume), request))
        return found

    def _first_of(self, member: Member, babbles: Sequence[Fault]) -> Request | None:
        model = self._model
        waiting = member.queue[0] if member.queue else None
        for fault in babbles:
            settings = fault.settings
            if isinstance(settings, Babble) and settings.node == member.name and not member.is_gone:
                due = max(self.due.get(fault.number, 0), fault.start_ns * model.per_ns)
                at = max(due, model.free, member.resume)
                if not fault.is_over(at // model.per_ns) and (waiting is None or at <= max(waiting.asked, model.free)):
                    return model.request(due, member, settings.frame())
        return waiting

    def _recoveries(self) -> Iterable[tuple[int, int, Member]]:
        model = self._model
        for member in self.everybody():
            if member.recovering is not None:
                missing = member.recovering * SEQUENCE_BITS * model.nominal
                yield max(model.free, member.count_from) + missing, member.order, member

    def _recovered(self, member: Member, tick: int) -> list[Delivery[Any]]:
        member.tec = member.rec = 0
        member.recovering, member.resume, member.state = None, tick, CanState.ACTIVE
        return [member.tell_state(-(-tick // self._model.per_ns))]

    def _is_alone(self, sender: Member) -> bool:
        model = self._model
        return (
            not model.is_acknowledged
            and not self._ghosts
            and not sender.is_one_shot
            and sender.may_send
            and not model.faults.is_any_left(model.free // model.per_ns)
            and all(
                member is sender or member.is_listen_only or (member.is_off and member.recovering is None)
                for member in model.members.values()
            )
        )

    # short circuits

    def _shorts_to_come(self) -> Iterable[tuple[int, int, Fault]]:
        """Those that will find the bus idle, if nobody sends before."""
        free, per_ns = self._model.free, self._model.per_ns
        for fault in self._model.faults.of(Short):
            at = max(fault.start_ns * per_ns, free)
            if self._holds(fault, "dominant") and (fault.until_ns is None or fault.until_ns * per_ns > at):
                yield at, fault.number, fault

    def _holds(self, fault: Fault, level: str) -> bool:
        return isinstance(fault.settings, Short) and fault.settings.level == level and fault.number not in self.shorts

    def _bits_of(self, fault: Fault, at: int, first: int) -> range:
        """The bits that it holds from tick `at` on, which is that of bit `first`."""
        if fault.until_ns is None:
            return range(first, _ENDLESS)
        held = fault.until_ns * self._model.per_ns - at
        return range(first, first + -(-held // self._model.nominal))

    def _short_of_idle_bus(self, at: int, fault: Fault) -> Step:
        """Nobody sends; the first dominant bit looks like a start of frame."""
        strike = Strike(at, [(fault, "the wire is held dominant")])
        strike.disturbance = Disturbance(dominant=self._bits_of(fault, at, 0))
        nodes = self._receivers(())
        last = play([node for _, node in nodes], _IDLE, strike.disturbance) if nodes else 0
        return self._step_of(Outcome(self._model, at, (), (), nodes, _IDLE, strike), last)

    # frames

    def _contest(self, start: int, rivals: list[Request]) -> Step:
        model = self._model
        lowest = min(request.priority for request in rivals)
        senders = tuple(request for request in rivals if request.priority == lowest)
        if not model.nominal:  # without bit times there is no error; they go one after the other
            senders = (min(senders),)
        losers = tuple(request for request in rivals if request not in senders)
        if len(senders) == 1 and not self._is_struck(start, senders[0]):
            smooth = self._smooth(start, senders, losers)
            if smooth is not None:
                return self._step_of(smooth, 0)
        rates = self._wrong_rates(start)
        streams = [self._stream_of(request, rates) for request in senders]
        wire = min(streams, key=lambda each: each.bits)
        lead = streams.index(wire)  # its sender sees no bit but its own
        senders = (senders[lead], *senders[:lead], *senders[lead + 1 :])
        streams = [wire, *streams[:lead], *streams[lead + 1 :]]
        strike = self._strike(start, senders[0], wire)
        outcome = Outcome(model, start, senders, losers, [], wire, strike)
        if not model.nominal:
            return self._step_of(outcome, 0)
        if strike.disturbance.recessive.start > 0 or not strike.disturbance.recessive:  # else nobody sees the frame
            outcome.nodes = self._receivers(tuple(request.member for request in senders))
        for member, node in outcome.nodes:
            if member is not None:
                node.fails = self._trouble(member, senders[0], wire, rates.get(member.name))
        own: list[tuple[Member | None, Node]] = [
            (request.member, Node(request.member.tec, request.member.rec, each))
            for request, each in zip(senders, streams, strict=True)
        ]
        outcome.nodes = own + outcome.nodes
        is_garbled = any(request.member.name in rates for request in senders)
        if not is_garbled and not outcome.is_troubled:
            outcome.all_is_well()
            return self._step_of(outcome, len(wire.bits))
        nodes = [node for _, node in outcome.nodes]
        if strike.disturbance.first() is not None:
            return self._step_of(outcome, play(nodes, wire, strike.disturbance, is_garbled=is_garbled))
        last, played = undisturbed(tuple(node.setup for node in nodes), wire, is_garbled)
        outcome.nodes = [(member, node) for (member, _), node in zip(outcome.nodes, played, strict=True)]
        return self._step_of(outcome, last)

    def _smooth(self, start: int, senders: tuple[Request, ...], losers: tuple[Request, ...]) -> Outcome | None:
        """Of most frames nothing needs to be played; None of the others."""
        request, model = senders[0], self._model
        outcome = Outcome(model, start, senders, losers, [], _IDLE, Strike(start), is_smooth=True)
        if model.nominal:
            sender = request.member
            others = [each for each in self.everybody() if each.may_send and not each.is_gone and each is not sender]
            if not others and not model.is_acknowledged:
                return None
            if request.frame.is_fd and any(each.is_classical for each in others):
                return None
            outcome.touched = [sender, *others]
        return outcome

    def _is_struck(self, start: int, request: Request) -> bool:
        """Whether a fault may have to do with this frame.  To say no is the quick way."""
        model, member = self._model, request.member
        now_ns, end_ns = start // model.per_ns, (start + request.ticks) // model.per_ns
        if member.copy or any(each.skew is not None for each in self.everybody()):
            return True
        key = _key_of(member)
        for fault in model.faults:
            if isinstance(fault.settings, Short | WrongBitRate):
                if fault.start_ns <= end_ns and not fault.is_over(now_ns):
                    return True
            elif fault.is_framed and fault.strikes(now_ns, member.name, request.frame, key):
                return True
        return False

    def _step_of(self, outcome: Outcome, last: int) -> Step:
        outcome.end_at(last)
        return Step(outcome.end, partial(outcome.act, self), outcome.senders)

    def _receivers(self, senders: tuple[Member, ...]) -> list[tuple[Member | None, Node]]:
        """A node for everybody else on the bus; without a member it is the one that always acknowledges."""
        nodes: list[tuple[Member | None, Node]] = [(None, Node(0, 0))] if self._model.is_acknowledged else []
        nodes += (
            (member, Node(member.tec, member.rec))
            for member in self.everybody()
            if member.may_send and not member.is_gone and member not in senders
        )
        return nodes

    def _wrong_rates(self, start: int) -> dict[str, Fraction]:
        """The bit times of members that are wrong, in those of the bus.  A fault goes before what a member says."""
        model = self._model
        rates = {member.name: member.skew for member in self.everybody() if member.skew is not None}
        for fault in model.faults.of(WrongBitRate):
            settings = fault.settings
            if isinstance(settings, WrongBitRate) and fault.is_on(start // model.per_ns):
                assert model.bitrate is not None
                rates[settings.node] = Fraction(model.bitrate, settings.bitrate)
        return {name: rate for name, rate in rates.items() if rate != 1}

    def _stream_of(self, request: Request, rates: Mapping[str, Fraction]) -> Stream:
        rate = rates.get(request.member.name)
        return stream(request.frame) if rate is None else seen_of(stream(request.frame), rate)

    def _trouble(
        self, receiver: Member, request: Request, wire: Stream, rate: Fraction | None
    ) -> tuple[int, ErrorKind] | None:
        """Where this receiver alone sees an error."""
        if rate is not None:
            return blind_at(wire, rate)
        if receiver.is_classical and request.frame.is_fd:
            return wire.fd_format, ErrorKind.FORM
        return None

    # faults of frames

    def _strike(self, start: int, request: Request, wire: Stream) -> Strike:
        model, member = self._model, request.member
        strike = Strike(start)
        key = _key_of(member)
        if not member.copy:
            kinds = (Drop, Replace, Corrupt, ErrorFrame, *((Duplicate,) if member.is_first(request) else ()))
            for fault in model.faults.of(*kinds):
                if fault.strikes(start // model.per_ns, member.name, request.frame, key):
                    strike.add(fault, request.frame, wire, key)
        for fault in model.faults.of(Short):
            self._add_short(strike, start, fault, wire)
        return strike

    def _add_short(self, strike: Strike, start: int, fault: Fault, wire: Stream) -> None:
        model = self._model
        at = fault.start_ns * model.per_ns
        if strike.disturbance.first() is not None or (
            fault.until_ns is not None and fault.until_ns * model.per_ns <= max(start, at)
        ):
            return
        at = max(start, at)
        first = next((bit for bit in range(len(wire.bits)) if self._tick_of(wire, bit) >= at - start), None)
        if first is None:
            return
        if self._holds(fault, "dominant"):
            strike.disturbance = Disturbance(dominant=self._bits_of(fault, at, first))
            strike.faults.append((fault, "the wire is held dominant"))
        elif self._holds(fault, "recessive"):
            strike.disturbance = Disturbance(recessive=self._bits_of(fault, at, first))
            strike.faults.append((fault, "the wire is held recessive"))

    def _tick_of(self, wire: Stream, bit: int) -> int:
        return wire.ticks(bit, self._model.nominal, self._model.switched)


def _key_of(member: Member) -> int:
    """What chance goes by: whose frame, which one, which attempt."""
    return member.order << 48 ^ member.frames << 12 ^ member.attempts & 0xFFF
