"""How a process shares its time between outsiders and everything else in it, such as the cycle of a ring.

Whatever handles bytes of outsiders reports the time that it took.  After a slice of that time, all readers of the
process wait: until the timers that are due have had their turn, or, where a cycle has to be kept, until the outsiders
have had no more than their share.  Then they go on in turn, first the one whose latest turn was the longest ago: a
client that asks now and then hardly waits for those that always want something, and a new one waits for a turn of each
of them.

A device does part of the work later, when it is the turn of its emulated processor, so beside a cycle the readers also
wait while the whole process takes too much of a core.  What outsiders send meanwhile stays in the buffers of the
system, whose flow control stops them.
"""

import time
from typing import Final, Protocol

from fieldrig.clock import MS, US, Alarm, Clock

SLICE_NS: Final = 2 * MS
"""Time that outsiders may take without a pause."""
SLICE_BESIDE_A_CYCLE_NS: Final = 400 * US
"""The same in a process with the end of a ring, whose cycle may be 1 ms."""
SHARE_BESIDE_A_CYCLE: Final = 0.25
"""Their share of the time there; `tests/bench/flood.py` measures what the ring keeps."""
MOST_BUSY: Final = 0.6
"""The part of a core that such a process takes at most while outsiders want something."""
LOOK_AGAIN_NS: Final = 2 * MS
"""Time after which a busy process is looked at again."""
LONGEST_PAUSE_NS: Final = 20 * MS
"""After this, outsiders have a slice even if the process is busy with other things all the time."""

TURNS_AT_ONCE: Final = 4
"""Readers that have their turn before other events have theirs."""
LONGEST_WAIT_NS: Final = 100 * MS
"""Outsiders wait no longer than this for something of theirs that took long."""


class Reader(Protocol):
    """Reads what outsiders send."""

    def take_turn(self) -> None:
        """Handle a portion, or one message: it is this reader's turn."""


class Load:
    """How much more of a core the process has taken than it may."""

    def __init__(self) -> None:
        self._cpu_ns, self._now_ns = time.process_time_ns(), time.monotonic_ns()
        self._over_ns = 0.0

    def over_ns(self, most_ns: int) -> float:
        """Return the processor time beyond `MOST_BUSY` since the process was below it, at most `most_ns`."""
        cpu_ns, now_ns = time.process_time_ns(), time.monotonic_ns()
        over_ns = self._over_ns + (cpu_ns - self._cpu_ns) - MOST_BUSY * (now_ns - self._now_ns)
        self._cpu_ns, self._now_ns = cpu_ns, now_ns
        self._over_ns = min(max(0.0, over_ns), most_ns)
        return self._over_ns

    def forget(self) -> None:
        """Forget the processor time until now."""
        self.over_ns(0)


