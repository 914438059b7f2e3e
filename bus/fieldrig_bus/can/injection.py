"""Fault injection: what the injected faults of a bus do to its frames, and to the idle bus.

`faults` has their settings.  Where chance decides, it depends on the frame and the attempt, not on the order in which
the model looks at them.
"""

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Final

from fieldrig.clock import MS
from fieldrig_bus.can.bits import Stream
from fieldrig_bus.can.bus_off import SEQUENCE_BITS
from fieldrig_bus.can.confinement import FLAG_BITS, Disturbance
from fieldrig_bus.can.faults import Babble, Corrupt, Drop, Duplicate, ErrorFrame, Fault, Replace, Short, WrongBitRate
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.medium import NEVER, Medium
from fieldrig_bus.can.member import Member, Request

ENDLESS: Final = 1 << 40  # bits


@dataclass(slots=True)
class Injection:
    """The effect of the injected faults on one frame on the wire, or on the idle bus."""

    faults: list[tuple[Fault, str]] = field(default_factory=list)
    """The faults that apply, and what each one does."""
    disturbance: Disturbance = field(default_factory=Disturbance)
    frame: CanFrame | None = None
    """The frame that receivers get instead of the one that was sent."""
    deaf: frozenset[str] | None = frozenset()
    """The members that do not get the frame, or None if no member gets it."""
    is_doubled: bool = False

    def add(self, fault: Fault, frame: CanFrame, wire: Stream, key: int) -> None:
        """Apply one more fault to the frame."""
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
                self.faults.append((fault, f"bit {flipped} flipped"))
            case ErrorFrame(bit=bit) if self.disturbance.first() is None:
                first = _bit(bit, fault, wire, key)
                self.disturbance = Disturbance(dominant=range(first, first + FLAG_BITS))
                self.faults.append((fault, f"error flag from bit {first} on"))

    @property
    def short(self) -> Fault | None:
        """The short circuit among them, which is always the last one."""
        fault = self.faults[-1][0] if self.faults else None
        return fault if fault is not None and isinstance(fault.settings, Short) else None


def _bit(given: int | None, fault: Fault, wire: Stream, key: int) -> int:
    if given is not None:
        return min(given, len(wire.bits) - 1)
    return wire.arbitration + fault.chance(~key) % (wire.delimiter - wire.arbitration)


