"""Time as an interface: what a device may know of it, and a clock that a test or a rig moves by hand.

Time is an integer of nanoseconds.  Two clocks fulfil this contract: `VirtualClock` here, and
`fieldrig.loop.real_clock.RealClock`, which follows the system's clock.
"""

import heapq
from collections.abc import Callable
from operator import index
from typing import Protocol

US = 1_000
"""Nanoseconds of a microsecond."""
MS = 1_000_000
"""Nanoseconds of a millisecond: `10 * MS` is a time."""
S = 1_000_000_000
"""Nanoseconds of a second."""
NEVER_NS = 1 << 62
"""Later than every timer; stands for "never" where instants are compared."""


def whole_ns(time_ns: int) -> int:
    """Return the instant as an int.  TypeError for a float, as time is counted in whole nanoseconds."""
    try:
        return index(time_ns)
    except TypeError:
        raise TypeError(
            f"time is a whole number of nanoseconds, not {time_ns!r}; round(seconds * 1_000_000_000) makes one"
        ) from None


class Timer:
    """One action at one instant.  `cancel` may be called any number of times."""

    __slots__ = ("action", "owner", "when_ns")

    def __init__(self, when_ns: int, action: Callable[[], None]) -> None:
        self.when_ns = when_ns
        self.action: Callable[[], None] | None = action
        self.owner = ""
        """The device that started the timer, on a clock that several devices share."""

    def cancel(self) -> None:
        self.action = None


class Watchdog:
    """An action that is due when `due_ns` is no longer postponed.  Moving it is much cheaper than a new timer.

    Due times of `NEVER_NS` and later are never reached.
    """

    __slots__ = ("action", "due_ns")

    def __init__(self, action: Callable[[], None]) -> None:
        self.action = action
        self.due_ns = NEVER_NS
        """The instant at which `action` is called; then it becomes `NEVER_NS` until it is set again."""


class Clock(Protocol):
    """The time as a device knows it: the present instant, and calls at later ones."""

    def now_ns(self) -> int:
        """Return the instant of the event that is being handled: the same value throughout one reaction.

        Under real time it is the instant at which the message arrived or the timer was due, so that a device whose
        timers are set to `now_ns() + period` does not drift.
        """

    def call_at(self, when_ns: int, action: Callable[[], None]) -> Timer:
        """Call `action` once at `when_ns`, or as soon as possible if that is in the past.

        Actions for the same instant are called in the order of these calls.
        """

    def watch(self, action: Callable[[], None]) -> Watchdog:
        """Return a watchdog that is not due yet.  Set its `due_ns` while an event is handled, as often as needed."""

    def late_ns(self) -> int:
        """Return how long after its instant the present event is handled, as a cycle time monitor would measure it.

        It is always 0 in virtual time.
        """


class Alarm:
    """At most one action that is to come; setting it again takes the place of what was set before.

    Postponing costs nothing: the running timer is kept, and starts again if it expires too early.  A transfer postpones
    its time-out with each segment, and a timer for each of them would fill the clock's queue.
    """

    __slots__ = ("_action", "_clock", "_timer", "when_ns")

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._timer: Timer | None = None
        self._action: Callable[[], None] | None = None
        self.when_ns = NEVER_NS
        """The instant of the call; `NEVER_NS` if it is not set."""

    @property
    def is_set(self) -> bool:
        """True until the action is called."""
        return self.when_ns < NEVER_NS

    def at(self, when_ns: int | None, action: Callable[[], None]) -> None:
        """Call the action once at `when_ns`; with None, and from `NEVER_NS` on, nothing is called."""
        if when_ns is None or when_ns >= NEVER_NS:
            self.stop()
            return
        self.when_ns, self._action = when_ns, action
        if self._timer is not None:
            if self._timer.when_ns <= when_ns:
                return
            self._timer.cancel()
        self._timer = self._clock.call_at(when_ns, self._on_timer)

    def after(self, delay_ns: int, action: Callable[[], None]) -> None:
        """Call the action once, `delay_ns` after the present instant."""
        self.at(self._clock.now_ns() + delay_ns, action)

    def stop(self) -> None:
        self.when_ns, self._action = NEVER_NS, None
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _on_timer(self) -> None:
        self._timer, action = None, self._action
        if self.when_ns > self._clock.now_ns():
            self._timer = self._clock.call_at(self.when_ns, self._on_timer)
        elif action is not None:
            self.when_ns, self._action = NEVER_NS, None
            action()


