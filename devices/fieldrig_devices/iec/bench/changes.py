"""The last changes of variables while the tasks of a program run, for the message of a test that fails."""

from collections import deque
from typing import Final

from fieldrig_devices.iec.layout import DATA
from fieldrig_devices.iec.types import Value

MOST_CHANGES: Final = 4
"""Values of a variable in a message, the last of them."""
_PART: Final = 64
"""Cells that are compared at a time: most have not changed, and comparing a list is one step of the interpreter."""

Change = tuple[int, Value]
"""A value, behind the instant at which it came."""


class Changes:
    """The values that the cells of a program had, cycle by cycle."""

    def __init__(self) -> None:
        self._before: list[Value] = []
        self._changes: dict[int, deque[Change]] = {}

    def begin(self, now_ns: int, cells: list[Value]) -> None:
        """Begin with the values that the cells have now."""
        self._before, self._began_ns = cells[DATA:], now_ns
        self._changes.clear()

    def look(self, now_ns: int, cells: list[Value]) -> None:
        """Note what has changed since the last look; nothing before the first `begin`."""
        before = self._before
        for first in range(0, len(before), _PART):
            part = cells[DATA + first : DATA + first + _PART]
            if part == before[first : first + _PART]:
                continue
            for number, value in enumerate(part, first):
                if number < len(before) and value != before[number]:
                    self._note(number, before[number], now_ns, value)
            before[first : first + _PART] = part[: len(before) - first]

    def _note(self, number: int, old: Value, now_ns: int, new: Value) -> None:
        known = self._changes.get(number)
        if known is None:
            known = self._changes[number] = deque([(self._began_ns, old)], maxlen=MOST_CHANGES)
        known.append((now_ns, new))

    def of(self, address: int) -> list[Change]:
        """Return the last values of a cell, the oldest first; nothing if no task has run."""
        number = address - DATA
        if not 0 <= number < len(self._before):
            return []
        return list(self._changes.get(number, [(self._began_ns, self._before[number])]))
