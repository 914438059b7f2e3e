"""The events to come on a telephone network, in the order of time, and of asking within an instant."""

import heapq
from collections.abc import Callable, Iterable

from fieldrig.bus import Delivery
from fieldrig_bus.telephone.message import TelephoneMessage

Deliveries = Iterable[Delivery[TelephoneMessage]]


class Agenda:
    def __init__(self) -> None:
        self._due: list[tuple[int, int, Callable[[int], Deliveries]]] = []
        self._asked = 0
        self.passed_ns = 0
        """The last instant that was reached; nothing can be asked for an earlier one."""

    def at(self, when_ns: int, happen: Callable[[int], Deliveries]) -> None:
        """Call `happen` with the instant `when_ns`; it returns what is delivered then."""
        self._asked += 1
        heapq.heappush(self._due, (max(when_ns, self.passed_ns), self._asked, happen))

    def next_ns(self) -> int | None:
        return self._due[0][0] if self._due else None

    def take(self, now_ns: int) -> Deliveries:
        """Yield everything that is due by now."""
        while self._due and self._due[0][0] <= now_ns:
            when_ns, _, happen = heapq.heappop(self._due)
            yield from happen(when_ns)
