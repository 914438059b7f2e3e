"""Fewer lines for a person who watches all buses of a busy rig."""

from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any, Final

Line = tuple[str, dict[str, Any]]
"""A line for people, and its data for scripts."""
WINDOW_S: Final = 1.0
LINES_OF_A_WINDOW: Final = 40
"""Lines that a person can follow; shared by the buses."""
FEWEST: Final = 2
"""Lines of each bus, however many buses there are."""


def thinned(lines: Iterator[Line | None], buses: int, now_s: Callable[[], float]) -> Iterator[Line | None]:
    """Yield the first lines of each bus in each second, and how many were left out; all others, such as events.

    `now_s` is a monotonic clock.
    """
    share = max(LINES_OF_A_WINDOW // max(buses, 1), FEWEST)
    seen = Counter[str]()
    end_s = now_s() + WINDOW_S
    for line in lines:
        if now_s() >= end_s:
            if left_out := {bus: count - share for bus, count in seen.items() if count > share}:
                yield _summary(left_out)
            seen.clear()
            end_s = now_s() + WINDOW_S
        bus = None if line is None else line[1].get("bus")
        if line is not None and isinstance(bus, str) and "sender" in line[1]:
            seen[bus] += 1
            if seen[bus] > share:
                continue
        yield line


def _summary(left_out: dict[str, int]) -> Line:
    most = max(left_out, key=lambda bus: left_out[bus])
    counts = ", ".join(f"{bus} {count}" for bus, count in left_out.items())
    text = (
        f"-- {sum(left_out.values())} more messages in this second ({counts}); `fieldrig watch {most}` shows all of one"
    )
    return text, {"left_out": left_out}
