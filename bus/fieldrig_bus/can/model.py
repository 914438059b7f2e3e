"""A CAN bus as a function of time: arbitration by identifier, exact frame times, acceptance filters, error handling.

Source: ISO 11898-1:2015 (frames, medium access by arbitration, fault confinement); the operations are those of
FMI-LS-BUS (`notices` has the table).  When the bus becomes free, the frame that wins among those asked for by then
starts; it arrives with the last bit of its end of frame, and three bits later the bus is free again.  Time is kept in
ticks that divide both bit times, so no rounding adds up; a delivery's instant is rounded up to the next nanosecond.

Each member sends its frames first in, first out, as SocketCAN and most drivers do: a controller with several
mailboxes may send a lower identifier first, but then segments and PDOs overtake each other, which no protocol stack
wants.

Two ways lead through the model.  While every controller is plain and nothing is wrong, frames go the fast way, which
is all in this file.  Anything else takes the careful one in `disturbed`, until all counters are 0 again.

An unpaced bus (no bit rate) has no bits and hence no errors: there two members with one identifier send one after
the other, and nobody has to acknowledge.  A bus without a data bit rate carries FD frames all the same; their bits
take the nominal time.
"""

import logging
from collections.abc import Mapping, Sequence
from fractions import Fraction
from heapq import heapify, heappop, heappush
from math import lcm
from random import Random
from typing import Any, Final

from fieldrig.bus import BusModel, Delivery
from fieldrig.clock import S
from fieldrig_bus.can.acceptance import ERRORS, STATE, filters_of, passes, received, wants, wants_own
from fieldrig_bus.can.disturbed import Disturbed
from fieldrig_bus.can.faults import PACED, CanFault, Delay, Faults
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.given_fault import fault_of
from fieldrig_bus.can.length import INTERMISSION_BITS, classical_bits, fd_bits
from fieldrig_bus.can.member import Controller, Member, Request
from fieldrig_bus.can.notices import BitRate, CanControl, CanState, Notice

log = logging.getLogger(__name__)

LONGEST_QUEUE: Final = 10_000  # frames of one member: more than a second of a full bus at 1 Mbit/s
_MOST_CACHED: Final = 4096  # identifiers a sender
_PLAIN: Final = Controller()
UNPACED_REMEDY: Final = "give the bus one; drop, delay, duplicate and replace need none"

CanMessage = CanFrame | Notice


def priority(frame: CanFrame) -> int:
    """The arbitration field as a number: the lower one wins, dominant bits being 0.

    Base identifier 11, then RTR or SRR, IDE, identifier extension 18, RTR.  So a data frame beats a remote frame,
    and 11 bits beat 29 bits with the same base.
    """
    identifier = frame.identifier
    if frame.is_extended:
        return identifier >> 18 << 21 | 0b11 << 19 | (identifier & 0x3FFFF) << 1 | frame.is_remote
    return identifier << 21 | frame.is_remote << 20


