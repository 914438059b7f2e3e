"""The user's program on the card: the main program, the interrupt routines, the timers, and debugging.

Source: manual 3.3, 5.1, 5.5, 5.10; digest chapters 10 and 11.  The card calls `tick` in every control loop and then
`run` with a budget (`slices`); a slice always ends between two instructions.  Events are served at the start of a slice
and after each routine, even while the main program waits or is held on a busy axis (digest I-59).  At its END the main
program stops, and so do events; outputs keep their state.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from functools import partial
from typing import Final, Protocol

from fieldrig.coverage import collecting
from fieldrig.coverage.marks import HIT
from fieldrig.coverage.places import Marked
from fieldrig_devices.arp.language.check import DEEPEST_CALL
from fieldrig_devices.arp.runtime.card import Card
from fieldrig_devices.arp.runtime.events import Events
from fieldrig_devices.arp.runtime.instructions import Instructions
from fieldrig_devices.arp.runtime.timers import Timers
from fieldrig_devices.languages.debugging.debuggee import Step
from fieldrig_devices.languages.debugging.stepping import Goal
from fieldrig_devices.languages.instructions import Instruction, Routine
from fieldrig_devices.languages.resumable import Code
from fieldrig_devices.languages.task import Task, TaskState

NO_PROGRAM: Final = 111  # E11: anomalous stop of the user's program
STACK: Final = 112  # E12
_NS_OF_RAW: Final = 1_000_000  # one raw unit of a time is a millisecond


class ProgramState(Enum):
    HELD = auto()  # held at its first instruction
    RUNNING = auto()
    PAUSED = auto()  # paused by a breakpoint or from outside; it can be continued
    ENDED = auto()
    FAILED = auto()


@dataclass(frozen=True, slots=True)
class Place:
    """The instruction that a program executes next."""

    routine: str
    line: int


class _Thread:
    def __init__(self, code: Code) -> None:
        self.task = Task(code)
        self.wake_ns = 0


class Lowering(Protocol):
    @property
    def routines(self) -> Mapping[str, Sequence[Instruction] | Routine]: ...
    @property
    def texts(self) -> Sequence[str]: ...
    @property
    def marked(self) -> Marked: ...


class Executable(Protocol):
    """A compiled program: that of the compiler, or one that another process has prepared."""

    @property
    def main(self) -> str: ...
    @property
    def lowered(self) -> Lowering: ...


class ArpProgram:
    """A compiled program, bound to the tables and instructions of one card."""

    def __init__(self, compiled: Executable, card: Card, source: str = "program") -> None:
        """`source` is the file of the program in reports of coverage."""
        self.compiled, self._card = compiled, card
        self._timers, self._events = Timers(card), Events(card)
        instructions = Instructions(card, self._timers, self._events, compiled.lowered.texts, self._start_wait)
        marked = compiled.lowered.marked
        marked.locate(lambda _: source)
        collecting.use(marked)
        names = {**instructions.names(), HIT: marked.hits}
        self.code = Code(compiled.lowered.routines, names, DEEPEST_CALL + 1)
        self.code.compile()
        self._routine_names = list(compiled.lowered.routines)
        self._main, self._interrupt = _Thread(self.code), _Thread(self.code)
        self._active = self._main
        self.state = ProgramState.HELD
        self.breakpoints: frozenset[int] = frozenset()
        self.on_stop: Callable[[], None] = lambda: None
        """Called when the program pauses at a breakpoint or after a step to another line, and when it fails."""
        self.look: Callable[[], None] | None = None
        """Called after each instruction while points of the card are watched."""
        self.looks: tuple[Callable[[], None], Callable[[], None]] | None = None
        """Called in front of each instruction, where they may `halt` the program, and behind it."""
        self._goal: Goal | None = None

    # ---- run

    def start(self) -> None:
        """Run from the first instruction."""
        self.reset()
        self._main.task.start(self.compiled.main)
        self.state = ProgramState.RUNNING

    def reset(self) -> None:
        """Hold the program at its first instruction, with events and timers disarmed."""
        self._events.reset()
        self._timers.reset()
        self._active, self._goal = self._main, None
        for thread in (self._main, self._interrupt):
            thread.task.start(self.compiled.main)  # so that `place` and `calls` report the first instruction
            thread.task.stop()
            thread.wake_ns = 0
        self.state = ProgramState.HELD

    def tick(self) -> None:
        """Set the flags of expired timers and detect edges of events, once per control loop before `run`."""
        self._timers.tick()
        self._events.sample()

    def run(self, budget: int) -> int:
        """Run one slice.  Returns what is left of the budget: 0 or less if it was used up."""
        now_ns = self._card.now_ns()
        while budget > 0 and self.state is ProgramState.RUNNING:
            thread = self._next_thread()
            if thread.wake_ns > now_ns:
                return budget
            thread.task.ahead, thread.task.look = self._hooks()
            if self._goal is not None:
                thread.task.step()
                budget -= 1
            else:
                budget = thread.task.run(budget)
            self._look_at(thread)
        return budget

    def _hooks(self) -> tuple[Callable[[], None] | None, Callable[[], None] | None]:
        """Return the calls in front of each instruction and behind it."""
        look, looks = self.look, self.looks
        if looks is None:
            return None, look
        ahead, behind = looks
        return ahead, behind if look is None else partial(_both, look, behind)

    def halt(self) -> bool:
        """Stop in front of the next instruction, as at a breakpoint; false if there is none."""
        return self._active.task.halt()

    @property
    def is_within(self) -> bool:
        """True if the program has a next instruction."""
        return self._active.task.state not in (TaskState.IDLE, TaskState.ENDED)

    @property
    def at(self) -> tuple[int, bool]:
        """The line of the next instruction, and whether it is the first one of it."""
        task = self._active.task
        return self.code.begins(task.routine, task.pc)

    def _next_thread(self) -> _Thread:
        if self._active is self._main and (routine := self._events.due()) is not None:
            self._active = self._interrupt
            self._interrupt.wake_ns = 0
            self._interrupt.task.start(self._routine_names[routine])
        return self._active

    def _look_at(self, thread: _Thread) -> None:
        match thread.task.state:
            case TaskState.STOPPED:
                self._pause()
            case TaskState.TOO_DEEP:
                self.state = ProgramState.FAILED
                self._card.fail(STACK)
                self.on_stop()
            case TaskState.ENDED if thread is self._interrupt:
                self._active = self._main
            case TaskState.ENDED:
                self.state = ProgramState.ENDED
            case TaskState.READY if self._is_step_done():
                self._pause()

    def _pause(self) -> None:
        self.state, self._goal = ProgramState.PAUSED, None
        self.on_stop()

    def _is_step_done(self) -> bool:
        """Return whether a step to another line has reached it, or a breakpoint on its way."""
        if self._goal is None or self.state is not ProgramState.RUNNING:
            return False
        task = self._active.task
        is_at_breakpoint = bool(self.code.stops[task.routine][task.pc])
        return is_at_breakpoint or self._goal.is_reached(task.line, len(task.stack), is_beginning=task.begins_line)

    def _start_wait(self, seconds: int) -> None:
        self._active.wake_ns = self._card.now_ns() + seconds * _NS_OF_RAW

    # ---- debugging

    def break_at(self, lines: set[int]) -> set[int]:
        """Stop before these source lines and no others.  Returns the lines that have an instruction."""
        stops = self.code.stop_at(lines)
        self.breakpoints = frozenset(stops)
        for thread in (self._main, self._interrupt):
            thread.task.is_watched = bool(stops)
        return stops

    def pause(self) -> None:
        if self.state is ProgramState.RUNNING:
            self.state = ProgramState.PAUSED

    def go_on(self) -> None:
        """Leave a pause; the next instruction runs even if it has a breakpoint."""
        if self.state is ProgramState.PAUSED:
            self._active.task.go_on()
            self.state, self._goal = ProgramState.RUNNING, None

    def step_to(self, kind: Step) -> None:
        """Leave a pause until another source line is reached; `on_stop` reports it.  Waits take their time."""
        if self.state is ProgramState.PAUSED:
            task = self._active.task
            task.go_on()
            self.state, self._goal = ProgramState.RUNNING, Goal(kind, task.line, len(task.stack))

    def step(self) -> None:
        """Run one instruction while paused, or begin the event that is due.  An unfinished WAIT is not skipped."""
        if self.state is not ProgramState.PAUSED:
            return
        thread = self._next_thread()
        if thread.wake_ns <= self._card.now_ns():
            thread.task.step()
            self._look_at(thread)

    @property
    def place(self) -> Place:
        task = self._active.task
        return Place(self._routine_names[task.routine], task.line)

    @property
    def calls(self) -> list[Place]:
        """Places to which the callers return, outermost first."""
        stack = self._active.task.stack
        return [Place(self._routine_names[routine], self.code.line(routine, pc)) for routine, pc, *_ in stack]


def _both(first: Callable[[], None], second: Callable[[], None]) -> None:
    first()
    second()
