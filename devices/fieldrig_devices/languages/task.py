"""One thread of a resumable program: its next instruction, and the calls that it has to return from.

`run` spends a budget and returns the rest.  Breakpoints and single steps use the slower builds of the same code (see
`resumable`), so that they cost nothing while a program isn't being debugged.
"""

from collections.abc import Callable
from enum import Enum, auto

from fieldrig_devices.languages import faults
from fieldrig_devices.languages.resumable import Activation, Code, Function
from fieldrig_devices.languages.writer import CALL, DEEP, END, SLICE, STOP, WAIT, Build


class TaskState(Enum):
    IDLE = auto()  # not started
    READY = auto()  # continues in the next slice
    STOPPED = auto()  # in front of a breakpoint
    ENDED = auto()
    TOO_DEEP = auto()  # the stack has no room for another call
    FAULTED = auto()  # by a fault of the program


AFTER = {DEEP: TaskState.TOO_DEEP, END: TaskState.ENDED, STOP: TaskState.STOPPED}
"""The state after a call that is nested too deep, a return from the outermost routine, or a breakpoint."""


class Task:
    def __init__(self, code: Code) -> None:
        self._code = code
        self._caught: tuple[type[Exception], ...] = (*faults.CAUGHT, *code.faults)
        self.state = TaskState.IDLE
        self.routine = 0
        self.pc = 0
        self.frame = 0
        self.base = 0
        self.stack: list[Activation] = []
        """The places to return to, outermost first."""
        self.is_watched = False
        """True if the task stops at breakpoints."""
        self.fault: BaseException | None = None
        """The exception that stopped a task that is FAULTED; its place is the one that faulted."""
        self.has_waited = False
        """True if the last run ended at a place that waits."""
        self.is_waiting = False
        """True if the last step was an instruction that waits."""
        self.look: Callable[[], None] | None = None
        """Called after each instruction, for a watch that misses no change; the task stops at the same places."""
        self.ahead: Callable[[], None] | None = None
        """Called in front of each instruction; it may `halt` the task there."""
        self.unused = 0
        """Budget that was left when it began to wait."""
        self._limit = 0
        self._build = Build.STEPPED  # the build that can be entered at `pc`, unless `_is_between`
        self._functions: list[Function] = []
        self._is_mixed = False  # True if another build may have put places on the stack
        self._is_between = False  # True if `pc` may be a place where the fast builds cannot be entered
        self._passed: tuple[int, int] | None = None  # place whose breakpoint is ignored until the task has left it

    def start(self, routine: str, frame: int = 0, base: int = 0) -> None:
        """Start from the beginning of a routine, with the stack at `frame`."""
        self.routine, self.pc, self.frame, self.base = self._code.numbers[routine], 0, frame, base
        self._limit = frame + self._code.stack_size
        self.stack.clear()
        self.state, self._is_between, self._is_mixed, self._passed = TaskState.READY, False, False, None
        self.fault = None

    def go_to(self, pc: int) -> None:
        """Continue at an instruction of the routine that the task was started with."""
        assert not self.stack
        self.pc, self._is_between, self._passed = pc, True, None
        self.state = TaskState.READY

    def stop(self) -> None:
        """End the task and discard its place."""
        self.stack.clear()
        self.state = TaskState.IDLE

    @property
    def line(self) -> int:
        """Source line of the next instruction."""
        return self._code.line(self.routine, self.pc)

    @property
    def begins_line(self) -> bool:
        """True if the next instruction is the first one of its line."""
        return self._code.begins(self.routine, self.pc)[1]

    def run(self, budget: int) -> int:
        """Run until the budget is used up, or until the task waits or is no longer READY.

        Return the rest of the budget: 0 or less after a full slice.  A task that waits gives up the rest of its
        slice, so the result is 0 or less then too.
        """
        self.has_waited = False
        if self.look is not None or self.ahead is not None:
            return self._run_and_look(budget)
        budget = self._run(budget)
        while self._is_between and budget > 0 and self.state is TaskState.READY and not self.has_waited:
            budget = self._run(budget)
        return budget

    def _run(self, budget: int) -> int:
        """Do as `run`, up to a place where the fast builds cannot be entered."""
        code = self._code
        code.limit[0] = self._limit
        build = Build.WATCHED if self.is_watched else Build.FAST
        if self._is_between or build is not self._build:
            budget = self._enter(build, budget)
        if self.state is not TaskState.READY or self.has_waited:
            return budget
        functions, left, stack = self._functions, code.left, self.stack
        routine, pc, frame, base = self.routine, self.pc, self.frame, self.base
        try:
            while budget > 0:
                why, pc, budget = functions[routine](pc, budget, frame, base)
                if left:  # the task is inside a routine that it has called; innermost first
                    routine, frame, base, _ = left[0]
                    stack += [call.caller for call in reversed(left)]
                    left.clear()
                if why == END and stack:
                    routine, pc, frame, base = stack.pop()
                    if self._is_mixed and not code.is_leader(routine, pc, build):
                        self._is_between = True
                        break
                elif why != SLICE:
                    if why == WAIT:
                        self.has_waited, self.unused = True, budget
                        budget = min(budget, 0)
                    else:
                        self.state = AFTER[why]
                    break
        except self._caught as fault:
            return self._fail(build, fault)
        self.routine, self.pc, self.frame, self.base = routine, pc, frame, base
        return budget

    def _enter(self, build: Build, budget: int) -> int:
        """Run to a place where a build can be entered; return the rest of the budget."""
        if build is not self._build:
            self._build, self._functions = build, self._code.functions(build)
            self._is_mixed = bool(self.stack)
            self._is_between |= not self._code.is_leader(self.routine, self.pc, build)
        return self._run_to_a_block(budget, build) if self._is_between else budget

    def _fail(self, build: Build, fault: BaseException) -> int:
        """Stop at the place that raised the fault; return what is left of the budget."""
        running, budget = faults.places(self._code, build, fault)
        if not running:  # not in generated code, so not a fault of the program
            raise fault
        self._code.left.clear()
        self.stack += [level._replace(pc=level.pc + 1) for level in running[:-1]]
        self.routine, self.pc, self.frame, self.base = running[-1]
        if not self._is_caught(fault):
            self.state, self.fault = TaskState.FAULTED, fault
        return budget

    def _is_caught(self, fault: BaseException) -> bool:
        """Go on where a guard of a routine that was running leads, the innermost first."""
        callers = [level._replace(pc=level.pc - 1) for level in reversed(self.stack)]
        places = [Activation(self.routine, self.pc, self.frame, self.base), *callers]
        for depth, (number, pc, frame, base) in enumerate(places):
            guards = self._code.routines[number].guards
            guard = next((one for one in guards if one.first <= pc < one.end), None)
            if guard is not None and self._code.catch(fault, frame + guard.cell):
                self.routine, self.pc, self.frame, self.base = number, guard.target, frame, base
                del self.stack[len(self.stack) - depth :]
                self._is_between, self._passed = True, None
                return True
        return False

    def step(self) -> int:
        """Run one instruction, regardless of breakpoints, and return its cost.

        A Hold stays in place; a Pause continues after itself.
        """
        if self.state is TaskState.STOPPED:
            self.state = TaskState.READY
        self._code.limit[0] = self._limit
        return self._looked_at()[1] if self.state is TaskState.READY and not self._is_halted() else 0

    def halt(self) -> bool:
        """Stop in front of the next instruction, as at a breakpoint; false if there is none."""
        if self.state is TaskState.READY:
            self.state = TaskState.STOPPED
        return self.state is TaskState.STOPPED

    def go_on(self) -> None:
        """Continue from a breakpoint: `run` starts with the next instruction even if it has a breakpoint."""
        if self.state in (TaskState.STOPPED, TaskState.READY):
            self.state = TaskState.READY
            self._is_between, self._passed = True, (self.routine, self.pc)

    def _run_to_a_block(self, budget: int, build: Build) -> int:
        while budget > 0 and self.state is TaskState.READY:
            if self._is_stop():
                self.state = TaskState.STOPPED
                break
            why, cost = self._step()
            if why == WAIT:
                if (self.routine, self.pc) != self._passed:
                    self._passed = None
                self.has_waited, self.unused = True, budget - cost
                return min(budget - cost, 0)
            self._passed = None
            budget -= cost
            if self._code.is_leader(self.routine, self.pc, build):
                self._is_between = False
                break
        return budget

    def _is_halted(self) -> bool:
        """Look ahead, and return whether that has halted the task."""
        if self.ahead is not None:
            self.ahead()
        return self.state is TaskState.STOPPED

    def _looked_at(self) -> tuple[int, int]:
        """Run one instruction, then look."""
        done = self._step()
        if self.look is not None:
            self.look()
        return done

    def _run_and_look(self, budget: int) -> int:
        """Do the same as `run` by single instructions: a slice ends only where the fast build can be entered."""
        build = Build.WATCHED if self.is_watched else Build.FAST
        self._code.limit[0] = self._limit
        while self.state is TaskState.READY and (budget > 0 or self._is_between):
            if self._is_stop():
                self.state = TaskState.STOPPED
                break
            if self._is_halted():
                break
            why, cost = self._looked_at()
            self._is_between = not self._code.is_leader(self.routine, self.pc, build)
            budget -= cost
            if why != WAIT:
                self._passed = None
                continue
            if (self.routine, self.pc) != self._passed:
                self._passed = None
            self.has_waited, self.unused = True, budget
            return min(budget, 0)
        return budget

    @property
    def is_at_breakpoint(self) -> bool:
        """True in front of an instruction with a breakpoint, if the task stops at breakpoints; a step ends there."""
        return self.is_watched and bool(self._code.stops[self.routine][self.pc])

    def _is_stop(self) -> bool:
        return self.is_at_breakpoint and (self.routine, self.pc) != self._passed

    def _step(self) -> tuple[int, int]:
        """Run one instruction; return why it returned, and its cost."""
        function = self._code.functions(Build.STEPPED)[self.routine]
        self._is_between = True
        try:
            why, self.pc, rest = function(self.pc, 1, self.frame, self.base)
        except self._caught as fault:
            return SLICE, 1 - self._fail(Build.STEPPED, fault)
        self.is_waiting = why == WAIT
        if why == CALL:
            self.stack.append(Activation(self.routine, self.pc + 1, self.frame, self.base))
            self.routine, self.pc, self.frame, self.base = self._code.entered
            self._is_mixed = True
        elif why == END and self.stack:
            self.routine, self.pc, self.frame, self.base = self.stack.pop()
        elif why in AFTER:
            self.state = AFTER[why]
        return why, 1 - rest
