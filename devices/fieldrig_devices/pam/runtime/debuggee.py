"""Applications of the PAM for the debugging service: tasks as threads, sequences as routines, variables by their names.

A breakpoint stops the item of a task that reaches it, and the others go on.  A pause holds all programs, while pipes
and the ring go on.
"""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from functools import partial

from fieldrig.device import Value
from fieldrig_devices.languages.debugging import spans
from fieldrig_devices.languages.debugging.base import DebuggeeBase
from fieldrig_devices.languages.debugging.debuggee import (
    At,
    Frame,
    Looks,
    ProgramState,
    Step,
    ThreadView,
    Variable,
)
from fieldrig_devices.languages.debugging.stepping import Goal
from fieldrig_devices.languages.task import TaskState
from fieldrig_devices.pam.language.tokens import split
from fieldrig_devices.pam.runtime.debug_values import Values
from fieldrig_devices.pam.runtime.processor import Program
from fieldrig_devices.pam.runtime.runtime import Runtime
from fieldrig_devices.pam.runtime.sequence import TaskItem

LANGUAGE = "PAM"
_ENDS = frozenset({";", "THEN", "ELSE", "LOOP", "OF", "BEGIN", "END_IF", "END_CASE"})
"""The ends of statements, of the heads of compound ones, and of blocks."""


