"""One thread of a loaded program: a POU that a task runs from its beginning to its end in each of its cycles."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Final

from fieldrig_devices.iec.host import Pending
from fieldrig_devices.iec.layout import stack_of
from fieldrig_devices.iec.natives import NOTHING, Waiting
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.languages.debugging.debuggee import At, Frame, Step
from fieldrig_devices.languages.debugging.stepping import Goal
from fieldrig_devices.languages.faults import RunError
from fieldrig_devices.languages.task import Task, TaskState

if TYPE_CHECKING:
    from fieldrig_devices.iec.runtime import Runtime


class Start(Enum):
    COLD = "cold"
    WARM = "warm"


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault of the program: a division by zero, an index outside its array, a pointer to nothing, and so on."""

    code: str
    text: str
    pou: str
    file: str
    line: int
    calls: tuple[Frame, ...]
    """The calls that led there, innermost first."""

    def __str__(self) -> str:
        return f"{self.text} in {self.pou} ({self.file}:{self.line})"


def call_hierarchy(fault: Fault) -> Sequence[str]:
    """The components that were running, the one at which the processing stands last (PacDrive manual 4117)."""
    return [*map(str, reversed(fault.calls)), f"{fault.pou} ({fault.file}:{fault.line})"]


_STATES: Final = {
    TaskState.IDLE: WorkState.ENDED,
    TaskState.READY: WorkState.READY,
    TaskState.STOPPED: WorkState.STOPPED,
    TaskState.ENDED: WorkState.ENDED,
    TaskState.TOO_DEEP: WorkState.FAULTED,
    TaskState.FAULTED: WorkState.FAULTED,
}


