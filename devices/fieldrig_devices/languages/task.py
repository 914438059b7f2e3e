"""One thread of a resumable program: where it stands, and the calls it has to return from.

`run` spends a budget of instructions and returns what is left; breakpoints and single steps go by the slower builds of
the same code (see `resumable`), so that a program that nobody looks at pays nothing for them.
"""

from enum import Enum, auto

from fieldrig_devices.languages.resumable import CALL, END, SLICE, STOP, WAIT, Build, Code


class TaskState(Enum):
    IDLE = auto()  # not started
    READY = auto()  # goes on in the next slice
    STOPPED = auto()  # in front of a breakpoint
    ENDED = auto()
    TOO_DEEP = auto()  # more calls within calls than allowed


AFTER = {CALL: TaskState.TOO_DEEP, END: TaskState.ENDED, STOP: TaskState.STOPPED}
"""What a task is when it can't follow a call, has nowhere to return to, or stands in front of a breakpoint."""


class Task:
    def __init__(self, code: Code) -> None:
        self._code = code
        self.state = TaskState.IDLE
        self.routine = 0
        self.pc = 0
        self.stack: list[tuple[int, int]] = []
        """(routine, pc) to return to, outermost first."""
        self.is_watched = False
        """Whether breakpoints count."""
        self._is_between = False  # may stand where the fast builds have no entry
        self._passed: tuple[int, int] | None = None  # the place whose breakpoint doesn't count, until it is left

    def start(self, routine: str) -> None:
        self.routine, self.pc = self._code.numbers[routine], 0
        self.stack.clear()
        self.state, self._is_between, self._passed = TaskState.READY, False, None

    def stop(self) -> None:
        """Forget where it was."""
        self.stack.clear()
        self.state = TaskState.IDLE

    @property
    def line(self) -> int:
        """The source line of the instruction that comes next."""
        return self._code.line(self.routine, self.pc)

    def run(self, budget: int) -> int:
        """Go on until the budget is used up, or the task waits or is not READY any more.

        Returns what is left of the budget: nothing or less after a full slice.  A task that waits gives up the
        rest of its slice, and gets 0 back.
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
            if left:  # it stands in a routine that it has called, innermost first
                routine = left[0].called
                stack += [(one.caller, one.pc) for one in reversed(left)]
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
        """Run one instruction, whatever stops stand there.  One that waits stays where it is, or behind itself."""
        if self.state is TaskState.STOPPED:
            self.state = TaskState.READY
        if self.state is TaskState.READY:
            self._step()

    def go_on(self) -> None:
        """Leave a breakpoint: `run` begins with the instruction it stands in front of, whatever stops are there."""
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
