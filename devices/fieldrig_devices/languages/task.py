"""One thread of a resumable program: its next instruction, and the calls that it has to return from.

`run` spends a budget of instructions and returns the rest.  Breakpoints and single steps use the slower builds of the
same code (see `resumable`), so that they cost nothing while a program isn't being debugged.
"""

from enum import Enum, auto

from fieldrig_devices.languages.resumable import CALL, END, SLICE, STOP, WAIT, Build, Code


class TaskState(Enum):
    IDLE = auto()  # not started
    READY = auto()  # continues in the next slice
    STOPPED = auto()  # in front of a breakpoint
    ENDED = auto()
    TOO_DEEP = auto()  # exceeds the allowed number of nested calls


AFTER = {CALL: TaskState.TOO_DEEP, END: TaskState.ENDED, STOP: TaskState.STOPPED}
"""The state after a call that is nested too deep, a return from the outermost routine, or a breakpoint."""


class Task:
    def __init__(self, code: Code) -> None:
        self._code = code
        self.state = TaskState.IDLE
        self.routine = 0
        self.pc = 0
        self.stack: list[tuple[int, int]] = []
        """The places to return to as (routine, pc), outermost first."""
        self.is_watched = False
        """True if the task stops at breakpoints."""
        self._is_between = False  # True if `pc` may be a place where the fast builds can't be entered
        self._passed: tuple[int, int] | None = None  # place whose breakpoint is ignored until the task has left it

    def start(self, routine: str) -> None:
        self.routine, self.pc = self._code.numbers[routine], 0
        self.stack.clear()
        self.state, self._is_between, self._passed = TaskState.READY, False, None

    def stop(self) -> None:
        """End the task and discard its place."""
        self.stack.clear()
        self.state = TaskState.IDLE

    @property
    def line(self) -> int:
        """Source line of the next instruction."""
        return self._code.line(self.routine, self.pc)

    def run(self, budget: int) -> int:
        """Run until the budget is used up, or until the task waits or is no longer READY.

        Return the rest of the budget: 0 or less after a full slice.  A task that waits gives up the rest of its
        slice, so the result is 0 or less then too.
        """
        if self._is_between:
            budget = self._run_to_a_block(budget)
        if self.state is not TaskState.READY:
            return budget
        functions = self._code.functions(Build.WATCHED if self.is_watched else Build.FAST)
        left, stack = self._code.left, self.stack
        routine, pc = self.routine, self.pc
        while budget > 0:
            why, pc, budget = functions[routine](pc, budget, len(stack))
            if left:  # the task is inside a routine that it has called; innermost first
                routine = left[0].called
                stack += [(call.caller, call.pc) for call in reversed(left)]
                left.clear()
            if why == END and stack:
                routine, pc = stack.pop()
            elif why != SLICE:
                if why == WAIT:
                    budget = min(budget, 0)
                else:
                    self.state = AFTER[why]
                break
        self.routine, self.pc = routine, pc
        return budget

    def step(self) -> None:
        """Run one instruction, regardless of breakpoints.  A Hold stays in place; a Pause continues after itself."""
        if self.state is TaskState.STOPPED:
            self.state = TaskState.READY
        if self.state is TaskState.READY:
            self._step()

    def go_on(self) -> None:
        """Continue from a breakpoint: `run` starts with the next instruction even if it has a breakpoint."""
        if self.state in (TaskState.STOPPED, TaskState.READY):
            self.state = TaskState.READY
            self._is_between, self._passed = True, (self.routine, self.pc)

    def _run_to_a_block(self, budget: int) -> int:
        while budget > 0 and self.state is TaskState.READY:
            if self._is_stop():
                self.state = TaskState.STOPPED
                break
            why = self._step()
            if why == WAIT:
                if (self.routine, self.pc) != self._passed:
                    self._passed = None
                return 0
            self._passed = None
            budget -= 1
            if self.pc in self._code.leaders[self.routine]:
                self._is_between = False
                break
        return budget

    def _is_stop(self) -> bool:
        is_watched = self.is_watched and (self.routine, self.pc) != self._passed
        return is_watched and bool(self._code.stops[self.routine][self.pc])

    def _step(self) -> int:
        why, self.pc, _ = self._code.functions(Build.STEPPED)[self.routine](self.pc, 1, len(self.stack))
        self._is_between = True
        if why == CALL and len(self.stack) < self._code.deepest:
            self.stack.append((self.routine, self.pc + 1))
            self.routine, self.pc = self._code.calls[self.routine][self.pc], 0
        elif why == END and self.stack:
            self.routine, self.pc = self.stack.pop()
        elif why in AFTER:
            self.state = AFTER[why]
        return why
