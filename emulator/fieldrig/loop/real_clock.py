"""The system's clock as a Clock: CLOCK_MONOTONIC, accurate to some tens of microseconds by a timerfd.

A device takes no time: while an event is handled, `now_ns()` is the instant of that event, not of the CPU.  So a
periodic timer does not drift, and a message carries the instant at which it was sent; a hub uses that to hide the time
between processes behind frame times.
"""

import asyncio
import time
from collections.abc import Callable
from typing import Any, TypeVar

from fieldrig.clock import MS, Alarm, Timer, TimerQueue, Watchdog
from fieldrig.loop import timerfd
from fieldrig.system.host_lateness import NOTED_NS, Lateness
from fieldrig.text.exception_notes import blame

STALL_NS = 20 * MS
"""An event handled later than this counts as happening now, so that a host that stood still does not replay its past.
"""

LONGEST_TURN_NS = 5 * MS
"""Longest work without a pause.

A medium with more traffic than the host can carry in time must not block everything else.
"""

T = TypeVar("T")

_ARMED_LATER = -1  # while timers are being called: arm once, when all are done


class _RealWatchdog(Watchdog):
    """A watchdog under real time: an alarm, which costs nothing when it is postponed."""

    __slots__ = ("_alarm",)

    def __init__(self, clock: "RealClock | DeviceClock", action: Callable[[], None]) -> None:
        self._alarm = Alarm(clock)
        super().__init__(action)

    @property
    def due_ns(self) -> int:
        return self._alarm.when_ns

    @due_ns.setter
    def due_ns(self, due_ns: int) -> None:
        self._alarm.at(due_ns, self.action)


