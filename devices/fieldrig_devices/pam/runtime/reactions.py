"""Actions, connected routines and POWERON parts: programs that do not wait (sections 2.13 and PAML-264)."""

from collections import deque
from collections.abc import Sequence
from typing import Final

from fieldrig_devices.languages.debugging.stepping import Goal
from fieldrig_devices.languages.task import Task, TaskState
from fieldrig_devices.pam.runtime.item import Value
from fieldrig_devices.pam.runtime.kernel import ProgramKernel
from fieldrig_devices.pam.runtime.lower.formulas import Formula
from fieldrig_devices.pam.runtime.lower.lowered import ActionsCode
from fieldrig_devices.pam.runtime.schedule import Unit
from fieldrig_devices.pam.runtime.watches import Event

MOST_WAITING: Final = 1_024
"""Routines that may wait for their turn.  The manual names the FIFO of events without its size (07..E023)."""


class Runner:
    """Runs routines to their ends, one at a time in the order in which they were asked for (G-27)."""

    def __init__(self, kernel: ProgramKernel, name: str, frame: int) -> None:
        self._kernel, self.name, self._frame = kernel, name, frame
        self.task = Task(kernel.code)
        self.goal: Goal | None = None
        self._queue: deque[tuple[str, int, Sequence[Value]]] = deque()
        self.timed_out = False
        """TIMEOUT belongs to sequences."""

    def add(self, routine: str, item: int = 0, arguments: Sequence[Value] = ()) -> None:
        self._queue.append((routine, item, arguments))

    @property
    def is_idle(self) -> bool:
        return not self._queue

    @property
    def is_alive(self) -> bool:
        return bool(self._queue)

    @property
    def is_full(self) -> bool:
        return len(self._queue) >= MOST_WAITING

    def is_held(self) -> bool:
        """True at a breakpoint."""
        return self.task.state is TaskState.STOPPED

    def run(self) -> None:
        """Run what is in the queue.  A breakpoint, and a cycle without room for more, leave the rest for later."""
        kernel = self._kernel
        while self._queue and not self.is_held():
            if self.task.state is not TaskState.READY:
                routine, item, arguments = self._queue[0]
                kernel.cells[self._frame : self._frame + len(arguments)] = arguments
                self.task.start(routine, self._frame, item)
            kernel.run(self)
            if kernel.is_stopped:
                return
            if self.is_held():
                kernel.on_stopped()
                return
            if self.task.state is TaskState.READY:
                return
            self._queue.popleft()


class Condition:
    """The condition of an ON_STATE action, which is evaluated when something has changed."""

    def __init__(self, owner: "ActionsItem", formula: Formula) -> None:
        self._owner, self._formula = owner, formula
        self._is_true, self._has_changed = False, True

    def begin(self) -> None:
        self._owner.watches.add(self._formula, self._owner.item, self._on_change)

    @property
    def is_polled(self) -> bool:
        return self._formula.is_polled

    def _on_change(self) -> None:
        self._has_changed = True
        self._owner.wake()

    def holds(self) -> bool:
        if self._has_changed or self._formula.is_polled:
            value = self._owner.watches.value(self._formula, self._owner.item)
            if value is not None:
                self._is_true, self._has_changed = bool(value), False
        return self._is_true


class ActionsItem(Unit):
    """One item of a group of actions."""

    def __init__(self, kernel: ProgramKernel, code: ActionsCode, item: int, frame: int) -> None:
        super().__init__(kernel.schedule, code.cycles)
        self._kernel, self.code, self.item = kernel, code, item
        self.watches = kernel.watches
        name = code.name if code.count == 1 else f"{code.name}[{item + 1}]"
        self.runner = Runner(kernel, name, frame)
        self._reactions: list[tuple[Event | Condition, str]] = [
            (
                Event(self.watches, reaction.formula, item, self.wake, kernel.readings)
                if reaction.is_event
                else Condition(self, reaction.formula),
                reaction.routine,
            )
            for reaction in code.reactions
        ]

    def begin(self) -> None:
        for trigger, _ in self._reactions:
            trigger.begin()

    def forget_events(self) -> None:
        for trigger, _ in self._reactions:
            if isinstance(trigger, Event):
                trigger.forget()

    def serve(self) -> None:
        """Run the actions whose events have occurred, and those whose states are true (PAML-261, PAML-262)."""
        if not self._kernel.is_working or self.runner.is_held():
            return
        self.runner.run()  # goes on after a breakpoint, and with what the last cycle had no room for
        if self.runner.is_idle:
            self._react()
        if not self.runner.is_idle and not self.runner.is_held():
            self.enter_next()

    def _react(self) -> None:
        for trigger, routine in self._reactions:
            if isinstance(trigger, Event):
                times, is_again = trigger.take(), trigger.is_polled
            else:
                times = int(trigger.holds())
                is_again = times > 0 or trigger.is_polled
            if is_again:
                self.enter(self.cycle + 1)
            for _ in range(times):
                self.runner.add(routine, self.item)
                self.runner.run()
                if self._kernel.is_stopped:
                    return
                self._kernel.run_routines()  # the end of an action (PAML-274)
