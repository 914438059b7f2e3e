"""The CAN bus model paces the frames at the bit rate: `next_ns` is the end of the next frame; the hub wakes up then.

Source: ISO 11898-1:2015 (frames, medium access by arbitration, fault confinement); the operations are those of
FMI-LS-BUS (`notices` has the table).  When the bus becomes free, the frame that wins among those asked for by then
starts.  It arrives with the last bit of its end of frame, and three bits later the bus is free again.  A delivery's
instant is rounded up to the next nanosecond.  Under virtual time the rig moves to `next_ns`, in real time the hub
(`fieldrig.hub.hub`) sets its timer to it.

Each member sends its frames first in, first out, as SocketCAN and most drivers do.  A controller with several mailboxes
may send a lower identifier first, but then segments and PDOs overtake each other, which no protocol stack wants.

Two ways lead through the model.  While every controller is plain and nothing is wrong, frames go the fast way, which is
all in this file.  Everything else takes the step-by-step way in `stepwise`, until all counters are 0 again.  Both work
on the state in `medium`; `bus_off` keeps the controllers that are off the bus.

An unpaced bus (no bit rate) has no bits and hence no errors: there, two members with one identifier send one after
the other, and no acknowledgement is needed.  A bus without a data bit rate carries FD frames all the same; their bits
take the nominal time.
"""

import logging
from collections.abc import Mapping, Sequence
from fractions import Fraction
from heapq import heapify, heappop, heappush
from random import Random
from typing import Any, Final

from fieldrig.bus import BusModel, Delivery
from fieldrig.shortcuts import Shortcut
from fieldrig_bus.can.acceptance import ERRORS, STATE, filters_of, passes, received, wants, wants_own
from fieldrig_bus.can.arbitration import priority
from fieldrig_bus.can.bus_off import BusOff
from fieldrig_bus.can.codec import CanMessage
from fieldrig_bus.can.faults import PACED, CanFault, Delay, Faults
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.given_fault import fault_of
from fieldrig_bus.can.length import classical_bits
from fieldrig_bus.can.medium import Medium
from fieldrig_bus.can.member import Controller, Member, Request
from fieldrig_bus.can.notices import BitRate, CanControl, CanState
from fieldrig_bus.can.stepwise import Stepwise

log = logging.getLogger(__name__)

CALM: Final = Shortcut("can.calm", "frames on a bus without errors are not played step by step")
LONGEST_QUEUE: Final = 10_000
"""Frames of one member that may wait: more than a second of a full bus at 1 Mbit/s."""
_MOST_CACHED: Final = 4096  # identifiers per sender
_PLAIN: Final = Controller()
UNPACED_REMEDY: Final = "give the bus one; drop, delay, duplicate and replace need none"


