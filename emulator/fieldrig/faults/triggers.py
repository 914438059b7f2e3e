"""The faults that wait until a point has a value, in virtual time and in a process of a rig in real time."""

from collections.abc import Callable
from typing import NamedTuple, Protocol

from fieldrig.clock import MS, Clock
from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.faults.condition import Condition

LOOK_NS = 1 * MS
"""Longest time between two looks at a condition; values such as the level of a tank change without an event."""


class Points(Protocol):
    def get(self, point: str, key: str | None = None) -> Value: ...

    def on_change(self, point: str, call: Callable[[Value], None]) -> Callable[[], None]: ...


def _nothing() -> None:
    """Do nothing."""


class _Waiting(NamedTuple):
    condition: Condition
    end: Callable[[], None]
    """Ends the watch of the point."""


class Triggers:
    """Looks at each change of the points of conditions, and once in a millisecond, and begins the faults."""

    def __init__(
        self,
        clock: Clock,
        points: Points,
        begin: Callable[[str, int], None],
        wake: Callable[[], None] = _nothing,
        tell: Callable[[], None] = _nothing,
    ) -> None:
        """`begin` is called by the clock with the bus or device, and the number of its fault.

        `wake` is called when the clock has something to do now, and `tell` before each look, where changes of points
        are not reported at their instants.
        """
        self._clock, self._points, self._begin, self._wake, self._tell = clock, points, begin, wake, tell
        self._waiting: dict[tuple[str, int], _Waiting] = {}

    def add(self, now_ns: int, where: str, number: int, condition: Condition) -> None:
        """Wait for a condition from now on.  ControlError if its point does not exist."""
        fault = where, number

        def look(value: Value) -> None:
            if fault in self._waiting and condition.is_met(value):
                self.forget(where, number)
                self._clock.call_at(self._clock.now_ns(), lambda: self._begin(where, number))
                self._wake()

        present = self._points.get(condition.point)
        self._waiting[fault] = _Waiting(condition, self._points.on_change(condition.point, look))
        if len(self._waiting) == 1:
            self._clock.call_at(now_ns + LOOK_NS, self._look)
        look(present)

    def forget(self, where: str, number: int) -> None:
        """Wait no longer for the condition of a fault, if it waits for one."""
        waiting = self._waiting.pop((where, number), None)
        if waiting is not None:
            waiting.end()

    def _look(self) -> None:
        self._tell()
        for (where, number), waiting in list(self._waiting.items()):
            try:
                value = self._points.get(waiting.condition.point)
            except ControlError:
                continue  # a device without power, or a point of a program that is not there
            if waiting.condition.is_met(value):
                self.forget(where, number)
                self._begin(where, number)
        if self._waiting:
            self._clock.call_at(self._clock.now_ns() + LOOK_NS, self._look)
