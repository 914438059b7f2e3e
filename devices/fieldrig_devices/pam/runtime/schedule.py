"""When which program of an application is looked at again, exact to the basic cycle.

A program has its place in the order of the declarations (G-16), and is served in cycles that are multiples of its
CYCLES.  A program that waits is not served until the cycle that it asked for, so it costs nothing.
"""

from abc import ABC, abstractmethod
from heapq import heappop, heappush
from typing import Final

BEFORE_ALL: Final = -1
AFTER_ALL: Final = 1 << 60


class Unit(ABC):
    """A program: one item of a task, or of a group of actions."""

    def __init__(self, schedule: "Schedule", cycles: int) -> None:
        self.schedule, self.cycles = schedule, cycles
        self.order = len(schedule.units)
        """Its place in the order of the declarations, which is the order in which programs are made."""
        schedule.units[self.order] = self
        self.due = -1
        """The last basic cycle that it has been entered for."""

    def wake(self) -> None:
        """Have the program served in its next cycle."""
        self.schedule.enter(self, self.schedule.cycle)

    @property
    def cycle(self) -> int:
        """The present basic cycle, counted from power-on."""
        return self.schedule.cycle

    def enter(self, cycle: int) -> None:
        """Have the program served in the first of its cycles that is not before this one."""
        self.schedule.enter(self, cycle)

    def enter_next(self) -> None:
        """Have the program served in the next basic cycle, whatever its CYCLES are."""
        self.schedule.enter_next(self)

    @abstractmethod
    def begin(self) -> None:
        """Look at the events from now on."""

    @abstractmethod
    def forget_events(self) -> None:
        """Drop the events that have occurred, and take no notice of what is true now."""

    @abstractmethod
    def serve(self) -> None:
        """Do what is due in this basic cycle."""


class Schedule:
    def __init__(self, gives_way: list[int]) -> None:
        self._gives_way = gives_way
        """The cell by which a loop sees that others wait for it."""
        self.cycle = 0
        self.units: dict[int, Unit] = {}
        """All programs by their places in the order of the declarations."""
        self._position = AFTER_ALL
        """Place of the program that is served now."""
        self._waiting: dict[int, dict[Unit, None]] = {}
        self._due: list[int] = []
        self._again: list[Unit] = []

    def enter(self, unit: Unit, cycle: int) -> None:
        """Have a program served in the first of its cycles that is not before this one, and not over yet."""
        if cycle <= self.cycle:
            cycle = self.cycle if unit.order > self._position else self.cycle + 1
        cycle += -cycle % unit.cycles  # counted from power-on, so that programs of the same CYCLES run side by side
        if cycle == unit.due and cycle > self.cycle:
            return  # entered already: until then, an event may wake the program in each basic cycle
        unit.due = cycle
        if cycle == self.cycle:
            heappush(self._due, unit.order)
            self._gives_way[0] = 1
        else:
            self._waiting.setdefault(cycle, {})[unit] = None

    def enter_next(self, unit: Unit) -> None:
        """Have a program served in the next basic cycle, whatever its CYCLES are."""
        self._waiting.setdefault(self.cycle + 1, {})[unit] = None

    def again(self, unit: Unit) -> None:
        """Have a program served again in this basic cycle, after the others."""
        self._again.append(unit)

    @property
    def is_busy(self) -> bool:
        """True if other programs are due in this basic cycle."""
        return bool(self._due or self._again)

    def begin(self) -> None:
        """Begin the next basic cycle."""
        self.cycle += 1
        self._position = BEFORE_ALL
        for unit in self._waiting.pop(self.cycle, ()):
            heappush(self._due, unit.order)

    def next(self) -> Unit | None:
        """Return the next program to serve in this basic cycle."""
        if not self._due:
            if not self._again:
                self._position = AFTER_ALL
                return None
            self._due = sorted(unit.order for unit in self._again)
            self._again = []
        order = heappop(self._due)
        while self._due and self._due[0] == order:  # it was woken more than once
            heappop(self._due)
        self._position = order
        return self.units[order]
