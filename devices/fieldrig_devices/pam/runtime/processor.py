"""Runs one program at a time, within the statements that a basic cycle has room for."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from fieldrig_devices.languages.debugging.stepping import Goal
from fieldrig_devices.languages.task import Task, TaskState
from fieldrig_devices.pam.runtime.item import Value
from fieldrig_devices.pam.runtime.lower.formulas import Formula
from fieldrig_devices.pam.runtime.schedule import Schedule, Unit
from fieldrig_devices.pam.runtime.watches import Watches

GIVES_WAY, INTERRUPTED = 0, 1
"""The flags that generated code looks at: W[0] at the end of a loop, and W[1] after a statement."""


@dataclass(frozen=True, slots=True)
class Limits:
    """The speed of the PAM, which the manual does not give."""

    statements_per_ms: int = 10_000
    """Statements of all programs together in a millisecond of the basic cycle."""
    is_overrun_fatal: bool = False
    """True: programs that need more stop the PAM by 02..F060; False: they go on in the next basic cycle.

    That error is one of the high-priority cycle (table 12-9), in which ring and pipes are processed.  An overload by
    programs only delays them (manual lines 3131 to 3135).
    """


class Program(Protocol):
    """The item of a task, or the routines of a group of actions: one at a time is run by the processor."""

    task: Task
    goal: Goal | None
    """The end of a step of the debugger."""
    timed_out: bool
    """The value of TIMEOUT."""

    @property
    def name(self) -> str: ...

    @property
    def is_alive(self) -> bool:
        """True if it has something to run, or waits."""


class Processor:
    def __init__(self, schedule: Schedule, watches: Watches, flags: list[int], statements: int) -> None:
        self._schedule, self._watches, self._flags = schedule, watches, flags
        self.statements = statements
        """Statements for which a basic cycle has room."""
        self._rest = 0
        self._running: Program | None = None
        self.on_fault: Callable[[Program], None] = lambda _: None
        self.on_overrun: Callable[[Program], None] = lambda _: None

    def begin(self) -> None:
        """Begin a basic cycle."""
        self._rest = self.statements

    def run(self, program: Program, *, gives_way: bool) -> None:
        """Run a program until it waits, ends or gives way."""
        self._running, task = program, program.task
        self._flags[GIVES_WAY], self._flags[INTERRUPTED] = int(gives_way or self._schedule.is_busy), 0
        if program.goal is None:
            left = task.run(self._rest)
            # `Task.run` takes the whole budget of a program that waits, which here the others share.
            self._rest = task.unused if task.has_waited else left
        else:
            self._run_to_goal(program, program.goal)
        self._running = None
        if task.state is TaskState.FAULTED:
            self.on_fault(program)
        elif self._rest <= 0 and task.state is TaskState.READY:
            self.on_overrun(program)

    def _run_to_goal(self, program: Program, goal: Goal) -> None:
        """Run one instruction after the other until the step of the debugger is complete, or the program waits."""
        task = program.task
        while self._rest > 0:
            before = (task.routine, task.pc, len(task.stack))
            self._rest -= task.step()
            if task.state is not TaskState.READY:
                program.goal = None
            elif (task.is_at_breakpoint and (task.routine, task.pc, len(task.stack)) != before) or goal.is_reached(
                task.line, len(task.stack), is_beginning=task.begins_line
            ):
                program.goal = None
                task.halt()
            elif not task.is_waiting:
                continue
            return

    def give_way(self, task: Unit) -> None:
        """Let a sequence go on after the other programs that are due, or in the next cycle if this one is used up."""
        if self._rest > 0:
            self._schedule.again(task)
        else:
            self._schedule.enter_next(task)

    def call(self) -> None:
        """Let the program that runs give way at the end of its loop, because a routine waits."""
        self._flags[GIVES_WAY] = 1

    def interrupt(self, sequence: Program) -> None:
        """The exception of a sequence has occurred; if it runs, it stops after its statement."""
        if self._running is sequence:
            self._flags[INTERRUPTED] = 1

    @property
    def present(self) -> Program | None:
        """The program that runs."""
        return self._running

    @property
    def present_item(self) -> int:
        return 0 if self._running is None else self._running.task.base

    @property
    def has_timed_out(self) -> bool:
        """TIMEOUT of the program that runs."""
        return self._running is not None and self._running.timed_out

    def value(self, formula: Formula, item: int, surroundings: Program) -> Value | None:
        """Return the value of a formula as if a program asked for it; None if an answer is missing."""
        before, self._running = self._running, surroundings
        value = self._watches.value(formula, item)
        self._running = before
        return value
