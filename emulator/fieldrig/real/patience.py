"""How long the supervisor lets one process start without progress, and how soon it restarts the process.

Both times grow with each restart of the same process, and return to normal once it has been ready for a while.
"""

from typing import Final

FIRST_PAUSE_S: Final = 0.1
LONGEST_PAUSE_S: Final = 5.0
LONGEST_LIMIT_S: Final = 600.0
"""Largest limit after doubling, unless the rig file sets a larger one."""
SETTLED_S: Final = 10.0
"""Time after which a process that is ready counts as stable."""


class Patience:
    def __init__(self, start_timeout_s: float) -> None:
        self._first_s = start_timeout_s
        self.limit_s = start_timeout_s
        """Longest time without progress."""
        self._pause_s = FIRST_PAUSE_S

    def after_death(self, ready_s: float) -> float:
        """Return the pause before the next start of a process that has ended after being ready for `ready_s`."""
        if ready_s >= SETTLED_S:
            self.limit_s, self._pause_s = self._first_s, FIRST_PAUSE_S
        else:
            self.limit_s = max(self.limit_s, min(2 * self.limit_s, LONGEST_LIMIT_S))
        pause_s, self._pause_s = self._pause_s, min(2 * self._pause_s, LONGEST_PAUSE_S)
        return pause_s

    @property
    def advice(self) -> str:
        """Return what the user may change if the limit was too short."""
        return f"on a busy host set start_timeout_s: {2 * self.limit_s:g} in the rig file, or by --set"
