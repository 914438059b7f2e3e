"""A deadline that can be postponed any number of times."""

from collections.abc import Callable

from fieldrig.clock import Clock, Timer


class Deadline:
    """Calls `action` once when the deadline is reached.

    Postponing costs nothing: the running timer is kept, and starts again if it expires before the deadline.  A
    transfer postpones its time-out with each segment, and a timer for each of them would fill the clock's queue.
    """

    __slots__ = ("_action", "_clock", "_timer", "when_ns")

    def __init__(self, clock: Clock, action: Callable[[], None]) -> None:
        self._clock, self._action = clock, action
        self.when_ns: int | None = None
        self._timer: Timer | None = None

    def set(self, when_ns: int) -> None:
        self.when_ns = when_ns
        timer = self._timer
        if timer is not None:
            if timer.when_ns <= when_ns:
                return
            timer.cancel()
        self._timer = self._clock.call_at(when_ns, self._on_timer)

    def cancel(self) -> None:
        self.when_ns = None
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _on_timer(self) -> None:
        self._timer = None
        when_ns = self.when_ns
        if when_ns is None:
            return
        if when_ns > self._clock.now_ns():
            self._timer = self._clock.call_at(when_ns, self._on_timer)
            return
        self.when_ns = None
        self._action()
