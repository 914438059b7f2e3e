"""Formulas and events that are looked at when a variable or an object changes.

A formula that depends on something is registered at each of its places; a change there calls what was registered.
"""

from collections.abc import Callable
from typing import Any

from fieldrig_devices.languages.faults import CAUGHT
from fieldrig_devices.pam.runtime.item import Value
from fieldrig_devices.pam.runtime.lower.formulas import Formula
from fieldrig_devices.pam.runtime.readings import Readings

OnChange = Callable[[], None]


class UnansweredError(Exception):
    """A formula needs an answer that is still under way on the ring."""


class Watches:
    def __init__(self, cells: int) -> None:
        self._by_cell: list[list[OnChange]] = [[] for _ in range(cells)]
        self._by_object: dict[str, list[OnChange]] = {}
        self._places: dict[tuple[int, int], tuple[list[OnChange], ...]] = {}
        self.functions: list[Callable[[int], Any]] = []
        """The functions of the formulas, by their numbers."""
        self.on_fault: Callable[[BaseException, Formula], None] = _raise
        """Called when a formula has no value because of the program, such as a division by zero."""

    def value(self, formula: Formula, item: int) -> Value | None:
        """Return the value of a formula for an item; None if it needs an answer that is not there yet."""
        try:
            result: Value = self.functions[formula.number](item)
        except UnansweredError:
            return None
        except CAUGHT as fault:
            self.on_fault(fault, formula)
            return None
        return result

    def add(self, formula: Formula, item: int, on_change: OnChange) -> None:
        """Call `on_change` at each change of what the formula depends on."""
        for waiting in self._of(formula, item):
            waiting.append(on_change)

    def remove(self, formula: Formula, item: int, on_change: OnChange) -> None:
        for waiting in self._of(formula, item):
            waiting.remove(on_change)

    def _of(self, formula: Formula, item: int) -> tuple[list[OnChange], ...]:
        # Kept, as a sequence in a loop registers its condition and takes it away again each time that it waits.
        known = self._places.get((formula.number, item))
        if known is None:
            cells = {cell: None for each in formula.cells for cell in each.of(item)}
            objects = [self._by_object.setdefault(name, []) for name in formula.objects]
            known = self._places[formula.number, item] = (*(self._by_cell[cell] for cell in cells), *objects)
        return known

    @property
    def size(self) -> int:
        """Number of things that are registered, each counted at all of its places."""
        return sum(map(len, (*self._by_cell, *self._by_object.values())))

    def changed(self, cell: int) -> None:
        """A variable has changed."""
        for on_change in self._by_cell[cell]:
            on_change()

    def touched(self, name: str) -> None:
        """An object has changed."""
        for on_change in self._by_object.get(name, ()):
            on_change()


class Event:
    """An expression that causes something each time it becomes true (PAML-261).

    It is evaluated at each change, so that a short one is not missed, and is served in the cycles of its owner (G-17).
    If events are sampled, it is evaluated in these cycles only.
    """

    __slots__ = (
        "_counts_first",
        "_formula",
        "_is_counted",
        "_is_sampled",
        "_item",
        "_on_event",
        "_times",
        "_was",
        "_watches",
        "is_polled",
    )

    def __init__(self, watches: Watches, formula: Formula, item: int, on_event: OnChange, readings: Readings) -> None:
        self._watches, self._formula, self._item, self._on_event = watches, formula, item, on_event
        self._is_counted, self._is_sampled = readings.events == "counted", readings.events == "sampled"
        self.is_polled = self._is_sampled or is_polled_event(formula, readings)
        self._counts_first = readings.events_at_start == "all"
        self._was = False
        self._times = 0

    def begin(self) -> None:
        """Look at the expression from now on.  Its present value is an event only if all that are true count."""
        if self._counts_first:
            self.look()
        else:
            self.forget()
        if not self._is_sampled:
            self._watches.add(self._formula, self._item, self.look)

    def forget(self) -> None:
        """Take the present value as the one from which the event begins."""
        self._was = bool(self._watches.value(self._formula, self._item))
        self._times = 0

    def look(self) -> None:
        value = self._watches.value(self._formula, self._item)
        if value is None:
            return
        if value and not self._was:
            self._times = self._times + 1 if self._is_counted else 1
            self._on_event()
        self._was = bool(value)

    def take(self) -> int:
        """Return how often the event counts since the last call."""
        if self.is_polled:
            self.look()
        times, self._times = self._times, 0
        return times


def is_polled_event(formula: Formula, readings: Readings) -> bool:
    """Return whether the owner of an event or exception has to look at it in each of its cycles."""
    return formula.is_polled if readings.common_variables_cause_events else formula.is_polled_as_event


def _raise(fault: BaseException, _formula: Formula) -> None:
    raise fault