class PamDebuggee(DebuggeeBase):
    """The part of a debuggee that is alike wherever an application runs.  The owner adds its commands."""

    language = LANGUAGE

    def __init__(self) -> None:
        super().__init__()
        self._breakpoints: dict[str, set[int]] = {}
        self._looks: Looks | None = None

    @property
    @abstractmethod
    def runtime(self) -> Runtime | None:
        """The application that is loaded and has been started."""

    def attach(self, runtime: Runtime) -> None:
        """Watch another application; call it when the application has been started."""
        runtime.on_stop = lambda: self.on_stop()
        self.break_at(self._breakpoints)
        self.look_on(self._looks)

    # ---- the program

    @property
    def state(self) -> ProgramState:
        runtime = self.runtime
        if runtime is None:
            return ProgramState.NONE
        if runtime.is_stopped:
            return ProgramState.FAILED
        is_held = any(program.task.state is TaskState.STOPPED for program in runtime.programs)
        return ProgramState.PAUSED if is_held or runtime.is_paused else ProgramState.RUNNING

    @property
    def files(self) -> Mapping[str, str]:
        runtime = self.runtime
        return {} if runtime is None else runtime.program.texts

    def threads(self) -> Sequence[ThreadView]:
        runtime = self.runtime
        if runtime is None:
            return []
        return [
            ThreadView(number, program.name, self._state_of(program, runtime), _about(program, runtime))
            for number, program in enumerate(runtime.programs, 1)
        ]

    @staticmethod
    def _state_of(program: Program, runtime: Runtime) -> ProgramState:
        if runtime.is_stopped:
            is_cause = program.task.state in (TaskState.FAULTED, TaskState.READY) and program.task is runtime.failed
            return ProgramState.FAILED if is_cause else ProgramState.HELD
        if program.task.state is TaskState.STOPPED or (runtime.is_paused and program.is_alive):
            return ProgramState.PAUSED
        return ProgramState.RUNNING if program.is_alive else ProgramState.HELD

    def stack(self, thread: int) -> Sequence[Frame]:
        program = self._program(thread)
        task = program.task
        if task.state in (TaskState.IDLE, TaskState.ENDED):
            return []
        here = [(task.routine, task.pc), *((caller.routine, caller.pc - 1) for caller in reversed(task.stack))]
        return [self._frame(routine, pc) for routine, pc in here]

    def _frame(self, routine: int, pc: int) -> Frame:
        runtime = self._loaded()
        code = runtime.program.code
        file, line = code.place(runtime.code.line(routine, pc))
        return Frame(code.titles[runtime.code.names_of_routines[routine]], file, line)

    def break_at(self, places: Mapping[str, set[int]]) -> Mapping[str, set[int]]:
        self._breakpoints = {file: set(lines) for file, lines in places.items()}
        runtime = self.runtime
        if runtime is None:
            return {file: set() for file in places}
        code = runtime.program.code
        wanted = {code.number_of_line(file, line) for file, lines in places.items() for line in lines}
        stops = {code.place(line) for line in runtime.code.stop_at(wanted)}
        for program in runtime.programs:
            program.task.is_watched = bool(stops)
        return {file: {line for name, line in stops if name == file} for file in places}

    def look_on(self, looks: Looks | None) -> None:
        self._looks, runtime = looks, self.runtime
        for number, program in enumerate(() if runtime is None else runtime.programs, 1):
            task = program.task
            task.ahead, task.look = (
                (None, None) if looks is None else (partial(looks[0], number), partial(looks[1], number))
            )

    def at(self, thread: int) -> At | None:
        task, runtime = self._program(thread).task, self._loaded()
        if task.state in (TaskState.IDLE, TaskState.ENDED):
            return None
        number, is_beginning = runtime.code.begins(task.routine, task.pc)
        file, line = runtime.program.code.place(number)
        return At(file, line, len(task.stack), is_beginning)

    def halt(self, thread: int) -> bool:
        return self._program(thread).task.halt()

    def goes_on(self, file: str, first: int, last: int) -> bool:
        lines = self.files.get(file, "").splitlines()[first - 1 : last]
        tokens = split("\n".join(lines), file).tokens
        places = [(token.text.upper(), token.place.line + first - 1) for token in tokens if token.kind != "end"]
        return spans.goes_on(places, last, _ENDS)

    # ---- going on

    def pause(self) -> None:
        runtime = self._loaded()
        if runtime.is_stopped or runtime.is_paused:
            raise ValueError("the application is not running")
        runtime.is_paused = True

    def go_on(self) -> None:
        """Continue all programs that are at breakpoints, and all programs after a pause."""
        runtime = self._loaded()
        runtime.is_paused = False
        for program in runtime.programs:
            if program.task.state is TaskState.STOPPED:
                program.goal = None
                self._continue(program)

    def _continue(self, program: Program) -> None:
        program.task.go_on()
        self._loaded().go_on(program)

    def step(self, thread: int, kind: Step) -> None:
        """Step one program; after a pause, the others go on."""
        runtime, program = self._loaded(), self._program(thread)
        if not self.stack(thread):
            raise ValueError(f"{program.name} is not running: expected a sequence that is alive")
        task = program.task
        program.goal = Goal(kind, task.line, len(task.stack))
        runtime.is_paused = False
        if task.state is TaskState.STOPPED:
            self._continue(program)

    # ---- values

    @property
    def _values(self) -> Values:
        return Values(self._loaded())

    def variables(self, path: str) -> Sequence[Variable]:
        if path.startswith("@"):
            return self._formals(path)
        return self._values.variables(path)

    def _formals(self, path: str) -> Sequence[Variable]:
        """Return the formal parameters of a routine that runs, by @THREAD:FRAME."""
        thread, _, frame = path[1:].partition(":")
        if not thread.isdecimal() or not frame.isdecimal():
            raise ValueError(f"expected @THREAD:FRAME, such as @1:0, got {path!r}")
        task = self._program(int(thread)).task
        places = [(task.routine, task.frame), *((caller.routine, caller.frame) for caller in reversed(task.stack))]
        if int(frame) >= len(self.stack(int(thread))):
            raise ValueError(f"there is no frame {frame}")
        routine, start = places[int(frame)]
        return self._values.formals(self._loaded().code.names_of_routines[routine], start)

    def evaluate(self, text: str, thread: int | None = None, frame: int = 0) -> Variable:
        item = 0
        if thread is not None:
            item = self._program(thread).task.base
            for formal in self._formals(f"@{thread}:{frame}") if self.stack(thread) else ():
                if formal.name == text:
                    return formal
        return self._values.evaluate(text, item)

    def write(self, path: str, value: Value) -> None:
        self._values.write(path, value)

    def force(self, path: str, value: Value | None) -> None:
        self._values.force(path, value)

    def forced(self) -> Sequence[Variable]:
        return [] if self.runtime is None else self._values.forced()

    # ---- the rest

    def _loaded(self) -> Runtime:
        runtime = self.runtime
        if runtime is None:
            raise ValueError("there is no application: expected a download first")
        return runtime

    def _program(self, thread: int) -> Program:
        programs = self._loaded().programs
        if not 1 <= thread <= len(programs):
            raise ValueError(f"expected a program from 1 to {len(programs)}, got {thread}")
        return programs[thread - 1]


def _about(program: Program, runtime: Runtime) -> str:
    """Return why a program has stopped, or the state of its sequence."""
    if runtime.fault is not None and program.task is runtime.failed:
        return str(runtime.fault)
    if isinstance(program, TaskItem) and program.sequence is not None:
        return f"{program.sequence.name or 'POWERON'} is {program.state.value}"
    return ""
