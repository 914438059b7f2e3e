"""The functions that generated code calls: service statements of the sequence that runs, and writes to variables.

A service statement returns True if the sequence has to wait, to end, or to look at its exception.
"""

from collections.abc import Callable, Mapping, Sequence
from math import ceil
from typing import Any, Final

from fieldrig_devices.pam.runtime.armed import Armed
from fieldrig_devices.pam.runtime.item import Pending, Value
from fieldrig_devices.pam.runtime.kernel import ProgramKernel
from fieldrig_devices.pam.runtime.lower.lowered import CaseSite, ConditionSite, ExceptionSite, Site, StartSite, Switch
from fieldrig_devices.pam.runtime.sequence import TaskItem
from fieldrig_devices.pam.runtime.waits import (
    AnswerWait,
    CaseWait,
    ConditionWait,
    FinishWait,
    Gate,
    GateWait,
    TimeWait,
    Wait,
)

NEGATIVE_EXCEPTION: Final = "03..E031"
NEGATIVE_CONDITION: Final = "03..E032"
_ROUNDING: Final = 1e-9
"""A duration of a real number of milliseconds is not one cycle longer because of its last bit."""


class Services:
    def __init__(self, kernel: ProgramKernel, sites: Sequence[Site]) -> None:
        self._kernel = kernel
        self._sites: list[Any] = list(sites)

    def functions(self) -> Mapping[str, Callable[..., Any]]:
        """Return the functions by their names in generated code."""
        return {
            "changed": self._kernel.watches.changed,
            "poke_all": self._poke_all,
            "poke_and_tell": self._poke_and_tell,
            "poke_inverted": self._poke_inverted,
            "timed_out": lambda: self._kernel.processor.has_timed_out,
            "answer": self._answer,
            "condition": self._condition,
            "condition_until": self._condition,
            "choose": self._choose,
            "choose_until": self._choose,
            "wait_time": self._wait_time,
            "gate": self._gate,
            "switch": self._switch,
            "start_task": self._start_task,
            "arm": self._arm,
            "arm_until": self._arm,
            "arm_rest": self._arm_rest,
            "disarm": lambda: self._task.disarm(),
        }

    @property
    def _task(self) -> TaskItem:
        """The item of a task whose sequence runs; only sequences have service statements."""
        present = self._kernel.processor.present
        assert isinstance(present, TaskItem)
        return present

    # ---- writes to variables

    def _poke_all(self, first: int, count: int, value: Value) -> None:
        self._kernel.cells[first : first + count] = [value] * count

    def _poke_and_tell(self, first: int, count: int, value: Value) -> None:
        for cell in range(first, first + count):
            self._kernel.poke(cell, value)

    def _poke_inverted(self, first: int, count: int) -> None:
        for cell in range(first, first + count):
            self._kernel.poke(cell, not self._kernel.cells[cell])

    # ---- waits

    def _wait(self, wait: Wait) -> bool:
        self._task.wait = wait
        wait.begin()
        return True

    def _deadline(self, milliseconds: float | None, error: str) -> int | None:
        """Return the basic cycle in which a time is over.  A negative one ends the sequence (PAML-353)."""
        if milliseconds is None:
            return None
        if milliseconds < 0:
            self._task.fail(error)
            return None
        kernel = self._kernel
        return kernel.schedule.cycle + ceil(milliseconds * 3 / kernel.thirds - _ROUNDING)

    def _wait_time(self, milliseconds: float) -> bool:
        if milliseconds <= 0:
            return False
        return self._wait(TimeWait(self._task, self._deadline(milliseconds, NEGATIVE_CONDITION)))

    def _condition(self, number: int, milliseconds: float | None = None) -> bool:
        task = self._task
        site: ConditionSite = self._sites[number]
        task.timed_out = False
        deadline = self._deadline(milliseconds, NEGATIVE_CONDITION)
        if task.is_doomed:
            return True
        if task.value(site.formula):
            return False
        return self._wait(ConditionWait(task, site.formula, deadline))

    def _choose(self, number: int, milliseconds: float | None = None) -> bool:
        task = self._task
        site: CaseSite = self._sites[number]
        task.timed_out = False
        deadline = self._deadline(milliseconds, NEGATIVE_CONDITION)
        if task.is_doomed:
            return True
        task.next_sequence = task.chosen(site)
        return True if task.next_sequence is not None else self._wait(CaseWait(task, site, deadline))

    def _gate(self) -> bool:
        task = self._task
        assert task.sequence is not None
        if task.code.duplicates is None:
            return False
        gate = self._kernel.gates.setdefault(task.gate_of(task.sequence), Gate(task.code.duplicates))
        return False if gate.enter(task) else self._wait(GateWait(task, gate))

    # ---- other sequences

    def _switch(self, number: int) -> None:
        site: Switch = self._sites[number]
        self._task.next_sequence = site.sequence

    def _start_task(self, number: int) -> bool:
        task = self._task
        site: StartSite = self._sites[number]
        other = task.start_other(site)
        if other is not None and site.mode == "WAIT":
            return self._wait(FinishWait(task, other))
        return task.is_doomed or task.sequence is None

    # ---- exceptions

    def _arm(self, number: int, milliseconds: float | None = None) -> bool:
        deadline = self._deadline(milliseconds, NEGATIVE_EXCEPTION)
        return True if self._task.is_doomed else self._armed(self._sites[number], deadline)

    def _arm_rest(self, number: int) -> bool:
        """Take over what is left of the time-out of the exception before (PAML-379)."""
        before = self._task.exception
        return self._armed(self._sites[number], None if before is None else before.deadline)

    def _armed(self, site: ExceptionSite, deadline: int | None) -> bool:
        task = self._task
        task.timed_out = False
        task.disarm()
        task.exception = Armed(task, site, deadline)
        task.exception.begin()
        return task.exception.has_occurred

    # ---- answers from the ring

    def later(self, slot: int, answer: Value | Pending) -> bool:
        """Keep the answer to an inquiry of the present statement; True if it is still under way."""
        task = self._task
        del task.answers[slot:]
        task.answers.append(answer)
        if isinstance(answer, Pending) and answer.value is None:
            return self._wait(AnswerWait(task, answer))
        return False

    def _answer(self, slot: int) -> Value:
        answer = self._task.answers[slot]
        value = answer.value if isinstance(answer, Pending) else answer
        assert value is not None
        return value
