"""The FIFO of commands from the PAM: what arrives faster than the node works is lost once it is full (Appendix F: E 6).

The rates are ours: the node takes as many commands in a millisecond as the ring has free frames (3.1).
"""

from typing import Final

from fieldrig.clock import MS

PER_MS: Final = 20
DEPTH: Final = 256
RECEPTION: Final = 6
"""The number of this FIFO."""


class Backlog:
    """Counts the commands that wait.  Nothing is computed while none arrives."""

    def __init__(self) -> None:
        self._waiting, self._at_ns = 0, 0

    def takes(self, now_ns: int) -> bool:
        """Return whether a command finds room at this instant."""
        passed = (now_ns - self._at_ns) * PER_MS // MS
        if passed:
            self._waiting, self._at_ns = max(self._waiting - passed, 0), now_ns
        if self._waiting >= DEPTH:
            return False
        self._waiting += 1
        return True
