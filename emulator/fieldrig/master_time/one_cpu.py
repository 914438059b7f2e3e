"""The threads of a master on one processor, as only one of them runs at any time.

On two processors each hand-over wakes the other one, where the woken thread has to wait a second time, for the lock of
Python: 40 us on a host with nothing else to do.  On one it takes 2 us.  A processor that others want too is left for
the next one, because the system cannot move threads that are bound to it.
Left out: systems but Linux.
"""

import os
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Final

LEAST_SHARE: Final = 0.7
"""Share of the time that the threads have to get where they are."""
_real_monotonic, _real_process_time = time.monotonic, time.process_time


class OneCpu:
    """Made in the thread that enters the block, and closed in it."""

    def __init__(self) -> None:
        self._before: list[int] = []
        """The processors that the thread may use outside of the block; empty if it has no choice."""
        self._natives: list[int] = []
        self._place = 0
        self._looked_s, self._spent_s = _real_monotonic(), _real_process_time()
        if sys.platform == "linux" and hasattr(os, "sched_getaffinity"):
            with suppress(OSError):
                self._before = sorted(os.sched_getaffinity(0))
        if len(self._before) > 1:
            self._place = _place_now(self._before)
        else:
            self._before = []

    def take(self, native: int) -> None:
        """Bind a thread, by its number in the system."""
        if self._before:
            self._natives.append(native)
            _bind(native, [self._before[self._place]])

    def look(self) -> None:
        """Go to the next processor if the threads had too little of this one since the last look."""
        now_s, spent_s = _real_monotonic(), _real_process_time()
        is_starved = spent_s - self._spent_s < LEAST_SHARE * (now_s - self._looked_s)
        self._looked_s, self._spent_s = now_s, spent_s
        if self._before and is_starved:
            self._place = (self._place + 1) % len(self._before)
            for native in tuple(self._natives):
                _bind(native, [self._before[self._place]])

    def forget(self, native: int) -> None:
        """Leave alone a thread that ends, as another one may get its number."""
        if native in self._natives:
            self._natives.remove(native)

    def close(self) -> None:
        """Let all of them use the processors that they had before."""
        natives, self._natives = self._natives, []
        for native in natives:
            _bind(native, self._before)


def _place_now(cpus: list[int]) -> int:
    """Return the place of the processor where this thread runs, which the system has chosen well."""
    try:
        fields = Path("/proc/thread-self/stat").read_bytes().rpartition(b")")[2].split()
        return cpus.index(int(fields[36]))
    except (OSError, ValueError, IndexError):
        return 0


def _bind(native: int, cpus: list[int]) -> None:
    if sys.platform == "linux":
        with suppress(OSError):  # it has ended, or this system forbids it
            os.sched_setaffinity(native, cpus)
