"""The time of the host that something takes, for limits and reports of tools; no device knows it."""

import time


class Stopwatch:
    """Measures from when it is made."""

    def __init__(self) -> None:
        self._begin_s = time.perf_counter()
        self._begin_busy_s = time.process_time()

    @property
    def seconds(self) -> float:
        return time.perf_counter() - self._begin_s

    @property
    def busy_seconds(self) -> float:
        """The time for which this process had a processor, which other work of the host does not lengthen."""
        return time.process_time() - self._begin_busy_s