class RealClock:
    """The clock of one event loop.  Call it in the loop's thread, or with the lock of a `ThreadedLoop`."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._timers = TimerQueue()
        self._instant_ns: int | None = None
        self._latest_ns = 0  # time never runs backwards between two events
        self._armed_ns: int | None = None
        self._fired = 0
        self._late_ns = 0
        self._worst_ns = 0
        self.on_event: Callable[[], None] | None = None
        """Called after each event, if it is set."""
        self.before_event: Callable[[int], None] | None = None
        """Called with the instant of an event before it is handled, if it is set, to look at what was until then."""
        self.after_timer: Callable[[], None] | None = None
        """Called after each timer, still at its instant, if it is set."""
        self.host = Lateness()
        """How late the host has been lately."""
        self._fd: timerfd.TimerFd | None = None
        self._handle: asyncio.TimerHandle | None = None
        if timerfd.is_available():
            self._fd = timerfd.TimerFd()
            loop.add_reader(self._fd.fd, self._on_readable)

    def now_ns(self) -> int:
        instant_ns = self._instant_ns
        return time.monotonic_ns() if instant_ns is None else instant_ns

    def call_at(self, when_ns: int, action: Callable[[], None]) -> Timer:
        timer = self._timers.add(when_ns, action)
        if self._armed_ns is None or when_ns < self._armed_ns:
            self._arm(when_ns)
        return timer

    def cancel_timers_of(self, device: str) -> None:
        """Cancel every timer of one device, which has lost its power."""
        for _, _, timer in self._timers.heap:
            if timer.owner == device:
                timer.cancel()

    def watch(self, action: Callable[[], None]) -> Watchdog:
        return _RealWatchdog(self, action)

    def late_ns(self) -> int:
        return 0 if self._instant_ns is None else time.monotonic_ns() - self._instant_ns

    def handle(self, action: Callable[..., None], *arguments: Any) -> None:
        """Call `action` as an event of its own that happens now."""
        self.handle_at(time.monotonic_ns(), action, *arguments)

    def handle_at(self, instant_ns: int, action: Callable[..., None], *arguments: Any) -> None:
        """Call `action` as an event that happened at `instant_ns`, which `now_ns` then returns unless the host stood
        still.

        Inside another event (a link within this process) it is part of that event.
        """
        if self._instant_ns is not None:
            action(*arguments)
            return
        now_ns = time.monotonic_ns()
        if not now_ns - STALL_NS < instant_ns <= now_ns:
            instant_ns = now_ns
        if instant_ns < self._latest_ns:
            instant_ns = self._latest_ns
        if self.before_event is not None:
            self.before_event(instant_ns)
        self._instant_ns = self._latest_ns = instant_ns
        try:
            action(*arguments)
        finally:
            self._instant_ns = None
        if self.on_event is not None:
            self.on_event()

    def look_at(self, instant_ns: int, read: Callable[..., T], *arguments: Any) -> T:
        """Do the same as `look` at `instant_ns`, or at that of the latest event, whichever is later."""
        if self._instant_ns is not None:
            return read(*arguments)
        self._instant_ns = max(instant_ns, self._latest_ns)
        try:
            return read(*arguments)
        finally:
            self._instant_ns = None

    def look(self, read: Callable[..., T], *arguments: Any) -> T:
        """Return the result of `read`, called with `now_ns()` at the present.  Unlike `handle` this is not an event.

        A timer that is overdue keeps its instant, so being read changes nothing that a device does later.
        """
        if self._instant_ns is not None:
            return read(*arguments)
        self._instant_ns = max(time.monotonic_ns(), self._latest_ns)
        try:
            return read(*arguments)
        finally:
            self._instant_ns = None

    def lateness(self) -> dict[str, float]:
        """Return how late timers were since the last call: `timers`, `mean_us`, `worst_us`."""
        fired, mean_us = self._fired, self._late_ns / 1e3 / max(self._fired, 1)
        report = {"timers": float(fired), "mean_us": mean_us, "worst_us": self._worst_ns / 1e3}
        self._fired = self._late_ns = self._worst_ns = 0
        return report

    def close(self) -> None:
        if self._fd is not None:
            self._loop.remove_reader(self._fd.fd)
            self._fd.close()
            self._fd = None
        if self._handle is not None:
            self._handle.cancel()

    def _arm(self, when_ns: int) -> None:
        self._armed_ns = when_ns
        if self._fd is not None:
            self._fd.arm(when_ns)
            return
        if self._handle is not None:
            self._handle.cancel()
        self._handle = self._loop.call_later(max(when_ns - time.monotonic_ns(), 0) / 1e9, self._on_due)

    def _on_readable(self) -> None:
        if self._fd is not None:
            self._fd.clear()
            self._on_due()

    def _on_due(self) -> None:
        self._armed_ns = _ARMED_LATER
        pop_due = self._timers.pop_due
        now_ns, owner = time.monotonic_ns(), ""
        give_up_ns = now_ns + LONGEST_TURN_NS
        try:
            while (timer := pop_due(now_ns)) is not None:
                late_ns = now_ns - timer.when_ns
                self._fired += 1
                self._late_ns += late_ns
                self._worst_ns = max(self._worst_ns, late_ns)
                if late_ns >= NOTED_NS:
                    self.host.note(late_ns)
                action, timer.action = timer.action, None
                if action is not None:
                    instant_ns = max(timer.when_ns if late_ns < STALL_NS else now_ns, self._latest_ns)
                    if self.before_event is not None:
                        owner, self._instant_ns = "", None
                        self.before_event(instant_ns)
                    self._instant_ns = self._latest_ns = instant_ns
                    owner = timer.owner
                    action()
                    if self.after_timer is not None:
                        self.after_timer()
                    if self.on_event is not None:
                        self.on_event()
                    if time.monotonic_ns() > give_up_ns:
                        break  # what is still due is called after the loop has looked at its sockets
        except Exception as fault:
            if owner:
                blame(fault, owner, None, self._latest_ns)
            raise
        finally:
            self._instant_ns = self._armed_ns = None
            next_ns = self._timers.next_ns()
            if next_ns is not None:
                self._arm(next_ns)


class DeviceClock:
    """The clock of a process for one of its devices.

    It marks timers with the device, for a note on their exceptions.
    """

    __slots__ = ("_clock", "_device", "late_ns", "now_ns")

    def __init__(self, clock: RealClock, device: str) -> None:
        self._clock, self._device = clock, device
        self.now_ns, self.late_ns = clock.now_ns, clock.late_ns

    def call_at(self, when_ns: int, action: Callable[[], None]) -> Timer:
        timer = self._clock.call_at(when_ns, action)
        timer.owner = self._device
        return timer

    def watch(self, action: Callable[[], None]) -> Watchdog:
        return _RealWatchdog(self, action)
