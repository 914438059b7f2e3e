"""When a drive looks at the control word: with each word that arrives, or once in a cycle of its own.

A drive with a cycle misses every word that another one replaces within the cycle, as drives do whose state machine runs
in a slow loop.
"""

from collections.abc import Callable

from fieldrig.clock import MS, Alarm, Clock


class ControlCycle:
    def __init__(self, clock: Clock, cycle_ms: float, act: Callable[[int], None]) -> None:
        self._clock, self._cycle_ns, self._act = clock, round(cycle_ms * MS), act
        self.is_slow = self._cycle_ns > 0
        """False for a drive without a cycle of its own, which acts on each word at once."""
        self._due = Alarm(clock)
        self._word = 0

    def restart(self) -> None:
        """Drop a word that the drive has not seen yet."""
        self._due.stop()

    def take(self, word: int) -> None:
        """Take a word that has arrived, if the drive has a cycle."""
        self._word = word
        if not self._due.is_set:
            begun = self._clock.now_ns() // self._cycle_ns
            self._due.at((begun + 1) * self._cycle_ns, self._look)

    def _look(self) -> None:
        self._act(self._word)
