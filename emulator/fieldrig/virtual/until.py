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
    _check(condition, 'until(lambda: rig.get("tank/level") > 1.5, within=60 * S)')
    begin_ns, readings = rig.now_ns, Readings()
    end_ns = begin_ns + duration(within, "until")
    while not (met := look(readings)):
        if rig.now_ns >= end_ns:
            times = f"within {seconds(within)}, from {seconds(begin_ns)} to {seconds(end_ns)}"
            raise UnmetError(f"the condition did not hold {times}", readings.text())
        _go_on(rig, end_ns)
    return met


def run_while_met(
    rig: Running,
    condition: Callable[[], object],
    during: int,
    look: Callable[[Callable[[], object], Readings], object],
    end: Callable[[], object] | None = None,
    *,
    is_wanted: bool = True,
) -> None:
    """Run for `during`, at every instant of which the condition is to be true, or false if it is not wanted.

    With `end`, run until that is true, which it has to be in this time.  UnmetError, with the points that were read and
    their last changes, at the first instant at which it is otherwise.
    """
    call = "stays" if is_wanted else "never"
    _check(condition, f'{call}(lambda: rig.get("drive/run"), during=1 * S)')
    if end is not None:
        _check(end, 'stays(..., during=1 * S, until=lambda: rig.get("drive/stopped"))')
    begin_ns, readings = rig.now_ns, Readings()
    end_ns = begin_ns + duration(during, call)
    while end is None or not look(end, readings):
        if bool(look(condition, readings)) is not is_wanted:
            what = "no longer held" if is_wanted else "held"
            times = f"at {seconds(rig.now_ns)}, {seconds(rig.now_ns - begin_ns)} after {seconds(begin_ns)}"
            raise UnmetError(f"the condition {what} {times}", readings.text())
        if rig.now_ns >= end_ns:
            if end is not None:
                raise UnmetError(f"the end did not come within {seconds(during)}", readings.text())
            return
        _go_on(rig, end_ns)


def _go_on(rig: Running, end_ns: int) -> None:
    """Go to the next instant at which something happens, but not beyond the end, and by at most LOOK_NS."""
    now_ns, next_ns = rig.now_ns, rig.next_ns()
    look_ns = now_ns + LOOK_NS
    until_ns = min(end_ns, look_ns if next_ns is None else max(min(next_ns, look_ns), now_ns + 1))
    rig.run_for(until_ns - now_ns)


def _check(condition: object, example: str) -> None:
    if not callable(condition):
        call, _, _ = example.partition("(")
        raise ArgumentError(f"{call} cannot take {shown(condition)}", f"expected a function, such as {example}")


def duration(duration_ns: int, call: str) -> int:
    """Return a duration of a call.  ArgumentError for a negative one, or anything but whole nanoseconds."""
    if type(duration_ns) is not int or duration_ns < 0:
        raise ArgumentError(
            f"{call} cannot take {shown(duration_ns)}", "expected a duration in whole nanoseconds, such as 10 * MS"
        )
    return duration_ns
