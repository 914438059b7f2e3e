"""The ticks of a sampler in real time: none is lost because the host was late for it.

A device changes only in its events.  So a tick that is overdue is taken before the next event is handled, read at its
own instant: what is read then is what the device had at that instant.  Both ends of a catch-up are limited.  What is
older than `LONGEST_PAST_NS` is left out, and a sampler that would use up the host is not let do so; both are counted as
missed.
"""

import time
from collections.abc import Callable
from typing import Final

from fieldrig.clock import MS
from fieldrig.loop.real_clock import RealClock

LONGEST_PAST_NS: Final = 250 * MS
"""How far back overdue ticks are taken."""


class Ticks:
    """The multiples of a period, from the next one on."""

    def __init__(self, clock: RealClock, period_ns: int, action: Callable[[int, int], None]) -> None:
        """Call `action(instant, ticks missed before it)` for each tick that is taken."""
        self._clock, self._period_ns, self._action = clock, period_ns, action
        self.next_ns = (clock.now_ns() // period_ns + 1) * period_ns
        """The instant of the first tick that was not taken."""
        self._missed = 0

    def take_before(self, instant_ns: int) -> None:
        """Take the ticks before an instant, as nothing can change any more what they read."""
        first_ns = self.next_ns
        if first_ns >= instant_ns:
            return
        self._leave_out(instant_ns - LONGEST_PAST_NS)
        begin_ns = 0
        while self.next_ns < instant_ns:
            when_ns, missed = self.next_ns, self._missed
            self.next_ns, self._missed = when_ns + self._period_ns, 0
            self._clock.look_at(when_ns, self._action, when_ns, missed)
            if self.next_ns < instant_ns:  # in CPU time: a host that is busy with others must not cost further ticks
                begin_ns = begin_ns or time.thread_time_ns()
                if 2 * (time.thread_time_ns() - begin_ns) > instant_ns - first_ns:
                    self._leave_out(instant_ns)

    def _leave_out(self, until_ns: int) -> None:
        """Count the ticks before an instant as missed."""
        count = max(-((self.next_ns - until_ns) // self._period_ns), 0)
        self._missed += count
        self.next_ns += count * self._period_ns