class Thread:
    def __init__(self, runtime: "Runtime", pou: str, task_number: int) -> None:
        self._runtime, self.pou, self._stack = runtime, pou, stack_of(task_number)
        self._waiting: Waiting = NOTHING
        self._goal: Goal | None = None
        """The end of the step in progress."""
        self._has_stepped = False
        self._is_crossing = False
        """True from the end of a cycle in which a step did not end to the next cycle, where it ends."""
        self.is_watched = runtime.has_breakpoints
        """True if the thread stops at breakpoints."""
        self._task = Task(runtime.code)
        self._looks: tuple[Callable[[], None], Callable[[], None]] | None = None
        self._entry: tuple[str, int] | None = None
        """The routine of the program and the address of its variables, once it has been started."""

    def reload(self) -> None:
        """Use the code of the runtime after an online change; only between two cycles."""
        self._task = Task(self._runtime.code)
        self._waiting, self._goal, self._entry, self._is_crossing = NOTHING, None, None, False
        self.look_on(self._looks)

    # ---- running

    def start(self) -> None:
        """Begin a cycle.  ValueError if the program is no longer there after an online change."""
        if self._entry is None:
            self._entry = self._entry_of_pou()
        self._runtime.take_inputs(self.pou)
        self._runtime.write_forced()
        self._waiting, self._goal = NOTHING, None
        routine, base = self._entry
        self._task.start(routine, self._stack, base)
        self._has_stepped, self._is_crossing = self._is_crossing, False

    def enter(self, routine: str, base: int) -> None:
        """Run a routine on an instance from the next cycle on, instead of a program."""
        self._entry = routine, base

    def _entry_of_pou(self) -> tuple[str, int]:
        program = self._runtime.compiled.program
        pou = program.pous.get(program.dialect.key(self.pou))
        if pou is None or pou.instance is None:
            raise ValueError(f"expected a program of the project, got {self.pou}")
        return self.pou.lower(), pou.instance.offset

    @property
    def state(self) -> WorkState:
        pending = self._waiting[0]
        if pending is not None and not pending.is_done:
            return WorkState.WAITING
        return WorkState.STOPPED if self._has_stepped else _STATES[self._task.state]

    @property
    def is_waiting(self) -> bool:
        return self.wake is not None

    @property
    def wake(self) -> Pending | None:
        """The answer that the thread waits for, if any."""
        pending, _ = self._waiting
        return pending if pending is not None and not pending.is_done else None

    def run(self, budget_ns: int) -> int:
        """Run for at most this processor time; return the rest, below 0 if a little more was used."""
        if self.is_waiting or self._has_stepped:
            return budget_ns
        task, natives = self._task, self._runtime.natives
        natives.waiting = self._waiting
        task.is_watched = self.is_watched
        left = task.run(budget_ns) if self._goal is None else self._run_to_goal(self._goal, budget_ns)
        self._waiting = natives.waiting
        if task.has_waited and natives.is_waiting:
            left = max(left, task.unused)
        if task.state is TaskState.ENDED:
            self._runtime.write_forced()
            self._runtime.give_outputs(self.pou)
        return left

    # ---- debugging

    def look_on(self, looks: tuple[Callable[[], None], Callable[[], None]] | None) -> None:
        """Call the first one in front of each instruction, where it may `halt`, and the second one behind it."""
        self._looks = looks
        self._task.ahead, self._task.look = (None, None) if looks is None else looks

    def halt(self) -> bool:
        """Stop in front of the next instruction; false if there is none."""
        return self._task.halt()

    @property
    def at(self) -> At | None:
        """The next instruction; None between two cycles."""
        task, code = self._task, self._runtime.code
        if task.state in (TaskState.IDLE, TaskState.ENDED):
            return None
        lowered, (line, is_beginning) = self._runtime.compiled.code, code.begins(task.routine, task.pc)
        return At(lowered.files[code.names_of_routines[task.routine]], line, len(task.stack), is_beginning)

    def go_on(self) -> None:
        """Continue after a breakpoint or a step."""
        self._goal, self._has_stepped = None, False
        self.forget_step()
        self._task.go_on()

    def forget_step(self) -> None:
        """Do not stop in the next cycle, if a step has gone beyond the end of this one."""
        self._is_crossing = False

    def step(self, kind: Step) -> None:
        """Continue, and stop again in front of another line, perhaps of the next cycle; `run` does the work."""
        self.go_on()
        task = self._task
        self._goal = Goal(kind, task.line, len(task.stack))

    def _run_to_goal(self, goal: Goal, budget_ns: int) -> int:
        """Run one instruction after the other until the step is complete."""
        task = self._task
        task.has_waited = False
        while budget_ns > 0:
            before = (task.routine, task.pc, len(task.stack))
            budget_ns -= task.step()
            if not self._is_ready():
                self._goal, self._is_crossing = None, task.state is TaskState.ENDED
                break
            if (task.routine, task.pc, len(task.stack)) == before and self._runtime.natives.is_waiting:
                task.has_waited, task.unused = True, budget_ns
                break
            is_at_breakpoint = task.is_at_breakpoint and (task.routine, task.pc, len(task.stack)) != before
            if is_at_breakpoint or goal.is_reached(task.line, len(task.stack), is_beginning=task.begins_line):
                self._goal, self._has_stepped = None, True
                break
        return budget_ns

    def _is_ready(self) -> bool:
        return self._task.state is TaskState.READY

    @property
    def stack(self) -> list[Frame]:
        """The place of the thread, then those where its callers go on, innermost first."""
        task = self._task
        if task.state in (TaskState.IDLE, TaskState.ENDED):
            return []
        here = [(task.routine, task.pc), *((caller.routine, caller.pc - 1) for caller in reversed(task.stack))]
        return [self._frame(routine, pc) for routine, pc in here]

    @property
    def frames(self) -> list[tuple[str, int, int]]:
        """The routines of `stack`, each with the addresses of its stack frame and of its instance."""
        task = self._task
        if task.state in (TaskState.IDLE, TaskState.ENDED):
            return []
        lowered, names = self._runtime.compiled.code, self._runtime.code.names_of_routines
        levels = [(task.routine, task.frame, task.base)]
        levels += [(caller.routine, caller.frame, caller.base) for caller in reversed(task.stack)]
        return [(lowered.titles[names[routine]], frame, base) for routine, frame, base in levels]

    def _frame(self, routine: int, pc: int) -> Frame:
        lowered, code = self._runtime.compiled.code, self._runtime.code
        name = code.names_of_routines[routine]
        return Frame(lowered.titles[name], lowered.files[name], code.line(routine, pc))

    @property
    def fault(self) -> Fault | None:
        """Why the thread is FAULTED."""
        if self.state is not WorkState.FAULTED:
            return None
        return self.fault_here(*_reason(self._task.fault))

    def fault_here(self, code: str, text: str) -> Fault | None:
        """Return a fault at the present place, such as that of a cycle that takes too long; None between two cycles."""
        if not self.stack:
            return None
        here, *callers = self.stack
        return Fault(code, text, here.routine, here.file, here.line, tuple(callers))


def _reason(cause: BaseException | None) -> tuple[str, str]:
    match cause:
        case None:
            return "stack", "the stack has no room for another call"
        case RunError():
            return cause.code, cause.text
        case ZeroDivisionError():
            return "division", "a division by zero"
        case IndexError():
            return "pointer", "a pointer to no variable"
        case TypeError() | AttributeError():
            return "pointer", "a pointer or VAR_IN_OUT to a variable of a call that has ended"
    return "arithmetic", "a result outside the range of numbers"
