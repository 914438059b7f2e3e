"""A CAN bus as a function of time: arbitration by identifier, exact frame times, acceptance filters.

Source: ISO 11898-1:2015 (frames, medium access by arbitration).  When the bus becomes free, the frame that wins among
those asked for by then starts; it arrives with the last bit of its end of frame, and three bits later the bus is free
again.  Time is kept in ticks that divide both bit times, so no rounding adds up; a delivery's instant is rounded up
to the next nanosecond.

Each member sends its frames first in, first out, as SocketCAN and most drivers do: a controller with several
mailboxes may send a lower identifier first, but then segments and PDOs overtake each other, which no protocol stack
wants.  Two members that send the same identifier at once collide on a real bus; here the one that joined first wins.

Left out on purpose: error frames, error counters, bus-off and missing acknowledge (an issue of their own).  Hence a
bus carries FD frames whether or not it has a data bit rate; without one their bits take the nominal time.
"""

import logging
from collections import deque
from collections.abc import Sequence
from fractions import Fraction
from heapq import heapify, heappop, heappush
from math import lcm
from typing import Any, Final, NamedTuple

from fieldrig.bus import BusModel, Delivery
from fieldrig.clock import S
from fieldrig_bus.can.acceptance import Filters, filters_of, passes, received, wants_own
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.length import INTERMISSION_BITS, classical_bits, fd_bits

log = logging.getLogger(__name__)

LONGEST_QUEUE: Final = 10_000  # frames of one member: more than a second of a full bus at 1 Mbit/s
_MOST_CACHED: Final = 4096  # identifiers a sender


def priority(frame: CanFrame) -> int:
    """The arbitration field as a number: the lower one wins, dominant bits being 0.

    Base identifier 11, then RTR or SRR, IDE, identifier extension 18, RTR.  So a data frame beats a remote frame,
    and 11 bits beat 29 bits with the same base.
    """
    identifier = frame.identifier
    if frame.is_extended:
        return identifier >> 18 << 21 | 0b11 << 19 | (identifier & 0x3FFFF) << 1 | frame.is_remote
    return identifier << 21 | frame.is_remote << 20


class _Member:
    __slots__ = ("filters", "name", "order", "queue", "receivers", "wants_own")

    def __init__(self, name: str, order: int) -> None:
        self.name, self.order = name, order
        self.filters: Filters | None = ()
        self.wants_own = False
        self.queue: deque[_Request] = deque()
        self.receivers: dict[int, tuple[str, ...]] = {}  # who hears this member, by identifier


class _Request(NamedTuple):
    """A frame that waits.  Of one member only the first takes part, so the first two fields never tie."""

    priority: int
    order: int
    asked: int  # tick
    ticks: int
    bits: int
    member: _Member
    frame: CanFrame


