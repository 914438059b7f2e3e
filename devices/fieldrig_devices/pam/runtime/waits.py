"""The waits of suspended sequences (PAML-292, section 2.16).

`is_over` is asked when the task is served.  What a wait depends on wakes the task; a wait that nothing wakes asks for
the basic cycles in which it has to be looked at.
"""

from collections.abc import Callable
from typing import Protocol

from fieldrig_devices.pam.runtime.item import Pending, Value
from fieldrig_devices.pam.runtime.lower.formulas import Formula
from fieldrig_devices.pam.runtime.lower.lowered import CaseSite
from fieldrig_devices.pam.runtime.watches import Watches


class Waiting(Protocol):
    """A task whose sequence waits, as its waits and its exception know it."""

    item: int
    watches: Watches
    timed_out: bool
    """TIMEOUT, which the last CONDITION or EXCEPTION has set (G-23)."""
    next_sequence: str | None
    """The sequence that takes the place of the present one."""
    on_end: list[Callable[[], None]]
    """Called when the sequence that is alive has ended."""

    @property
    def cycle(self) -> int:
        """The present basic cycle, counted from power-on."""

    def wake(self) -> None:
        """Have the task served in its next cycle."""

    def enter(self, cycle: int) -> None:
        """Have the task served in the first of its cycles that is not before this one."""

    def enter_next(self) -> None:
        """Have the task served in the next basic cycle, whatever its CYCLES are."""

    def value(self, formula: Formula) -> Value | None:
        """Return the value of a formula for this item; None if an answer is missing."""

    def chosen(self, site: CaseSite) -> str | None:
        """Return the sequence of the first condition that is true."""

    def late(self, site: CaseSite) -> str | None:
        """Return the sequence of the time-out, which has come."""


class Wait(Protocol):
    def begin(self) -> None:
        """Have the task woken when the wait may be over."""

    def is_over(self) -> bool:
        """Return whether the sequence goes on."""

    def end(self) -> None:
        """Forget the wait, over or not."""


class _Timed:
    """A wait that may have a time-out, in basic cycles from power-on."""

    def __init__(self, task: Waiting, deadline: int | None) -> None:
        self.task, self.deadline = task, deadline

    def begin(self) -> None:
        if self.deadline is not None:
            self.task.enter(self.deadline)

    @property
    def is_late(self) -> bool:
        return self.deadline is not None and self.task.cycle >= self.deadline

    def end(self) -> None:
        """Do nothing: an answer leaves nothing to forget."""


class TimeWait(_Timed):
    """WAIT_TIME (PAML-355)."""

    def is_over(self) -> bool:
        return self.is_late


class ConditionWait(_Timed):
    """CONDITION (PAML-350).  The condition is evaluated in the cycles of the task (G-18)."""

    def __init__(self, task: Waiting, formula: Formula, deadline: int | None) -> None:
        super().__init__(task, deadline)
        self._formula = formula
        self._has_changed = False

    def begin(self) -> None:
        super().begin()
        self.task.watches.add(self._formula, self.task.item, self._on_change)
        self._poll()

    def _on_change(self) -> None:
        self._has_changed = True
        self.task.wake()

    def _poll(self) -> None:
        if self._formula.is_polled:
            self.task.enter(self.task.cycle + 1)

    def is_over(self) -> bool:
        if self._has_changed or self._formula.is_polled:
            self._has_changed = False
            if self.task.value(self._formula):
                return True
            self._poll()
        if self.is_late:
            self.task.timed_out = True
            return True
        return False

    def end(self) -> None:
        self.task.watches.remove(self._formula, self.task.item, self._on_change)


class CaseWait(_Timed):
    """CASE (PAML-356, PAML-357): the first of its conditions that is true starts its sequence."""

    def __init__(self, task: Waiting, site: CaseSite, deadline: int | None) -> None:
        super().__init__(task, deadline)
        self._site = site
        self._has_changed = False

    def begin(self) -> None:
        super().begin()
        for formula, _ in self._site.branches:
            self.task.watches.add(formula, self.task.item, self._on_change)
        self._poll()

    def _on_change(self) -> None:
        self._has_changed = True
        self.task.wake()

    @property
    def _is_polled(self) -> bool:
        return any(formula.is_polled for formula, _ in self._site.branches)

    def _poll(self) -> None:
        if self._is_polled:
            self.task.enter(self.task.cycle + 1)

    def is_over(self) -> bool:
        if self._has_changed or self._is_polled:
            self._has_changed = False
            chosen = self.task.chosen(self._site)
            if chosen is not None:
                self.task.next_sequence = chosen
                return True
            self._poll()
        if self.is_late:
            self.task.timed_out = True
            self.task.next_sequence = self.task.late(self._site)
            return True
        return False

    def end(self) -> None:
        for formula, _ in self._site.branches:
            self.task.watches.remove(formula, self.task.item, self._on_change)


class AnswerWait:
    """An answer that comes over the ring: the sequence goes on in the basic cycle in which it is there (PAML-144)."""

    def __init__(self, task: Waiting, pending: Pending) -> None:
        self._task, self._pending = task, pending

    def begin(self) -> None:
        self._task.enter_next()

    def is_over(self) -> bool:
        if self._pending.value is None:
            self._task.enter_next()
            return False
        return True

    def end(self) -> None:
        """Do nothing: an answer leaves nothing to forget."""


class FinishWait:
    """XEQ_TASK ... WAIT: the sequence that was started has to end (PAML-324)."""

    def __init__(self, task: Waiting, other: Waiting) -> None:
        self._task, self._other = task, other
        self._is_over = False

    def begin(self) -> None:
        self._other.on_end.append(self._on_end)

    def _on_end(self) -> None:
        self._is_over = True
        self._task.wake()

    def is_over(self) -> bool:
        return self._is_over

    def end(self) -> None:
        if not self._is_over:
            self._other.on_end.remove(self._on_end)


class Gate:
    """CONDITION DUPL_START of one sequence: at most DUPL of its items are beyond it and alive (PAML-354, G-20)."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._beyond: set[int] = set()
        self.waiting: list[Waiting] = []

    def enter(self, task: Waiting) -> bool:
        if task.item not in self._beyond and len(self._beyond) >= self._most:
            return False
        self._beyond.add(task.item)
        return True

    def leave(self, task: Waiting) -> None:
        if task.item in self._beyond:
            self._beyond.remove(task.item)
            for waiting in self.waiting:
                waiting.wake()


class GateWait:
    def __init__(self, task: Waiting, gate: Gate) -> None:
        self._task, self._gate = task, gate

    def begin(self) -> None:
        self._gate.waiting.append(self._task)

    def is_over(self) -> bool:
        return self._gate.enter(self._task)

    def end(self) -> None:
        self._gate.waiting.remove(self._task)
