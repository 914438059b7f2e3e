"""A bus model with faults on top: what leaves the model is dropped, changed or delayed before it reaches its receivers.

A family of buses says in its `Effects` what each of its faults does to a delivery; everything else is here: start, end
and repetition, numbers, counters, the notes of the trace.  While there is no fault, calls go straight to the model, so
a bus without faults costs nothing more.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from heapq import heappop, heappush
from random import Random
from typing import Any, ClassVar, Final, Generic, NamedTuple, TypeVar

from fieldrig.bus import BusModel, Delivery, Doors, ModelBus, Refusal
from fieldrig.clock import NEVER_NS
from fieldrig.faults.chance import derived
from fieldrig.faults.faults import Fault, Faults, Timed, fault_of
from fieldrig.faults.note import FaultNote

M = TypeVar("M")
_WAYS: Final = ("submit", "next_ns", "collect")


class Struck(NamedTuple, Generic[M]):
    """The effect of a fault on one delivery."""

    instead: Sequence[Delivery[M]]
    """The deliveries that arrive instead of it; a later instant delays it."""
    what: str
    """Words for the trace."""


class Effects(ABC, Generic[M]):
    """The effects of the faults of one family of buses."""

    models: ClassVar[Mapping[str, type[Timed]]]
    turns_are_struck: ClassVar[bool] = True
    """True if the faults that are on apply to what `turn` returns."""
    medium: BusModel[M]

    def __init__(self, given: Iterable[Timed] = ()) -> None:
        """`given` are the faults that the bus has from the start."""
        self.given = tuple(given)
        self._doors: list[Callable[[Doors], None]] = []
        self._refusing: dict[int, Refusal] = {}

    def on_doors(self, call: Callable[[Doors], None]) -> None:
        """Call `call` with the effects on ports, beginning with those that are on."""
        self._doors.append(call)
        for refusal in self._refusing.values():
            call(refusal)

    def refuse(self, fault: Fault[Any], is_on: bool, service: str | None = None) -> None:
        """Refuse new connections for a fault from now on, or no longer."""
        if is_on:
            fault.applied = 1
            self._refusing[fault.number] = Refusal(True, service)
        elif self._refusing.pop(fault.number, None) is None:
            return
        others = {refusal.service for refusal in self._refusing.values()}
        if is_on or not others & {None, service}:
            self.tell(Refusal(is_on, service))
        for other in others - {None} if not is_on and None not in others else ():
            self.tell(Refusal(True, other))

    def tell(self, doors: Doors) -> None:
        """Have an effect on the ports."""
        for call in self._doors:
            call(doors)

    def begin(self, medium: BusModel[M], random: Random) -> None:
        """Begin with the model under the faults."""
        self.medium, self.random = medium, random

    def check(self, settings: Any, members: Iterable[str]) -> None:
        """ValueError for a fault that this bus cannot have, given the members that have joined."""

    def asked(self, member: str, message: M) -> None:
        """Note a message that a member sends while there are faults."""

    @abstractmethod
    def fits(self, settings: Any, delivery: Delivery[M]) -> bool:
        """Return whether the fault concerns this delivery, apart from its time and chance."""

    @abstractmethod
    def strike(self, fault: Fault[Any], delivery: Delivery[M]) -> Struck[M]:
        """Return what becomes of a delivery that the fault applies to."""

    def stream_of(self, delivery: Delivery[M]) -> Hashable:
        """Return the stream of a delivery, which overtakes no earlier one of that stream; None without one."""
        return None

    def turn(self, fault: Fault[Any], now_ns: int, is_on: bool) -> list[Delivery[M]]:
        """Return what is delivered because the fault begins or ends."""
        return []

    def period_ns(self, settings: Any) -> int:
        """Return after which time `turn` is called again while the fault is on; 0 for never."""
        return 0


class _Turn(NamedTuple):
    when_ns: int
    number: int
    is_on: bool


class Disturbed(BusModel[M]):
    """A model with injected faults."""

    def __init__(self, model: BusModel[M], effects: Effects[M]) -> None:
        self.model, self.effects = model, effects
        self._faults: Faults[Fault[Any]] = Faults(Fault)
        self._members: dict[str, None] = {}
        self._due: list[tuple[int, int, Delivery[M]]] = []
        self._turns: list[_Turn] = []
        self._latest_ns: dict[Hashable, int] = {}
        """The instant of the last delivery of each stream."""
        self._ordered = self._struck = self._now_ns = 0
        self._choose_way(0)

    def begin(self, now_ns: int, random: Random) -> None:
        self._faults = Faults(Fault, derived(random))
        self.model.begin(now_ns, random)
        self.effects.begin(self.model, random)
        for settings in self.effects.given:
            self._add(now_ns, settings)

    def join(self, member: str) -> None:
        self._members[member] = None
        self.model.join(member)

    def leave(self, member: str) -> None:
        self._members.pop(member, None)
        self.model.leave(member)

    def power_lost(self, now_ns: int, member: str) -> None:
        self._members.pop(member, None)
        self.model.power_lost(now_ns, member)

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        self.model.listen(now_ns, member, interest)

    def submit(self, now_ns: int, member: str, message: M) -> None:
        self.effects.asked(member, message)
        self.model.submit(now_ns, member, message)

    def next_ns(self) -> int | None:
        next_ns = self._next_ns()
        return None if next_ns >= NEVER_NS else next_ns

    def collect(self, now_ns: int) -> list[Delivery[M]]:
        arrived: list[Delivery[M]] = []
        due = self._due
        while (next_ns := self._next_ns()) <= now_ns:
            self._now_ns = max(self._now_ns, next_ns)
            self._take_turns(next_ns)
            for delivery in self.model.collect(next_ns):
                self._strike(delivery)
            while due and due[0][0] <= next_ns:
                arrived.append(heappop(due)[2])
        self._choose_way(now_ns)
        return arrived

    def waiting(self, member: str) -> int:
        return self.model.waiting(member)

    def statistics(self, now_ns: int) -> dict[str, float]:
        figures = self.model.statistics(now_ns)
        return {**figures, "faults applied": float(self._struck)} if self._faults.given else figures

    def conditions(self, now_ns: int) -> Mapping[str, str]:
        return self.model.conditions(now_ns)

    def standing(self) -> Mapping[str, M]:
        return self.model.standing()

    @property
    def given(self) -> int:
        """The highest number of a fault so far."""
        return self._faults.given

    def on_doors(self, call: Callable[[Doors], None]) -> None:
        self.effects.on_doors(call)

    def add_fault(self, now_ns: int, fault: Mapping[str, Any], number: int | None = None) -> int:
        """Add a fault, under `number` if the caller adds it in several places."""
        settings = fault_of(fault, self.effects.models)
        self.effects.check(settings, self._members)
        return self._add(now_ns, settings, number)

    def begin_fault(self, now_ns: int, number: int) -> None:
        fault = self._faults.release(now_ns, number)
        if fault is not None:
            self._plan(fault)
            self._choose_way(now_ns)

    def clear_fault(self, now_ns: int, number: int) -> None:
        is_held = self._faults.is_held(number)
        fault = self._faults.clear(number)
        if fault.is_on(now_ns) and not is_held:
            self._turn(fault, now_ns, False)
        self._choose_way(now_ns)

    def all_faults(self, now_ns: int) -> Mapping[int, Mapping[str, Any]]:
        return self._faults.about(now_ns)

    def _add(self, now_ns: int, settings: Timed, number: int | None = None) -> int:
        fault = self._faults.add(now_ns, settings, number)
        if not self._faults.is_held(fault.number):
            self._plan(fault)
        self._choose_way(now_ns)
        return fault.number

    def _plan(self, fault: Fault[Any]) -> None:
        heappush(self._turns, _Turn(fault.start_ns, fault.number, True))
        if fault.until_ns is not None:
            heappush(self._turns, _Turn(fault.until_ns, fault.number, False))

    def _next_ns(self) -> int:
        """Return the instant of the next arrival, or of the next begin or end of a fault, or `NEVER_NS`."""
        model_ns = self.model.next_ns()
        next_ns = NEVER_NS if model_ns is None else model_ns
        if self._due:
            next_ns = min(next_ns, self._due[0][0])
        return min(next_ns, self._turns[0].when_ns) if self._turns else next_ns

    def _take_turns(self, now_ns: int) -> None:
        while self._turns and self._turns[0].when_ns <= now_ns:
            turn = heappop(self._turns)
            fault = next((fault for fault in self._faults if fault.number == turn.number), None)
            if fault is None or turn.is_on is not fault.is_on(turn.when_ns):
                continue  # it was cleared, or has ended before its time
            self._turn(fault, turn.when_ns, turn.is_on)
            period_ns = self.effects.period_ns(fault.settings) if turn.is_on else 0
            if period_ns:
                heappush(self._turns, _Turn(turn.when_ns + period_ns, fault.number, True))

    def _turn(self, fault: Fault[Any], now_ns: int, is_on: bool) -> None:
        deliver = self._strike if self.effects.turns_are_struck else self._push
        for delivery in self.effects.turn(fault, now_ns, is_on):
            # A server for clients outside, which an effect may name, is no member of a rig in virtual time without any.
            present = tuple(receiver for receiver in delivery.receivers if receiver in self._members)
            deliver(delivery._replace(receivers=present))

    def _strike(self, delivery: Delivery[M]) -> None:
        """Let the faults that are on act on a delivery, one after the other."""
        now_ns, arriving = delivery.time_ns, [delivery]
        for fault in self._faults:
            if not fault.is_on(now_ns):
                continue
            after: list[Delivery[M]] = []
            for each in arriving:
                if self.effects.fits(fault.settings, each) and fault.happens(self._struck_key()):
                    fault.applied += 1
                    self._struck += 1
                    instead, what = self.effects.strike(fault, each)
                    self._push(Delivery(now_ns, each.sender, FaultNote(fault.number, what), ()))
                    after += instead
                else:
                    after.append(each)
            arriving = after
        for each in arriving:
            stream = self.effects.stream_of(each)
            if stream is not None:
                latest_ns = self._latest_ns[stream] = max(self._latest_ns.get(stream, 0), each.time_ns)
                each = each._replace(time_ns=latest_ns)
            self._push(each)

    def _struck_key(self) -> int:
        """Return a key of chance for the next message that a fault is asked about."""
        self._ordered += 1
        return self._ordered

    def _push(self, delivery: Delivery[Any]) -> None:
        self._ordered += 1
        heappush(self._due, (max(delivery.time_ns, self._now_ns), self._ordered, delivery))

    def _choose_way(self, now_ns: int) -> None:
        """Go straight to the model while there is nothing to disturb."""
        is_plain = not self._due and not self._faults.is_any_left(now_ns)
        for way in _WAYS:
            if is_plain:
                setattr(self, way, getattr(self.model, way))
            else:
                self.__dict__.pop(way, None)
        if is_plain:
            self._turns.clear()
            self._latest_ns.clear()


def medium_of(bus: ModelBus[M]) -> BusModel[M]:
    """Return a new model of the bus, which takes the faults that its kind has."""
    effects: Effects[M] | None = bus.effects()
    return bus.model() if effects is None else Disturbed(bus.model(), effects)
