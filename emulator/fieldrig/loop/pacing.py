"""Real time for tools that run something by themselves: the time that has passed, at a steady pace."""

import time
from collections.abc import Iterator
from typing import Final

MOMENT_S: Final = 0.02


def elapsed_ns(speed: float, limit_ns: int | None = None) -> Iterator[int]:
    """Yield the time since the start, times `speed`, about 50 times a second, and last of all the limit."""
    start_ns = time.monotonic_ns()
    while True:
        passed_ns = round((time.monotonic_ns() - start_ns) * speed)
        if limit_ns is not None and passed_ns >= limit_ns:
            yield limit_ns
            return
        yield passed_ns
        time.sleep(MOMENT_S)
