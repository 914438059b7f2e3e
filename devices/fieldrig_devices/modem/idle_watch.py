"""Hangs up when nothing was sent or received for the time of S30."""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import Alarm, Clock, S

UNIT_NS: Final = 10 * S


class IdleWatch:
    def __init__(self, clock: Clock, limit: Callable[[], int], on_idle: Callable[[], None]) -> None:
        """`limit` returns the value of S30; 0 is no limit."""
        self._clock, self._limit, self._on_idle = clock, limit, on_idle
        self.last_ns = 0
        """The instant of the last data."""
        self._timer = Alarm(self._clock)

    def start(self) -> None:
        self.last_ns = self._clock.now_ns()
        self._look()

    def stop(self) -> None:
        self._timer.stop()

    def _look(self) -> None:
        limit_ns = self._limit() * UNIT_NS
        if not limit_ns:
            return
        due_ns = self.last_ns + limit_ns
        if due_ns <= self._clock.now_ns():
            self._on_idle()
        else:
            self._timer.at(due_ns, self._look)