class CanBusModel(BusModel[CanMessage]):
    """`bitrate` None: frames take no time, arbitration is between those asked for at the same instant."""

    def __init__(
        self,
        bitrate: int | None = 500_000,
        data_bitrate: int | None = None,
        controllers: Mapping[str, Controller] | None = None,
        faults: Sequence[CanFault] = (),
        *,
        is_recovering_by_itself: bool = True,
        is_acknowledged: bool = False,
    ) -> None:
        """`controllers`: of members that are not plain ones.  `is_acknowledged`: also if nobody else is there.

        ValueError for a fault that needs bit times on a bus without.
        """
        nominal = Fraction(S, bitrate) if bitrate is not None else Fraction(0)
        switched = Fraction(S, data_bitrate) if data_bitrate is not None else nominal
        self.bitrate = bitrate
        self.per_ns = lcm(nominal.denominator, switched.denominator)  # ticks
        self.nominal = int(nominal * self.per_ns)  # ticks a bit
        self.switched = int(switched * self.per_ns)
        self.intermission = INTERMISSION_BITS * self.nominal
        self.free = 0  # tick at which the bus is free after what was collected
        self.members: dict[str, Member] = {}
        self.faults = Faults()
        self.is_recovering_by_itself, self.is_acknowledged = is_recovering_by_itself, is_acknowledged
        self.load = Load(S * self.per_ns)
        self.frames = self.bits = self.lost = self.error_frames = self.arbitration_lost = 0
        self._controllers = controllers or {}
        self._joined = 0
        # The first frames of all members: those asked for when the bus becomes free, by who wins,
        # and later ones, by when.  On an idle bus the first of the later ones starts when it is asked for.
        self._ready: list[Request] = []
        self._later: list[tuple[int, Request]] = []
        self._disturbed = Disturbed(self)
        self._is_calm = True
        self._planned_faults = tuple(faults)
        for fault in faults:
            self._check_fault(fault)
            self.faults.add(0, fault)
        self._look_around(0)

    def begin(self, now_ns: int, random: Random) -> None:
        self.faults = Faults(random)
        for fault in self._planned_faults:
            self.faults.add(now_ns, fault)
        self._look_around(now_ns)

    def join(self, member: str) -> None:
        if member in self.members:
            raise ValueError(f"there is a member {member!r} already")
        self._joined += 1
        self.members[member] = Member(member, self._joined, self._controllers.get(member, _PLAIN))
        self._look_around(0)

    def leave(self, member: str) -> None:
        """A frame that is on the wire is finished, as a controller does whose processor has died."""
        leaver = self.members.pop(member)
        if self._is_calm:
            self._leave_calm_bus(leaver)
        else:
            self._disturbed.leave(leaver)
        self._forget_receivers()
        leaver.receivers.clear()
        self._look_around(0)

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        """`interest` in the words of `acceptance`; ValueError for anything else."""
        filters = filters_of(interest)
        listener = self.members[member]
        listener.filters, listener.wants_own = filters, wants_own(interest)
        listener.wants_errors, listener.wants_state = wants(interest, ERRORS), wants(interest, STATE)
        self._forget_receivers()
        if not self._is_calm:
            self._disturbed.catch_up(now_ns)

    def submit(self, now_ns: int, member: str, message: CanMessage) -> None:
        sender = self.members.get(member)
        if sender is None:
            log.debug("%s is not on the bus; dropped %r", member, message)
            return
        if type(message) is not CanFrame:
            self._control(now_ns, sender, message)
            return
        asked = now_ns * self.per_ns
        if not self._is_calm:
            if not sender.may_send:
                self.lost += 1
                sender.discarded += 1
                return
            asked += self._delayed(now_ns, sender, message)
            self._disturbed.touch()
        queue = sender.queue
        if len(queue) >= LONGEST_QUEUE:
            self.lost += 1
            log.debug("%s has %d frames waiting; dropped %r", member, len(queue), message)
            return
        if message.is_fd:
            request = self.request(asked, sender, message)
        else:
            bits = classical_bits(message)
            ticks = bits * self.nominal
            request = Request(priority(message), sender.order, asked, ticks, bits, sender, message)
        queue.append(request)
        if len(queue) == 1 and self._is_calm:
            self._offer(request)

    def request(self, asked: int, sender: Member, frame: CanFrame) -> Request:
        if frame.is_fd:
            bits, switched = fd_bits(frame)
            ticks = bits * self.nominal + switched * self.switched
            bits += switched
        else:
            bits = classical_bits(frame)
            ticks = bits * self.nominal
        return Request(priority(frame), sender.order, asked, ticks, bits, sender, frame)

    def next_ns(self) -> int | None:
        ready, later = self._ready, self._later
        if ready:
            request = ready[0]
            rank, count = request[0], len(ready)
            if count > 1 and (ready[1][0] == rank or (count > 2 and ready[2][0] == rank)) and self.nominal:
                self._go_careful()
                return self._disturbed.next_ns()
        elif later:
            request = later[0][1]
            if len(later) > 1 and self.nominal and self._is_contested():
                self._go_careful()
                return self._disturbed.next_ns()
        elif self._is_calm:
            return None
        else:
            return self._disturbed.next_ns()
        return -(-(max(request.asked, self.free) + request.ticks - self.intermission) // self.per_ns)

    def collect(self, now_ns: int) -> list[Delivery[CanMessage]]:
        deliveries: list[Delivery[CanMessage]] = []
        if not self._is_calm:
            self._collect_carefully(now_ns, deliveries)
        ready, later, per_ns = self._ready, self._later, self.per_ns
        busy = 0
        while ready or later:
            request = ready[0] if ready else later[0][1]
            rank, _, asked, ticks, bits, sender, frame = request
            free = self.free
            if asked > free:
                free = asked
            free += ticks
            end_ns = -((self.intermission - free) // per_ns)
            if end_ns > now_ns:
                break
            if ready:
                heappop(ready)
            else:
                heappop(later)
                while later and later[0][0] == asked:
                    heappush(ready, heappop(later)[1])
            if ready:
                if ready[0][0] == rank and self.nominal:
                    heappush(ready, request)
                    self._go_careful()
                    self._collect_carefully(now_ns, deliveries)
                    continue
                self.arbitration_lost += len(ready)
            self.free = free
            self.frames += 1
            self.bits += bits
            busy += ticks
            queue = sender.queue
            queue.popleft()
            if queue:
                self._offer(queue[0])
            while later and later[0][0] <= free:
                heappush(ready, heappop(later)[1])
            receivers = sender.receivers.get(rank)
            if receivers is None:
                receivers = self._find_receivers(sender, rank, received(frame))
            deliveries.append(Delivery(end_ns, sender.name, frame, receivers))
        self.load.add(now_ns * per_ns, busy)
        return deliveries

    def _collect_carefully(self, now_ns: int, deliveries: list[Delivery[CanMessage]]) -> None:
        """Until all is plain again, or nothing more has arrived by now."""
        while not self._is_calm:
            more = self._disturbed.collect(now_ns)
            if more is None:
                self._look_around(now_ns)
                return
            deliveries += more
            self._look_around(self.free // self.per_ns)

    def statistics(self, now_ns: int) -> dict[str, float]:
        """The load is that of the second before `now_ns`; states are 1 active, 2 warning, 3 passive, 4 bus-off."""
        self._disturbed.catch_up(now_ns)
        self.load.add(now_ns * self.per_ns, 0)
        members = self.members.values()
        totals = {
            "frames": float(self.frames),
            "bits": float(self.bits),
            "load_percent": round(100 * self.load.share(), 1),
            "waiting_frames": float(sum(len(member.queue) for member in members)),
            "lost_frames": float(self.lost),
            "error_frames": float(self.error_frames),
            "retransmissions": float(sum(member.retransmissions for member in members)),
            "arbitration_lost": float(self.arbitration_lost),
            "error_passive_members": float(sum(member.state is CanState.PASSIVE for member in members)),
            "bus_off_members": float(sum(member.state is CanState.BUS_OFF for member in members)),
        }
        for member in members:
            totals[f"{member.name}.state"] = float(member.state)
            totals[f"{member.name}.tec"] = float(member.tec)
            totals[f"{member.name}.rec"] = float(member.rec)
        return totals

    # faults

    def add_fault(self, now_ns: int, fault: Mapping[str, Any]) -> int:
        settings = fault_of(fault)
        self._check_fault(settings)
        self._disturbed.catch_up(now_ns)
        number = self.faults.add(now_ns, settings).number
        self._look_around(now_ns)
        self._disturbed.touch()
        return number

    def clear_fault(self, now_ns: int, number: int) -> None:
        self._disturbed.release(now_ns, self.faults.clear(number))
        self._look_around(now_ns)

    def all_faults(self, now_ns: int) -> dict[int, dict[str, Any]]:
        return self.faults.about(now_ns)

    def _check_fault(self, fault: CanFault) -> None:
        if not self.nominal and isinstance(fault, PACED):
            raise ValueError(f"{fault.what}: only on a bus with a bitrate\n{UNPACED_REMEDY}")

    def _delayed(self, now_ns: int, sender: Member, frame: CanFrame) -> int:
        """Ticks by which faults keep it back."""
        key = sender.order << 48 ^ sender.asked
        sender.asked += 1
        return self.per_ns * sum(fault.delay_ns(now_ns, sender.name, frame, key) for fault in self.faults.of(Delay))

    # the two ways

    def _look_around(self, now_ns: int) -> None:
        """Take the way that fits."""
        is_calm = (
            not self.faults.is_any_left(now_ns)
            and (not self.nominal or self.is_acknowledged or len(self.members) != 1)
            and all(member.is_plain for member in self.members.values())
            and (self._is_calm or self._disturbed.is_empty)
        )
        if is_calm and not self._is_calm:
            self._go_fast()
        elif not is_calm and self._is_calm:
            self._go_careful()
        elif not is_calm:
            self._disturbed.touch()

    def _go_careful(self) -> None:
        heads = [*self._ready, *(request for _, request in self._later)]
        self._ready.clear()
        self._later.clear()
        self._is_calm = False
        self._disturbed.enter(head.member for head in heads if self.members.get(head.member.name) is not head.member)

    def _go_fast(self) -> None:
        self._is_calm = True
        for member in self.members.values():
            if member.queue:
                self._offer(member.queue[0])

    def _control(self, now_ns: int, member: Member, message: CanMessage) -> None:
        if not isinstance(message, CanControl | BitRate):
            log.debug("%s: nobody sends %r", member.name, message)
            return
        self._disturbed.catch_up(now_ns)
        if isinstance(message, BitRate):
            is_other = self.bitrate not in (None, message.bit_per_s)
            member.skew = Fraction(self.bitrate or 0, message.bit_per_s) if is_other else None
        else:
            self._set_up(now_ns, member, message)
        self._look_around(now_ns)

    def _set_up(self, now_ns: int, member: Member, message: CanControl) -> None:
        if message.is_one_shot is not None:
            member.is_one_shot = message.is_one_shot
        if message.is_listen_only is not None:
            member.is_listen_only = message.is_listen_only
        if message.recover:
            self._disturbed.recover(now_ns, member)

    # the fast way

    def _is_contested(self) -> bool:
        """Whether two that have the same identifier would start on the idle bus at once."""
        (at, first), *rivals = self._later[:3]
        return any(when == at and rival[0] == first[0] for when, rival in rivals)

    def _next(self) -> Request | None:
        """What is on the wire, or will be next as far as is known."""
        if self._ready:
            return self._ready[0]
        return self._later[0][1] if self._later else None

    def _offer(self, request: Request) -> None:
        if request.asked <= self.free:
            heappush(self._ready, request)
        else:
            heappush(self._later, (request.asked, request))

    def _leave_calm_bus(self, leaver: Member) -> None:
        on_wire = self._next()
        leaver.queue.clear()
        if on_wire is not None and on_wire.member is leaver:
            leaver.queue.append(on_wire)
        self._ready[:] = [each for each in self._ready if each.member is not leaver or each is on_wire]
        self._later[:] = [each for each in self._later if each[1].member is not leaver or each[1] is on_wire]
        heapify(self._ready)
        heapify(self._later)

    def _find_receivers(self, sender: Member, rank: int, identifier: int) -> tuple[str, ...]:
        """Also kept for the next frame: with filters on a full bus, matching would be most of the work."""
        receivers = tuple(
            name
            for name, member in self.members.items()
            if (member.wants_own if name == sender.name else passes(identifier, member.filters))
        )
        if len(sender.receivers) >= _MOST_CACHED:
            sender.receivers.clear()
        sender.receivers[rank] = receivers
        return receivers

    def _forget_receivers(self) -> None:
        for member in self.members.values():
            member.receivers.clear()


class Load:
    """The busy share of the last second: this second's, and of the one before it what is less than a second ago."""

    __slots__ = ("_before", "_busy", "_now", "_second", "_start")

    def __init__(self, second: int) -> None:
        self._second = second  # ticks
        self._start = self._now = self._busy = self._before = 0

    def add(self, now: int, busy: int) -> None:
        if now >= self._start + self._second:
            start = now - now % self._second
            self._before = self._busy if start == self._start + self._second else 0
            self._start, self._busy = start, 0
        self._busy += busy
        self._now = now

    def share(self) -> float:
        rest = 1 - (self._now - self._start) / self._second
        return min(1.0, (self._busy + self._before * max(0.0, rest)) / self._second)