class CanBusModel(BusModel[CanMessage]):
    """One CAN bus.  Without a bit rate frames take no time, and those asked for at the same instant arbitrate."""

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
        """`controllers` are the members whose controller is not plain; `is_acknowledged`: frames are acknowledged even
        if no other member is there.

        ValueError for a fault that needs bit times on a bus without any.
        """
        self._medium = medium = Medium(bitrate, data_bitrate, is_acknowledged=is_acknowledged)
        self._bus_off = BusOff(medium, is_automatic=is_recovering_by_itself)
        self._stepwise = Stepwise(medium, self._bus_off)
        self._per_ns, self._nominal, self._intermission = medium.per_ns, medium.nominal, medium.intermission
        self._controllers = controllers or {}
        self._joined = 0
        # The first frames of all members: those asked for when the bus becomes free, by priority, and later ones, by
        # instant.  On an idle bus the first of the later ones starts when it is asked for.
        self._ready: list[Request] = []
        self._later: list[tuple[int, Request]] = []
        self._is_calm = True
        self._may_be_calm = CALM.is_taken or not self._nominal
        self._planned_faults = tuple(faults)
        for fault in faults:
            self._check_fault(fault)
            medium.faults.add(0, fault)
        self._choose_again(0)

    @property
    def members(self) -> Mapping[str, Member]:
        """The members by name."""
        return self._medium.members

    def begin(self, now_ns: int, random: Random) -> None:
        self._medium.faults = Faults(random)
        for fault in self._planned_faults:
            self._medium.faults.add(now_ns, fault)
        self._choose_again(now_ns)

    def join(self, member: str) -> None:
        if member in self._medium.members:
            raise ValueError(f"there is a member {member!r} already")
        self._joined += 1
        self._medium.members[member] = Member(member, self._joined, self._controllers.get(member, _PLAIN))
        self._choose_again(0)

    def leave(self, member: str) -> None:
        """Remove a member.  Its frame that is on the wire is finished: a controller does so without its processor."""
        leaver = self._medium.members.pop(member)
        self._bus_off.leave(leaver)
        if self._is_calm:
            self._leave_calm_bus(leaver)
        else:
            self._stepwise.leave(leaver)
        self._forget_receivers()
        leaver.receivers.clear()
        self._choose_again(0)

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        """`interest` as `acceptance` defines it.  ValueError for anything else."""
        filters = filters_of(interest)
        listener = self._medium.members[member]
        listener.filters, listener.wants_own = filters, wants_own(interest)
        listener.wants_errors, listener.wants_state = wants(interest, ERRORS), wants(interest, STATE)
        self._forget_receivers()
        if not self._is_calm:
            self._stepwise.catch_up(now_ns)

    def submit(self, now_ns: int, member: str, message: CanMessage) -> None:
        sender = self._medium.members.get(member)
        if sender is None:
            log.debug("%s is not on the bus; dropped %r", member, message)
            return
        if type(message) is not CanFrame:
            self._control(now_ns, sender, message)
            return
        asked = now_ns * self._per_ns
        if not self._is_calm:
            if not sender.may_send:
                self._medium.lost += 1
                return
            asked += self._delayed(now_ns, sender, message)
            self._stepwise.replan()
        queue = sender.queue
        if len(queue) >= LONGEST_QUEUE:
            self._medium.lost += 1
            log.debug("%s has %d frames waiting; dropped %r", member, len(queue), message)
            return
        if message.is_fd:
            request = self._medium.request(asked, sender, message)
        else:
            bits = classical_bits(message)
            ticks = bits * self._nominal
            request = Request(priority(message), sender.order, asked, ticks, bits, sender, message)
        queue.append(request)
        if len(queue) == 1 and self._is_calm:
            self._offer(request)

    def waiting(self, member: str) -> int:
        sender = self._medium.members.get(member)
        return 0 if sender is None else len(sender.queue)

    def next_ns(self) -> int | None:
        ready, later = self._ready, self._later
        if ready:
            request = ready[0]
            rank, count = request[0], len(ready)
            if count > 1 and (ready[1][0] == rank or (count > 2 and ready[2][0] == rank)) and self._nominal:
                self._go_step_by_step()
                return self._stepwise.next_ns()
        elif later:
            request = later[0][1]
            if len(later) > 1 and self._nominal and self._is_contested():
                self._go_step_by_step()
                return self._stepwise.next_ns()
        elif self._is_calm:
            return None
        else:
            return self._stepwise.next_ns()
        return -(-(max(request.asked, self._medium.free) + request.ticks - self._intermission) // self._per_ns)

    def collect(self, now_ns: int) -> list[Delivery[CanMessage]]:
        deliveries: list[Delivery[CanMessage]] = []
        if not self._is_calm:
            self._collect_step_by_step(now_ns, deliveries)
        medium, ready, later, per_ns = self._medium, self._ready, self._later, self._per_ns
        busy = 0
        while ready or later:
            request = ready[0] if ready else later[0][1]
            rank, _, asked, ticks, bits, sender, frame = request
            free = medium.free
            if asked > free:
                free = asked
            free += ticks
            end_ns = -((self._intermission - free) // per_ns)
            if end_ns > now_ns:
                break
            if ready:
                heappop(ready)
            else:
                heappop(later)
                while later and later[0][0] == asked:
                    heappush(ready, heappop(later)[1])
            if ready:
                if ready[0][0] == rank and self._nominal:
                    heappush(ready, request)
                    self._go_step_by_step()
                    self._collect_step_by_step(now_ns, deliveries)
                    continue
                medium.arbitration_lost += len(ready)
            medium.free = free
            medium.frames += 1
            medium.bits += bits
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
        medium.load.add(now_ns * per_ns, busy)
        return deliveries

    def _collect_step_by_step(self, now_ns: int, deliveries: list[Delivery[CanMessage]]) -> None:
        """Collect until everything is plain again, or nothing more has arrived by now."""
        while not self._is_calm:
            more = self._stepwise.collect(now_ns)
            if more is None:
                self._choose_way(now_ns)
                return
            deliveries += more
            self._choose_way(self._medium.free // self._per_ns)

    def statistics(self, now_ns: int) -> dict[str, float]:
        """The load is that of the second before `now_ns`.  States are 1 active, 2 warning, 3 passive, 4 bus-off."""
        medium = self._medium
        self._stepwise.catch_up(now_ns)
        medium.load.add(now_ns * self._per_ns, 0)
        members = medium.members.values()
        totals = {
            "frames": float(medium.frames),
            "bits": float(medium.bits),
            "load_percent": round(100 * medium.load.share(), 1),
            "waiting_frames": float(sum(len(member.queue) for member in members)),
            "lost_frames": float(medium.lost),
            "error_frames": float(medium.error_frames),
            "retransmissions": float(sum(member.retransmissions for member in members)),
            "arbitration_lost": float(medium.arbitration_lost),
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
        self._stepwise.catch_up(now_ns)
        number = self._medium.faults.add(now_ns, settings).number
        self._choose_again(now_ns)
        return number

    def begin_fault(self, now_ns: int, number: int) -> None:
        self._stepwise.catch_up(now_ns)
        self._medium.faults.release(now_ns, number)
        self._choose_again(now_ns)

    def clear_fault(self, now_ns: int, number: int) -> None:
        self._stepwise.release(now_ns, self._medium.faults.clear(number))
        self._choose_again(now_ns)

    def all_faults(self, now_ns: int) -> dict[int, dict[str, Any]]:
        return self._medium.faults.about(now_ns)

    def _check_fault(self, fault: CanFault) -> None:
        if not self._nominal and isinstance(fault, PACED):
            raise ValueError(f"{fault.what}: only on a bus with a bitrate\n{UNPACED_REMEDY}")

    def _delayed(self, now_ns: int, sender: Member, frame: CanFrame) -> int:
        """Ticks by which injected faults delay the frame."""
        key = sender.order << 48 ^ sender.asked
        sender.asked += 1
        delays = self._medium.faults.of(Delay)
        return self._per_ns * sum(fault.delay_ns(now_ns, sender.name, frame, key) for fault in delays)

    # the two ways

    def _choose_way(self, now_ns: int) -> None:
        """Take the fast way if everything is plain, and the step-by-step way otherwise."""
        medium = self._medium
        is_calm = (
            self._may_be_calm
            and not medium.faults.is_any_left(now_ns)
            and (not self._nominal or medium.is_acknowledged or len(medium.members) != 1)
            and all(member.is_plain for member in medium.members.values())
            and (self._is_calm or self._stepwise.is_empty)
        )
        if is_calm and not self._is_calm:
            self._go_fast()
        elif not is_calm and self._is_calm:
            self._go_step_by_step()

    def _choose_again(self, now_ns: int) -> None:
        """Choose the way after a change from outside, which may change the next step as well."""
        self._choose_way(now_ns)
        self._stepwise.replan()

    def _go_step_by_step(self) -> None:
        heads = [*self._ready, *(request for _, request in self._later)]
        self._ready.clear()
        self._later.clear()
        self._is_calm = False
        members = self._medium.members
        self._stepwise.enter(head.member for head in heads if members.get(head.member.name) is not head.member)

    def _go_fast(self) -> None:
        self._is_calm = True
        for member in self._medium.members.values():
            if member.queue:
                self._offer(member.queue[0])

    def _control(self, now_ns: int, member: Member, message: CanMessage) -> None:
        if not isinstance(message, CanControl | BitRate):
            log.debug("%s: no member sends %r", member.name, message)
            return
        self._stepwise.catch_up(now_ns)
        if isinstance(message, BitRate):
            is_other = self._medium.bitrate not in (None, message.bit_per_s)
            member.skew = Fraction(self._medium.bitrate or 0, message.bit_per_s) if is_other else None
        else:
            self._set_up(now_ns, member, message)
        self._choose_again(now_ns)

    def _set_up(self, now_ns: int, member: Member, message: CanControl) -> None:
        if message.is_one_shot is not None:
            member.is_one_shot = message.is_one_shot
        if message.is_listen_only is not None:
            member.is_listen_only = message.is_listen_only
        if message.recover:
            self._stepwise.recover(now_ns, member)

    # the fast way

    def _is_contested(self) -> bool:
        """True if two members would start a frame with the same identifier on the idle bus at once."""
        (at, first), *rivals = self._later[:3]
        return any(when == at and rival[0] == first[0] for when, rival in rivals)

    def _next(self) -> Request | None:
        """The frame that is on the wire, or will be next as far as is known."""
        if self._ready:
            return self._ready[0]
        return self._later[0][1] if self._later else None

    def _offer(self, request: Request) -> None:
        if request.asked <= self._medium.free:
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
        """The receivers of a frame, kept for the next one: matching filters would be most of the work on a full bus."""
        receivers = tuple(
            name
            for name, member in self._medium.members.items()
            if (member.wants_own if name == sender.name else passes(identifier, member.filters))
        )
        if len(sender.receivers) >= _MOST_CACHED:
            sender.receivers.clear()
        sender.receivers[rank] = receivers
        return receivers

    def _forget_receivers(self) -> None:
        for member in self._medium.members.values():
            member.receivers.clear()
