"""Bus-off: how a controller enters it, and how it recovers.

Source: ISO 11898-1:2015, 12.1.4.  A controller whose transmit error counter reaches 256 is off the bus: it neither
sends nor receives, and what waits in its queue is given up.  It recovers after 128 sequences of 11 recessive bits; then
both counters are 0 and it is error active.  With `recovery: auto` recovery begins at once, and the 11 recessive bits
after the error flag are the first sequence; otherwise it begins when the member asks for it (`CanControl.recover`).
An idle bus is recessive, and each frame and each error frame ends with 11 recessive bits.
"""

from dataclasses import dataclass
from typing import Any, Final

from fieldrig.bus import Delivery
from fieldrig_bus.can.medium import Medium
from fieldrig_bus.can.member import Member
from fieldrig_bus.can.notices import CanState

SEQUENCE_BITS: Final = 11
"""Recessive bits of one sequence."""
SEQUENCES: Final = 128
"""Sequences that a controller waits for before it takes part again."""


@dataclass(slots=True)
class _Recovery:
    missing: int
    """Sequences that are still to come."""
    since: int
    """The tick from which idle bits count."""


class BusOff:
    """The controllers of one bus that are in bus-off."""

    def __init__(self, medium: Medium, *, is_automatic: bool) -> None:
        """`is_automatic`: a controller begins to recover as soon as it is off."""
        self._medium, self._is_automatic = medium, is_automatic
        self._sequence = SEQUENCE_BITS * medium.nominal  # ticks
        self._recovering: dict[Member, _Recovery] = {}

    def enter(self, member: Member) -> None:
        """Put a controller in bus-off: it drops everything that waits in its queue."""
        self._medium.lost += len(member.queue)
        member.queue.clear()
        member.attempts, member.copy = 0, False
        if self._is_automatic and not member.is_gone:
            self._recovering[member] = _Recovery(SEQUENCES - 1, 0)

    def recover(self, now_ns: int, member: Member) -> bool:
        """Begin the recovery of a member that asks for it.  False if it isn't off, or is already recovering."""
        if not member.is_off or member in self._recovering:
            return False
        self._recovering[member] = _Recovery(SEQUENCES, now_ns * self._medium.per_ns)
        return True

    def leave(self, member: Member) -> None:
        """Forget a member that has left the bus."""
        self._recovering.pop(member, None)

    def is_recovering(self, member: Member) -> bool:
        """True if the controller will take part again without being asked."""
        return member in self._recovering

    def count(self, start: int) -> None:
        """Count what a frame or error frame that began at tick `start` brings: the idle bits before it, and its end."""
        for recovery in self._recovering.values():
            idle = max(0, start - max(self._medium.free, recovery.since))
            recovery.missing = max(0, recovery.missing - idle // self._sequence - 1)

    def next(self) -> tuple[int, Member] | None:
        """The earliest recovery if the bus stays idle: its tick and member; None if no member recovers."""
        free = self._medium.free
        recoveries = [
            (max(free, recovery.since) + recovery.missing * self._sequence, member.order, member)
            for member, recovery in self._recovering.items()
        ]
        if not recoveries:
            return None
        tick, _, member = min(recoveries, key=lambda each: each[:2])
        return tick, member

    def end(self, member: Member, tick: int) -> list[Delivery[Any]]:
        """End the recovery of a controller: it takes part again from `tick` on, error active."""
        del self._recovering[member]
        member.tec = member.rec = 0
        member.resume, member.state = tick, CanState.ACTIVE
        return [member.state_delivery(self._medium.instant_ns(tick))]