class Pace:
    """The time of one process."""

    def __init__(self, clock: Clock, share: float = 1.0, slice_ns: int = SLICE_NS, load: Load | None = None) -> None:
        """`share` is the greatest part of the time for outsiders, above 0; with 1 they only give way to what is due."""
        self._clock, self._share, self._slice_ns, self._load = clock, share, slice_ns, load
        self.portion_ns = slice_ns // 2
        """The time that one portion of bytes should take at most."""
        self._waiting: dict[Reader, int] = {}
        """The readers that wait, each with the number of its latest turn; who had none joins as if it just had one."""
        self._turns: dict[Reader, int] = {}
        self._turn = 0
        self._taken_ns = 0.0
        self._latest_ns = self._answered_ns = self._answered_cpu_ns = 0
        self._began_ns = 0
        self._alarm = Alarm(clock)
        """The end of a pause, or the next turns."""
        self.pauses = 0
        """How often there was a pause."""

    @property
    def is_pausing(self) -> bool:
        return self._alarm.is_set

    def is_free(self, reader: Reader) -> bool:
        """Return whether the reader may handle something now; if not, its `take_turn` is called when it is its turn."""
        if not self._alarm.is_set and not self._waiting:
            self._note_turn(reader)
            return True
        self._waiting[reader] = self._turns.setdefault(reader, self._turn)
        if not self._alarm.is_set:
            self._alarm.at(time.monotonic_ns(), self._go_on)
        return False

    def leave(self, reader: Reader) -> None:
        self._waiting.pop(reader, None)
        self._turns.pop(reader, None)

    def _note_turn(self, reader: Reader) -> None:
        self._turn += 1
        self._turns[reader] = self._turn

    def spent(self, began_ns: int) -> int:
        """Note that something of outsiders was handled since `began_ns`, and return the time that it took."""
        now_ns = time.monotonic_ns()
        took_ns = now_ns - began_ns
        self._taken_ns = self._left_ns(now_ns) + took_ns
        self._latest_ns = now_ns
        if self._taken_ns >= self._slice_ns and not self.is_pausing:
            self._pause(now_ns, self._duration_ns())
        else:
            self.look()
        return took_ns

    def _left_ns(self, now_ns: int) -> float:
        """Return what outsiders have taken beyond their share; all of it if they only give way to what is due."""
        passed_ns = now_ns - self._latest_ns
        if self._share < 1:
            return max(0.0, self._taken_ns - passed_ns * self._share)
        return self._taken_ns if passed_ns < self._slice_ns else 0.0

    def _duration_ns(self) -> int:
        """Return how long outsiders have to wait until they have had no more than their share."""
        return min(int(self._taken_ns / self._share), LONGEST_WAIT_NS) if self._share < 1 else 0

    def answered(self, asked_ns: int, *, has_turnaround: bool = True) -> None:
        """Note that something was answered that outsiders asked at `asked_ns`, of `time.monotonic_ns`.

        The work was done in the meantime, one piece after the other, so no instant counts twice.  With
        `has_turnaround`, time in which the process did nothing does not count, as a device may only have waited.
        At most the longest wait counts: no one waits longer for it.
        """
        now_ns, cpu_ns = time.monotonic_ns(), time.process_time_ns()
        took_ns = min(now_ns - max(asked_ns, self._answered_ns), LONGEST_WAIT_NS)
        if has_turnaround:
            took_ns = min(took_ns, cpu_ns - self._answered_cpu_ns)
        self._answered_ns, self._answered_cpu_ns = now_ns, cpu_ns
        self.spent(now_ns - took_ns)

    def look(self) -> None:
        """Let the readers wait if the process takes too much of a core."""
        if self._load is not None and not self.is_pausing and self._is_busy():
            self._pause(time.monotonic_ns(), self._slice_ns)

    def _is_busy(self) -> bool:
        return self._load is not None and self._load.over_ns(2 * self._slice_ns) >= self._slice_ns

    def _pause(self, now_ns: int, duration_ns: int) -> None:
        self.pauses += 1
        self._began_ns = now_ns
        if self._share == 1:
            self._taken_ns = 0.0
        self._alarm.at(now_ns + duration_ns, self._go_on)

    def _more_ns(self, now_ns: int) -> int:
        """Return how much longer the pause has to be, for work that was under way when it began."""
        waited_ns = now_ns - self._began_ns
        over_ns = self._left_ns(now_ns) - self._slice_ns // 2
        if self._share < 1 and over_ns > 0 and waited_ns < LONGEST_WAIT_NS:
            return min(int(over_ns / self._share), LONGEST_WAIT_NS)
        return LOOK_AGAIN_NS if self._is_busy() and waited_ns < LONGEST_PAUSE_NS else 0

    def _go_on(self) -> None:
        """Give those who wait their turns, one after the other, until the next pause."""
        now_ns = time.monotonic_ns()
        more_ns = self._more_ns(now_ns)
        if more_ns:
            self._alarm.at(now_ns + more_ns, self._go_on)
            return
        self._taken_ns, self._latest_ns = self._left_ns(now_ns), now_ns
        if self._load is not None:
            self._load.forget()
        for _ in range(TURNS_AT_ONCE):
            if self._alarm.is_set or not self._waiting:
                return
            reader = min(self._waiting, key=self._waiting.__getitem__)
            del self._waiting[reader]
            self._note_turn(reader)
            reader.take_turn()
        if not self._alarm.is_set and self._waiting:  # other events have their turn first
            self._alarm.at(now_ns, self._go_on)


def beside_a_cycle(clock: Clock) -> Pace:
    """Return the pace of a process that has a cycle to keep, or that serves one which has."""
    return Pace(clock, SHARE_BESIDE_A_CYCLE, SLICE_BESIDE_A_CYCLE_NS, Load())
