"""One thread of a resumable program: where it stands, and the calls it has to return from.

`run` spends a budget of instructions and returns what is left; breakpoints and single steps go by the slower builds of
the same code (see `resumable`), so that a program that nobody looks at pays nothing for them.
"""

from enum import Enum, auto

from fieldrig_devices.languages.resumable import Build, Code, Why


class TaskState(Enum):
    IDLE = auto()  # not started
    READY = auto()  # goes on in the next slice
    STOPPED = auto()  # in front of a breakpoint
    ENDED = auto()
    TOO_DEEP = auto()  # more calls within calls than allowed


class Task:
    def __init__(self, code: Code, deepest: int) -> None:
        self._code, self._deepest = code, deepest
        self.state = TaskState.IDLE
        self.routine = 0
        self.pc = 0
        self.stack: list[tuple[int, int]] = []
        """(routine, pc) to return to, outermost first."""
        self.is_watched = False
        """Whether breakpoints count."""
        self._is_between = False  # may stand where the fast builds have no entry

    def start(self, routine: str) -> None:
        self.routine, self.pc = self._code.numbers[routine], 0
        self.stack.clear()
        self.state, self._is_between = TaskState.READY, False

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
        functions = self._code.functions(Build.WATCHED if self.is_watched else Build.FAST)
        while budget > 0 and self.state is TaskState.READY:
            why, self.pc, budget = functions[self.routine](self.pc, budget)
            if why == Why.WAIT:
                return min(budget, 0)
            if why != Why.SLICE:
                self._follow(why)
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
            self._is_between = True

    def _run_to_a_block(self, budget: int) -> int:
        self._is_between = False
        is_first = True
        while budget > 0 and self.state is TaskState.READY:
            if not is_first and self._is_stop():
                self.state = TaskState.STOPPED
                break
            why = self._step()
            budget -= 1
            is_first = False
            if why is Why.WAIT:
                budget = 0
            elif self.pc in self._code.leaders[self.routine]:
                return budget
        self._is_between = True
        return budget

    def _is_stop(self) -> bool:
        return self.is_watched and bool(self._code.stops[self.routine][self.pc])

    def _step(self) -> Why:
        why, self.pc, _ = self._code.functions(Build.STEPPED)[self.routine](self.pc, 1)
        self._is_between = True
        if why not in (Why.SLICE, Why.WAIT):
            self._follow(why)
        return Why(why)

    def _follow(self, why: int) -> None:
        if why == Why.CALL:
            self._call()
        elif why == Why.END:
            self._return()
        else:
            self.state = TaskState.STOPPED

    def _call(self) -> None:
        if len(self.stack) >= self._deepest:
            self.state = TaskState.TOO_DEEP
            return
        self.stack.append((self.routine, self.pc + 1))
        self.routine, self.pc = self._code.calls[self.routine][self.pc], 0

    def _return(self) -> None:
        if self.stack:
            self.routine, self.pc = self.stack.pop()
        else:
            self.state = TaskState.ENDED