class CanBusModel(BusModel[CanFrame]):
    """`bitrate` None: frames take no time, arbitration is between those asked for at the same instant."""

    def __init__(self, bitrate: int | None = 500_000, data_bitrate: int | None = None) -> None:
        nominal = Fraction(S, bitrate) if bitrate is not None else Fraction(0)
        switched = Fraction(S, data_bitrate) if data_bitrate is not None else nominal
        self._ticks_per_ns = lcm(nominal.denominator, switched.denominator)
        self._nominal = int(nominal * self._ticks_per_ns)  # ticks a bit
        self._switched = int(switched * self._ticks_per_ns)
        self._intermission = INTERMISSION_BITS * self._nominal
        self._free = 0  # tick at which the bus is free after what was collected
        self._members: dict[str, _Member] = {}
        self._joined = 0
        # The first frames of all members: those asked for when the bus becomes free, by who wins,
        # and later ones, by when.  On an idle bus the first of the later ones starts when it is asked for.
        self._ready: list[_Request] = []
        self._later: list[tuple[int, _Request]] = []
        self._load = _Load(S * self._ticks_per_ns)
        self._frames = self._bits = self._lost = 0

    def join(self, member: str) -> None:
        if member in self._members:
            raise ValueError(f"there is a member {member!r} already")
        self._joined += 1
        self._members[member] = _Member(member, self._joined)

    def leave(self, member: str) -> None:
        """A frame that is on the wire is finished, as a controller does whose processor has died."""
        leaver = self._members.pop(member)
        on_wire = self._next()
        leaver.queue.clear()
        if on_wire is not None and on_wire.member is leaver:
            leaver.queue.append(on_wire)
        self._ready = [each for each in self._ready if each.member is not leaver or each is on_wire]
        self._later = [each for each in self._later if each[1].member is not leaver or each[1] is on_wire]
        heapify(self._ready)
        heapify(self._later)
        self._forget_receivers()
        leaver.receivers.clear()

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        """`interest` in the words of `acceptance`; ValueError for anything else."""
        filters = filters_of(interest)
        listener = self._members[member]
        listener.filters, listener.wants_own = filters, wants_own(interest)
        self._forget_receivers()

    def submit(self, now_ns: int, member: str, message: CanFrame) -> None:
        sender = self._members.get(member)
        if sender is None:
            log.debug("%s is not on the bus; dropped %r", member, message)
            return
        queue = sender.queue
        if len(queue) >= LONGEST_QUEUE:
            self._lost += 1
            log.debug("%s has %d frames waiting; dropped %r", member, len(queue), message)
            return
        if message.is_fd:
            bits, switched = fd_bits(message)
            ticks = bits * self._nominal + switched * self._switched
            bits += switched
        else:
            bits = classical_bits(message)
            ticks = bits * self._nominal
        request = _Request(priority(message), sender.order, now_ns * self._ticks_per_ns, ticks, bits, sender, message)
        queue.append(request)
        if len(queue) == 1:
            self._offer(request)

    def next_ns(self) -> int | None:
        request = self._next()
        if request is None:
            return None
        return -(-(max(request.asked, self._free) + request.ticks - self._intermission) // self._ticks_per_ns)

    def collect(self, now_ns: int) -> list[Delivery[CanFrame]]:
        deliveries: list[Delivery[CanFrame]] = []
        ready, later, per_ns = self._ready, self._later, self._ticks_per_ns
        busy = 0
        while ready or later:
            request = ready[0] if ready else later[0][1]
            _, _, asked, ticks, bits, sender, frame = request
            free = self._free
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
            self._free = free
            self._frames += 1
            self._bits += bits
            busy += ticks
            queue = sender.queue
            queue.popleft()
            if queue:
                self._offer(queue[0])
            while later and later[0][0] <= free:
                heappush(ready, heappop(later)[1])
            receivers = sender.receivers.get(received(frame))
            if receivers is None:
                receivers = self._find_receivers(sender, received(frame))
            deliveries.append(Delivery(end_ns, sender.name, frame, receivers))
        self._load.add(now_ns * per_ns, busy)
        return deliveries

    def statistics(self, now_ns: int) -> dict[str, float]:
        """The load is that of the second before `now_ns`."""
        self._load.add(now_ns * self._ticks_per_ns, 0)
        return {
            "frames": float(self._frames),
            "bits": float(self._bits),
            "load_percent": round(100 * self._load.share(), 1),
            "waiting_frames": float(sum(len(member.queue) for member in self._members.values())),
            "lost_frames": float(self._lost),
        }

    def _next(self) -> _Request | None:
        """What is on the wire, or will be next as far as is known."""
        if self._ready:
            return self._ready[0]
        return self._later[0][1] if self._later else None

    def _offer(self, request: _Request) -> None:
        if request.asked <= self._free:
            heappush(self._ready, request)
        else:
            heappush(self._later, (request.asked, request))

    def _find_receivers(self, sender: _Member, identifier: int) -> tuple[str, ...]:
        """Also kept for the next frame: with filters on a full bus, matching would be most of the work."""
        receivers = tuple(
            name
            for name, member in self._members.items()
            if (member.wants_own if name == sender.name else passes(identifier, member.filters))
        )
        if len(sender.receivers) >= _MOST_CACHED:
            sender.receivers.clear()
        sender.receivers[identifier] = receivers
        return receivers

    def _forget_receivers(self) -> None:
        for member in self._members.values():
            member.receivers.clear()


class _Load:
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
