"""Runs a rig, or a branch of one, until a condition holds."""

from collections.abc import Callable
from typing import Final, Protocol, TypeVar

from fieldrig.clock import MS
from fieldrig.errors import ArgumentError, UnmetError
from fieldrig.outside.untrusted import shown
from fieldrig.virtual.readings import Readings, seconds

T = TypeVar("T")

LOOK_NS: Final = 1 * MS
"""Longest time between two looks at a condition; values such as the level of a tank change without an event."""


class Running(Protocol):
    @property
    def now_ns(self) -> int: ...

    def next_ns(self) -> int | None: ...

    def run_for(self, duration_ns: int) -> None: ...


def run_until_met(rig: Running, condition: Callable[[], T], within: int, look: Callable[[Readings], T]) -> T:
    """Run until `condition` holds, and return its value; `look` calls it and notes what it reads.

    UnmetError, with the points that it read and their last changes, if it does not hold in time.
    """
    if not callable(condition):
        raise ArgumentError(
            f"until cannot take {shown(condition)}",
            'expected a function, such as until(lambda: rig.get("tank/level") > 1.5, within=60 * S)',
        )
    begin_ns, readings = rig.now_ns, Readings()
    end_ns = begin_ns + duration(within, "until")
    while not (met := look(readings)):
        now_ns = rig.now_ns
        if now_ns >= end_ns:
            times = f"within {seconds(within)}, from {seconds(begin_ns)} to {seconds(end_ns)}"
            raise UnmetError(f"the condition did not hold {times}", readings.text())
        next_ns, look_ns = rig.next_ns(), now_ns + LOOK_NS
        until_ns = min(end_ns, look_ns if next_ns is None else max(min(next_ns, look_ns), now_ns + 1))
        rig.run_for(until_ns - now_ns)
    return met


def duration(duration_ns: int, call: str) -> int:
    """Return a duration of a call.  ArgumentError for a negative one, or anything but whole nanoseconds."""
    if type(duration_ns) is not int or duration_ns < 0:
        raise ArgumentError(
            f"{call} cannot take {shown(duration_ns)}", "expected a duration in whole nanoseconds, such as 10 * MS"
        )
    return duration_ns
