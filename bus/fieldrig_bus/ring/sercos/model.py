"""The SERCOS ring as a function of time: the instants at which the telegrams of `fibre` are heard.

A drive hears a cycle at the end of the MDT, and the master hears the ATs at the end of the last slot.
"""

import logging
from bisect import insort
from collections.abc import Iterable, Mapping, Sequence
from random import Random
from typing import Any, Final

from fieldrig.bus import BusModel, Delivery
from fieldrig_bus.ring.sercos.faults import RingFault
from fieldrig_bus.ring.sercos.fibre import Fibre
from fieldrig_bus.ring.sercos.message import Mdt, Mst, RingMessage

log = logging.getLogger(__name__)

RING: Final = "ring"
"""The sender of `Answers` in traces."""


class RingModel(BusModel[RingMessage]):
    """One SERCOS ring."""

    def __init__(
        self, order: Sequence[str], mbaud: int, bypassed: Iterable[str] = (), faults: Iterable[RingFault] = ()
    ) -> None:
        """`order` names stations; stations that it does not name follow in the order of joining."""
        self.fibre = Fibre(order, mbaud, bypassed, faults)
        self._due: list[Delivery[RingMessage]] = []
        self._over_ns = 0
        """The instant at which the last cycle that has ended is heard.  A master that begins the next one earlier can't
        overtake it."""

    def begin(self, now_ns: int, random: Random) -> None:
        self.fibre.begin(now_ns, random)

    def join(self, member: str) -> None:
        self.fibre.join(member)

    def leave(self, member: str) -> None:
        self.fibre.leave(member)

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        self.fibre.listen(member, interest)

    def submit(self, now_ns: int, member: str, message: RingMessage) -> None:
        fibre = self.fibre
        if message.__class__ is bytes:
            station = fibre.stations[member]
            if message and message[0] == station.address:  # as `lay` does, without the call
                station.at = message
            else:
                station.lay(message)
        elif member != fibre.master:
            log.debug("%s is not the master of the ring", member)
        elif isinstance(message, Mst):
            self._end_cycle(now_ns, b"")
            answers = fibre.begin_cycle(now_ns, message)
            self._schedule(fibre.until_ns, RING, answers, (member,))
        elif isinstance(message, Mdt):
            self._end_cycle(now_ns, message.data)

    def next_ns(self) -> int | None:
        return self._due[0].time_ns if self._due else None

    def collect(self, now_ns: int) -> list[Delivery[RingMessage]]:
        due = [delivery for delivery in self._due if delivery.time_ns <= now_ns]
        del self._due[: len(due)]
        return due

    def _end_cycle(self, now_ns: int, mdt: bytes) -> None:
        fibre = self.fibre
        heard = fibre.end_cycle(now_ns, mdt)
        if heard:
            self._over_ns = max(self._over_ns, fibre.until_ns)
        for cycle, names in heard:
            self._schedule(self._over_ns, fibre.master or "", cycle, names)

    def _schedule(self, when_ns: int, sender: str, message: RingMessage, receivers: Sequence[str]) -> None:
        observers = self.fibre.observers
        delivery = Delivery(when_ns, sender, message, (*receivers, *observers) if observers else receivers)
        insort(self._due, delivery, key=lambda due: due.time_ns)

    def add_fault(self, now_ns: int, fault: Mapping[str, Any]) -> int:
        return self.fibre.add_fault(now_ns, fault)

    def clear_fault(self, now_ns: int, number: int) -> None:
        self.fibre.clear_fault(number)

    def all_faults(self, now_ns: int) -> dict[int, dict[str, Any]]:
        return self.fibre.all_faults(now_ns)

    def statistics(self, now_ns: int) -> dict[str, float]:
        return self.fibre.statistics(now_ns)
