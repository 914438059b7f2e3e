"""Programs and the same by hand, which take turns, so that a change of the machine's speed meets all of them."""

import statistics
import time
from collections.abc import Callable, Sequence

REPEATS = 7


def take_turns(
    statements: int, by_hand: Callable[[], None], programs: Sequence[Callable[[], None]]
) -> list[list[float]]:
    """Return nanoseconds of CPU time a statement in each turn, by hand first and then for each program."""
    taken: list[list[float]] = [[] for _ in (by_hand, *programs)]
    for _ in range(REPEATS):
        for run, found in zip((by_hand, *programs), taken, strict=True):
            start = time.process_time_ns()
            run()
            found.append((time.process_time_ns() - start) / statements)
    return taken


def shown(values: Sequence[float], form: str) -> str:
    """Return the mean and the standard deviation of turns."""
    return f"{statistics.mean(values):{form}} ± {statistics.stdev(values):{form}}"
