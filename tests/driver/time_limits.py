"""Time limits for the tests of a forked process, all kept by one thread.

pytest-timeout starts a thread for each test, which costs 0.3 ms of CPU time: a third of what a short test takes.  What
happens at the end of a limit is pytest-timeout's own: it says where each thread is, and ends the process.
"""

from threading import Thread
from time import monotonic, sleep
from typing import Any, Final, NamedTuple

import pytest
import pytest_timeout

LOOKS_AGAIN_S: Final = 1.0
"""A limit may end later by this."""


class Limit(NamedTuple):
    end_s: float
    item: pytest.Item
    settings: Any


class TimeLimits:
    """A plugin that answers the hooks of pytest-timeout, but for tests whose limit is a signal."""

    def __init__(self) -> None:
        self._limit: Limit | None = None
        Thread(target=self._watch, name="time limits of tests", daemon=True).start()

    def pytest_timeout_set_timer(self, item: pytest.Item, settings: Any) -> bool | None:
        if settings.method != "thread":
            return None
        self._limit = Limit(monotonic() + settings.timeout, item, settings)
        return True

    def pytest_timeout_cancel_timer(self) -> bool | None:
        if self._limit is None:
            return None
        self._limit = None
        return True

    def _watch(self) -> None:
        while True:
            sleep(LOOKS_AGAIN_S)
            limit = self._limit
            if limit is not None and monotonic() >= limit.end_s:
                pytest_timeout.timeout_timer(limit.item, limit.settings)
