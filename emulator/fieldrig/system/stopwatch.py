"""The time of the host that something takes, for limits and reports of tools; no device knows it."""

import time


class Stopwatch:
    """Measures from when it is made."""

    def __init__(self) -> None:
        self._begin_s = time.perf_counter()

    @property
    def seconds(self) -> float:
        return time.perf_counter() - self._begin_s
