"""A ring as a function of time, whatever its telegrams are: a subclass says when which message is heard."""

from bisect import insort
from collections.abc import Mapping, Sequence
from random import Random
from typing import Any, Final, Generic, TypeVar

from fieldrig.bus import BusModel, Delivery
from fieldrig_bus.ring.medium import Medium

RING: Final = "ring"
"""The sender, in traces, of what the master hears."""

M = TypeVar("M")


class MediumModel(BusModel[M], Generic[M]):
    """One ring of any kind."""

    def __init__(self, medium: Medium[Any]) -> None:
        self._medium = medium
        self._due: list[Delivery[M]] = []

    def begin(self, now_ns: int, random: Random) -> None:
        self._medium.begin(now_ns, random)

    def join(self, member: str) -> None:
        self._medium.join(member)

    def leave(self, member: str) -> None:
        self._medium.leave(member)

    def power_lost(self, now_ns: int, member: str) -> None:
        self._medium.power_lost(member)

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        self._medium.listen(member, interest)

    def next_ns(self) -> int | None:
        return self._due[0].time_ns if self._due else None

    def collect(self, now_ns: int) -> list[Delivery[M]]:
        due = [delivery for delivery in self._due if delivery.time_ns <= now_ns]
        del self._due[: len(due)]
        return due

    def _schedule(self, when_ns: int, sender: str, message: M, receivers: Sequence[str]) -> None:
        observers = self._medium.observers
        delivery = Delivery(when_ns, sender, message, (*receivers, *observers) if observers else receivers)
        insort(self._due, delivery, key=lambda due: due.time_ns)

    def _note_faults(self, now_ns: int) -> None:
        """Add what faults have done in this cycle to the trace."""
        for note in self._medium.take_notes(now_ns):
            insort(self._due, Delivery[Any](now_ns, RING, note, ()), key=lambda due: due.time_ns)

    def add_fault(self, now_ns: int, fault: Mapping[str, Any]) -> int:
        return self._medium.add_fault(now_ns, fault)

    def begin_fault(self, now_ns: int, number: int) -> None:
        self._medium.begin_fault(now_ns, number)

    def clear_fault(self, now_ns: int, number: int) -> None:
        self._medium.clear_fault(number)

    def all_faults(self, now_ns: int) -> dict[int, dict[str, Any]]:
        return self._medium.all_faults(now_ns)

    def statistics(self, now_ns: int) -> dict[str, float]:
        return self._medium.statistics(now_ns)

    def conditions(self, now_ns: int) -> Mapping[str, str]:
        return self._medium.conditions(now_ns)
