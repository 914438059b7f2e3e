"""The times in which a Modbus unit did not answer, as faults of the emulated device: while it boots, or is off.

A function that it never answered is a fault without an end.
"""

from array import array
from collections.abc import Iterator, Sequence
from itertools import groupby
from operator import itemgetter
from typing import Any, Final, NamedTuple

from fieldrig.clock import MS

FUNCTION_CODES: Final = range(1, 128)
MOST_INSTANTS: Final = 4_096
FEWEST: Final = 3
"""Requests in a row without an answer that are a silence; fewer are lost by chance."""
MOST: Final = 50
"""Silences of a unit that are repeated; a unit with more of them answers by chance."""


class _Silence(NamedTuple):
    begin_ns: int | None
    """None: from the start on."""
    end_ns: int | None
    """None: until the end."""


class Silences:
    """The instants of the requests to a unit, by whether they had an answer."""

    def __init__(self) -> None:
        self._answered, self._unanswered = array("q"), array("q")
        self._functions = array("B")
        """Functions of the requests without an answer."""
        self._known: set[int] = set()
        """Functions that were answered."""
        self._found: tuple[int, Sequence[_Silence]] | None = None

    def take(self, begin_ns: int, function: int, is_answered: bool) -> None:
        """Take a request."""
        if is_answered:
            self._known.add(function)
        instants = self._answered if is_answered else self._unanswered
        if len(instants) < MOST_INSTANTS:
            instants.append(begin_ns)
            if not is_answered:
                self._functions.append(function)

    def add(self, other: "Silences") -> None:
        """Take the requests without an answer of which it was not known that they are for this unit."""
        for begin_ns, function in zip(other._unanswered, other._functions, strict=True):
            self.take(begin_ns, function, False)

    def faults(self, start_ns: int, end_ns: int) -> list[dict[str, Any]]:
        """Return the faults of a device that is switched on at `start_ns`.

        Requests that began after `end_ns` say nothing: the recording has ended before they could be answered.
        """
        never = sorted(({*self._functions} - self._known) & {*FUNCTION_CODES})
        found: list[dict[str, Any]] = [{"what": "silent", "function": function} for function in never]
        return found + [_fault(silence, start_ns) for silence in self._spans(end_ns)]

    def single(self, function: int, begin_ns: int, end_ns: int) -> bool:
        """Return whether a request without an answer at `begin_ns` was lost alone, and is in no fault."""
        if begin_ns > end_ns or function not in self._known:
            return False
        return not any(
            (silence.begin_ns is None or silence.begin_ns <= begin_ns)
            and (silence.end_ns is None or begin_ns < silence.end_ns)
            for silence in self._spans(end_ns)
        )

    def _spans(self, end_ns: int) -> Sequence[_Silence]:
        if self._found is None or self._found[0] != end_ns:
            silences = list(_silences(self._of_known(end_ns)))
            self._found = end_ns, silences if len(silences) <= MOST else []
        return self._found[1]

    def _of_known(self, last_ns: int) -> list[tuple[int, bool]]:
        """Return the requests with functions that were answered, in order of time."""
        if len(self._answered) == MOST_INSTANTS:
            last_ns = min(last_ns, self._answered[-1])
        silent = zip(self._unanswered, self._functions, strict=True)
        known = [(time_ns, False) for time_ns, function in silent if function in self._known and time_ns <= last_ns]
        return sorted([*known, *((time_ns, True) for time_ns in self._answered)])


def _silences(asked: Sequence[tuple[int, bool]]) -> Iterator[_Silence]:
    """Yield the silences; each begins and ends in the middle between two requests, as times differ a little."""
    before_ns: int | None = None
    silent: list[int] = []
    for is_answered, run in groupby(asked, itemgetter(1)):
        instants = [time_ns for time_ns, _ in run]
        if not is_answered:
            silent = instants if len(instants) >= FEWEST else []
            continue
        if silent:
            yield _Silence(_middle(before_ns, silent[0]), _middle(silent[-1], instants[0]))
            silent = []
        before_ns = instants[-1]
    if silent and before_ns is not None:
        yield _Silence(_middle(before_ns, silent[0]), None)


def _middle(one_ns: int | None, other_ns: int) -> int | None:
    return None if one_ns is None else (one_ns + other_ns) // 2


def _fault(silence: _Silence, start_ns: int) -> dict[str, Any]:
    begin_ns = start_ns if silence.begin_ns is None else max(silence.begin_ns, start_ns)
    fault: dict[str, Any] = {"what": "silent"}
    if begin_ns > start_ns:
        fault["start_ms"] = round((begin_ns - start_ns) / MS, 3)
    if silence.end_ns is not None:
        fault["duration_ms"] = max(round((silence.end_ns - begin_ns) / MS, 3), 0.001)
    return fault