class Injector:
    """The injected faults of one bus, and which of them apply to what happens next."""

    def __init__(self, medium: Medium) -> None:
        self._medium = medium
        self._reported: set[int] = set()
        """Short circuits that hold the bus dominant and are in the trace."""
        self._due: dict[int, int] = {}
        """The tick of a babbling member's next frame, by fault."""

    # frames

    def may_apply(self, start: int, request: Request) -> bool:
        """True if a fault may concern this frame.  False is the fast path."""
        medium, member = self._medium, request.member
        now_ns, end_ns = start // medium.per_ns, (start + request.ticks) // medium.per_ns
        if member.copy or any(each.skew is not None for each in medium.everybody()):
            return True
        key = _key_of(member)
        for fault in medium.faults:
            if isinstance(fault.settings, Short | WrongBitRate):
                if fault.start_ns <= end_ns and not fault.is_over(now_ns):
                    return True
            elif fault.is_framed and fault.applies(now_ns, member.name, request.frame, key):
                return True
        return False

    def of_frame(self, start: int, request: Request, wire: Stream) -> Injection:
        """The effect of the faults on this frame, which starts at tick `start`; `wire` is the undisturbed frame."""
        medium, member = self._medium, request.member
        injection = Injection()
        key = _key_of(member)
        if not member.copy:
            kinds = (Drop, Replace, Corrupt, ErrorFrame, *((Duplicate,) if member.is_first(request) else ()))
            for fault in medium.faults.of(*kinds):
                if fault.applies(start // medium.per_ns, member.name, request.frame, key):
                    injection.add(fault, request.frame, wire, key)
        for fault in medium.faults.of(Short):
            self._add_short(injection, start, fault, wire)
        return injection

    def wrong_rates(self, start: int) -> dict[str, Fraction]:
        """Bit times of the members whose bit rate is wrong, relative to the bus.

        A fault takes precedence over the bit rate that the member has declared.
        """
        medium = self._medium
        rates = {member.name: member.skew for member in medium.everybody() if member.skew is not None}
        for _, settings in self._wrong_bit_rates(start):
            assert medium.bitrate is not None
            rates[settings.node] = Fraction(medium.bitrate, settings.bitrate)
        return {name: rate for name, rate in rates.items() if rate != 1}

    def count_wrong_rates(self, start: int, senders: Collection[str]) -> None:
        """Count the faults of a bit rate that have corrupted a frame of these members, which began at tick `start`.

        A member with a wrong bit rate corrupts what it sends and, unless it is off the bus, what the others send.
        """
        medium = self._medium
        present = {member.name for member in medium.everybody() if not member.is_gone} | {*senders}
        for fault, settings in self._wrong_bit_rates(start):
            if settings.node in present and settings.bitrate != medium.bitrate:
                fault.applied += 1

    def _wrong_bit_rates(self, start: int) -> Iterator[tuple[Fault, WrongBitRate]]:
        """The faults of a bit rate that are there at tick `start`."""
        for fault in self._medium.faults.of(WrongBitRate):
            if isinstance(fault.settings, WrongBitRate) and fault.is_on(start // self._medium.per_ns):
                yield fault, fault.settings

    def applied(self, injection: Injection, *, is_sent: bool) -> Iterable[tuple[Fault, str]]:
        """The faults that have taken effect, counted; what each one did."""
        for fault, what in injection.faults:
            if is_sent or not isinstance(fault.settings, Drop | Duplicate | Replace):
                fault.applied += 1
                if injection.disturbance.dominant and isinstance(fault.settings, Short):
                    self._reported.add(fault.number)
                yield fault, what

    # babbling members

    def babbles(self) -> Sequence[Fault]:
        """The faults that make a member babble."""
        return list(self._medium.faults.of(Babble))

    def first_of(self, member: Member, babbles: Sequence[Fault]) -> Request | None:
        """The next frame of a member: one that a fault makes it babble, or the first in its queue."""
        medium = self._medium
        waiting = member.queue[0] if member.queue else None
        for fault in babbles:
            settings = fault.settings
            if isinstance(settings, Babble) and settings.node == member.name and not member.is_gone:
                due = max(self._due.get(fault.number, 0), fault.start_ns * medium.per_ns)
                at = max(due, medium.free, member.resume)
                if not fault.is_over(at // medium.per_ns) and (
                    waiting is None or at <= max(waiting.asked, medium.free)
                ):
                    return medium.request(due, member, settings.frame())
        return waiting

    def babbled(self, member: Member, start: int) -> None:
        """A frame that a fault made this member babble was sent; it began at tick `start`."""
        medium = self._medium
        for fault in medium.faults.of(Babble):
            settings = fault.settings
            if (
                isinstance(settings, Babble)
                and settings.node == member.name
                and not fault.is_over(start // medium.per_ns)
            ):
                fault.applied += 1
                self._due[fault.number] = start + round(settings.period_ms * MS) * medium.per_ns
                return

    # short circuits

    def shorts_to_come(self) -> Iterable[tuple[int, int, Fault]]:
        """Short circuits that will find the bus idle unless a frame starts before: tick, number and fault."""
        free, per_ns = self._medium.free, self._medium.per_ns
        for fault in self._medium.faults.of(Short):
            at = max(fault.start_ns * per_ns, free)
            if self._holds(fault, "dominant") and (fault.until_ns is None or fault.until_ns * per_ns > at):
                yield at, fault.number, fault

    def of_idle_bus(self, at: int, fault: Fault) -> Injection:
        """A short circuit from tick `at` on, while no member sends."""
        held = Disturbance(dominant=self._bits_of(fault, at, 0))
        return Injection([(fault, "the wire is held dominant")], held)

    def free_after(self, short: Fault) -> int:
        """The tick from which frames may start again after this short circuit."""
        medium, until_ns = self._medium, short.until_ns
        return NEVER if until_ns is None else until_ns * medium.per_ns + SEQUENCE_BITS * medium.nominal

    def release(self, now_ns: int, fault: Fault) -> None:
        """Free the bus if the cleared fault held it."""
        medium = self._medium
        if fault.number in self._reported:
            medium.free = min(medium.free, now_ns * medium.per_ns + SEQUENCE_BITS * medium.nominal)

    def _holds(self, fault: Fault, level: str) -> bool:
        is_new = fault.number not in self._reported
        return isinstance(fault.settings, Short) and fault.settings.level == level and is_new

    def _bits_of(self, fault: Fault, at: int, first: int) -> range:
        """The bits that the short circuit holds from tick `at` on, where bit `first` begins."""
        if fault.until_ns is None:
            return range(first, ENDLESS)
        held = fault.until_ns * self._medium.per_ns - at
        return range(first, first + -(-held // self._medium.nominal))

    def _add_short(self, injection: Injection, start: int, fault: Fault, wire: Stream) -> None:
        medium = self._medium
        at = fault.start_ns * medium.per_ns
        if injection.disturbance.first() is not None or (
            fault.until_ns is not None and fault.until_ns * medium.per_ns <= max(start, at)
        ):
            return
        at = max(start, at)
        ticks = (wire.ticks(bit, medium.nominal, medium.switched) for bit in range(len(wire.bits)))
        first = next((bit for bit, tick in enumerate(ticks) if tick >= at - start), None)
        if first is None:
            return
        if self._holds(fault, "dominant"):
            injection.disturbance = Disturbance(dominant=self._bits_of(fault, at, first))
            injection.faults.append((fault, "the wire is held dominant"))
        elif self._holds(fault, "recessive"):
            injection.disturbance = Disturbance(recessive=self._bits_of(fault, at, first))
            injection.faults.append((fault, "the wire is held recessive"))


def _key_of(member: Member) -> int:
    """The key of chance: whose frame it is, which one, and which attempt."""
    return member.order << 48 ^ member.frames << 12 ^ member.attempts & 0xFFF
