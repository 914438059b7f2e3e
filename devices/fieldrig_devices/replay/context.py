"""The messages around one of a log, by reading the log once more up to there."""

from collections import deque
from collections.abc import Callable, Iterable
from typing import Final

from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.replay.diff_result import Around
from fieldrig_devices.replay.streams import in_time

AROUND: Final = 4
"""Messages that are shown before and after one."""

Read = Callable[[], Iterable[TraceEntry]]
"""Opens a log; it may be called several times."""


def around(read: Read, time_ns: int, number: int | None, shift_ns: int) -> list[Around]:
    """Return the messages around one of a log, or around an instant if the log does not have it."""
    before: deque[Around] = deque(maxlen=AROUND)
    found: list[Around] = []
    for place, entry in in_time(read()):
        at_ns = entry.time_ns - shift_ns
        is_it = place == number
        if not found and not is_it and (number is not None or at_ns < time_ns):
            before.append(Around(entry, at_ns, False))
            continue
        found.append(Around(entry, at_ns, is_it))
        if len(found) > AROUND:
            break
    return [*before, *found]