class TimerQueue:
    """The timers of one clock, earliest first; equal times in the order in which they were added."""

    __slots__ = ("_asked", "heap")

    def __init__(self) -> None:
        self.heap: list[tuple[int, int, Timer]] = []
        self._asked = 0

    def add(self, when_ns: int, action: Callable[[], None]) -> Timer:
        if type(when_ns) is not int:
            when_ns = whole_ns(when_ns)
        timer = Timer(when_ns, action)
        self._asked += 1
        heapq.heappush(self.heap, (when_ns, self._asked, timer))
        return timer

    def next_ns(self) -> int | None:
        """Return the instant of the earliest timer that was not cancelled; None without one."""
        heap = self.heap
        while heap and heap[0][2].action is None:
            heapq.heappop(heap)
        return heap[0][0] if heap else None

    def pop_due(self, now_ns: int) -> Timer | None:
        """Remove and return the earliest timer due at or before `now_ns`; None without one."""
        heap = self.heap
        while heap:
            when_ns, _, timer = heap[0]
            is_cancelled = timer.action is None
            if when_ns > now_ns and not is_cancelled:
                return None
            heapq.heappop(heap)
            if not is_cancelled:
                return timer
        return None


class VirtualClock:
    """A clock that stands still until it is moved, and then calls the due actions at their instants."""

    __slots__ = ("_timers", "_watchdogs", "instant_ns")

    def __init__(self, now_ns: int = 0) -> None:
        self.instant_ns = now_ns
        """The present instant.  It may be set to any instant up to that of the next due action."""
        self._timers = TimerQueue()
        self._watchdogs: list[Watchdog] = []

    def now_ns(self) -> int:
        return self.instant_ns

    def call_at(self, when_ns: int, action: Callable[[], None]) -> Timer:
        return self._timers.add(max(when_ns, self.instant_ns), action)

    def watch(self, action: Callable[[], None]) -> Watchdog:
        watchdog = Watchdog(action)
        self._watchdogs.append(watchdog)
        return watchdog

    def late_ns(self) -> int:
        return 0

    def next_ns(self) -> int | None:
        """Return the instant of the next timer or watchdog; None without one."""
        next_ns = self._timers.next_ns()
        if not self._watchdogs:
            return next_ns
        due_ns = min((watchdog.due_ns for watchdog in self._watchdogs), default=NEVER_NS)
        return next_ns if due_ns >= NEVER_NS else due_ns if next_ns is None else min(next_ns, due_ns)

    def advance_to(self, until_ns: int) -> int:
        """Call everything due up to and including `until_ns`, and stop there.  Return the instant of the next action.

        It is `NEVER_NS` if there is none.
        """
        if self._watchdogs:
            return self._advance_watched(until_ns)
        heap = self._timers.heap  # not by its methods: this is called more often than anything else
        while heap:
            when_ns, _, timer = heap[0]
            action = timer.action
            if action is None:
                heapq.heappop(heap)
            elif when_ns > until_ns:
                break
            else:
                heapq.heappop(heap)
                self.instant_ns, timer.action = when_ns, None
                action()
        else:
            when_ns = NEVER_NS
        if until_ns > self.instant_ns:
            self.instant_ns = until_ns
        return when_ns

    def _advance_watched(self, until_ns: int) -> int:
        """Do the same with watchdogs; timers of the same instant are called first."""
        heap, watchdogs = self._timers.heap, self._watchdogs
        while True:
            while heap and heap[0][2].action is None:
                heapq.heappop(heap)
            when_ns, is_watchdog = heap[0][0] if heap else NEVER_NS, False
            for watchdog in watchdogs:
                if watchdog.due_ns < when_ns:
                    when_ns, due, is_watchdog = watchdog.due_ns, watchdog, True
            if when_ns > until_ns:
                break
            if when_ns > self.instant_ns:
                self.instant_ns = when_ns
            if is_watchdog:
                due.due_ns = NEVER_NS
                due.action()
            else:
                timer = heapq.heappop(heap)[2]
                action, timer.action = timer.action, None
                assert action is not None, "cancelled timers are gone"
                action()
        if until_ns > self.instant_ns:
            self.instant_ns = until_ns
        return when_ns
