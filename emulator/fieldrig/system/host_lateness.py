"""How late the host is for one process: in words with figures, for `fieldrig status`, the log and the user.

A host that has too much to do, or too few cores, handles timers late and lets rings miss cycles.  Then a device may
stop with a fault of its own, such as a ring that is open, though nothing is wrong with it.  So the begin and the end of
such a time are reported once, and what devices and buses log names the lateness of the last seconds.
"""

import logging
import os
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from fieldrig.clock import MS, S
from fieldrig.system.this_process import usable_cores

log = logging.getLogger(__name__)

NOTED_NS: Final = 2 * MS
"""Least lateness that a log record names."""
LATE_NS: Final = 50 * MS
"""Lateness of a timer with which the host counts as late; a host that is only busy has some milliseconds."""
MOST_LOST: Final = 0.05
"""Share of the cycles of a ring that may be late before the host counts as late."""
FEWEST_CYCLES: Final = 20
"""Cycles in a window that are enough for a share."""
WINDOW_NS: Final = 5 * S
SETTLED_WINDOWS: Final = 6
"""Windows without lateness after which the host counts as on time again."""
OF_DEVICES: Final = ("fieldrig_bus", "fieldrig_devices")
"""The packages whose log records name the lateness."""

Statistics = Mapping[str, float]


@dataclass
class Lateness:
    """The largest lateness in the present window and in the one before."""

    worst_ns: int = 0
    last_worst_ns: int = 0

    def note(self, late_ns: int) -> None:
        """Note that something was handled late by this time."""
        self.worst_ns = max(self.worst_ns, late_ns)

    def turn(self) -> int:
        """Begin the next window, and return the largest lateness of the one that ends."""
        self.last_worst_ns, self.worst_ns = self.worst_ns, 0
        return self.last_worst_ns

    @property
    def recent_ns(self) -> int:
        """The largest lateness of the last one or two windows."""
        return max(self.worst_ns, self.last_worst_ns)

    def words(self) -> str:
        """Return the recent lateness in words; "" if there is none worth mentioning."""
        if self.recent_ns < NOTED_NS:
            return ""
        return f"the host was up to {self.recent_ns / MS:,.0f} ms late in the last seconds, {_load()}"


class LateRecords(logging.Filter):
    """Adds the lateness of the host to what devices and buses log, as it may be the cause."""

    def __init__(self, lateness: Lateness) -> None:
        super().__init__()
        self._lateness = lateness

    def filter(self, record: logging.LogRecord) -> bool:
        """Return True, as every record is wanted."""
        if record.levelno >= logging.INFO and record.name.startswith(OF_DEVICES):
            words = self._lateness.words()
            if words:
                record.msg, record.args = f"{record.getMessage()} ({words})", ()
        return True


class LateHost:
    """Judges window by window whether the host is late."""

    def __init__(self, lateness: Lateness, statistics: Callable[[], Mapping[str, Statistics]]) -> None:
        """`statistics` returns the counters of the buses that this process answers for."""
        self._lateness, self._statistics = lateness, statistics
        self._counted: dict[str, tuple[float, float]] = {}
        self._good_windows = SETTLED_WINDOWS
        self.words = ""
        """How late the host is at present; "" if it is not."""
        self.worst_ns = 0
        """The largest lateness since the process began."""
        self.worst_at_s = 0.0
        """When that was, as a Unix time."""

    def turn(self) -> str | None:
        """End a window.  Return words if the host is late from now on, "" if it no longer is, None without a change."""
        worst_ns = self._lateness.turn()
        if worst_ns > self.worst_ns:
            self.worst_ns, self.worst_at_s = worst_ns, time.time()
        reports = [*self._of_timers(worst_ns), *self._of_rings()]
        was_late = self.words != ""
        if reports:
            self._good_windows = 0
            self.words = f"{'; '.join(reports)}; {_load()}"
            return None if was_late else self.words
        self._good_windows += 1
        if was_late and self._good_windows >= SETTLED_WINDOWS:
            self.words = ""
            return ""
        return None

    def facts(self) -> dict[str, float | str]:
        """Return the present words, and the largest lateness since the process began with its time of day (Unix)."""
        return {"words": self.words, "worst_ms": round(self.worst_ns / MS, 1), "worst_at_s": round(self.worst_at_s, 3)}

    @staticmethod
    def _of_timers(worst_ns: int) -> list[str]:
        return [f"timers are up to {worst_ns / MS:,.0f} ms late"] if worst_ns >= LATE_NS else []

    def _of_rings(self) -> list[str]:
        reports = []
        for bus, statistics in self._statistics().items():
            if "late_cycles" not in statistics:
                continue
            now = statistics["cycles"], statistics["late_cycles"]
            before = self._counted.get(bus, now)
            self._counted[bus] = now
            cycles, late = now[0] - before[0], now[1] - before[1]
            if cycles >= FEWEST_CYCLES and late > MOST_LOST * cycles:
                reports.append(f"{bus} keeps {100 * (1 - late / cycles):.0f} % of its cycles")
        return reports


def _load() -> str:
    cores = usable_cores()
    return f"load {os.getloadavg()[0]:.0f} on {cores} cores" if hasattr(os, "getloadavg") else f"{cores} cores"
