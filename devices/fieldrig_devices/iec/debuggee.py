"""IEC programs for the debugging service: tasks as threads, POUs as routines, variables by their paths.

Source: PacDrive manual 3737-3785, 4011-4048, 6426-6436 (digest PD-220 to PD-228).  A breakpoint stops the task that
reaches it, and the other tasks go on.  A pause stops all tasks where they are, in the middle of their cycles.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import partial

from fieldrig.clock import MS
from fieldrig.device import Value
from fieldrig.loop.background import Background, Bulk, Failure
from fieldrig_devices.iec import debugged_objects, debugged_scopes, tree
from fieldrig_devices.iec.debug_builds import Order, make
from fieldrig_devices.iec.debugged_scopes import Scope
from fieldrig_devices.iec.elementary import Elementary, Family
from fieldrig_devices.iec.layout import storage
from fieldrig_devices.iec.library.texts import writer
from fieldrig_devices.iec.loaded import LoadedProgram
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.symbols import Symbol, parts
from fieldrig_devices.iec.tasks.programs import Programs
from fieldrig_devices.iec.tasks.task import Phase, Task, TaskState
from fieldrig_devices.iec.thread import Thread
from fieldrig_devices.iec.tokens import KEYWORDS, tokens
from fieldrig_devices.iec.types import EnumType, StringType, Type
from fieldrig_devices.iec.watch import evaluate, expression_of, path_of
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
from fieldrig_devices.languages.resumable import Code

LANGUAGE = "IEC 61131-3"
_ENDS = frozenset({";", ":", "THEN", "DO", "OF", "ELSE", "REPEAT"} | {word for word in KEYWORDS if word[:4] == "END_"})
"""The ends of statements, of the heads of compound ones, and of blocks."""
_BETWEEN = "the task is between two cycles: expected a breakpoint first"


class IecDebuggee(DebuggeeBase):
    """The part of a debuggee that is alike on every controller.  The controller adds its commands."""

    language = LANGUAGE

    def __init__(self, background: Background | None = None) -> None:
        """Prepare breakpoints in the `background`; without one, the device does it itself."""
        super().__init__()
        self._background = background
        self._prepared: Code | None = None
        """The code whose breakpoints are prepared, or being prepared."""

    @property
    @abstractmethod
    def program(self) -> LoadedProgram | None:
        """The program that is loaded."""

    # ---- the program

    @property
    def state(self) -> ProgramState:
        program = self.program
        if program is None:
            return ProgramState.NONE
        states = [self._state(program, task) for task in program.scheduler.tasks]
        for state in (ProgramState.FAILED, ProgramState.PAUSED, ProgramState.RUNNING):
            if state in states:
                return state
        return ProgramState.HELD

    @property
    def files(self) -> Mapping[str, str]:
        program = self.program
        return {} if program is None else {file.name: file.text for file in program.compiled.files}

    def threads(self) -> Sequence[ThreadView]:
        program = self.program
        if program is None:
            return []
        return [
            ThreadView(task.number + 1, task.name, self._state(program, task), _reason(task))
            for task in program.scheduler.tasks
        ]

    @staticmethod
    def _state(program: LoadedProgram, task: Task) -> ProgramState:
        scheduler = program.scheduler
        match task.state(is_started=scheduler.is_started, is_running=scheduler.is_running):
            case TaskState.ERROR:
                return ProgramState.FAILED
            case TaskState.BP | TaskState.STOPPED:
                return ProgramState.PAUSED
            case TaskState.READY | TaskState.NO_TASK if not scheduler.is_started:
                return ProgramState.HELD
        return ProgramState.RUNNING

    def stack(self, thread: int) -> Sequence[Frame]:
        return _thread(self._task(thread)).stack

    def break_at(self, places: Mapping[str, set[int]]) -> Mapping[str, set[int]]:
        runtime = self._loaded().runtime
        lines = runtime.break_at(places)
        if any(lines.values()):
            self._prepare(runtime)
        return lines

    def goes_on(self, file: str, first: int, last: int) -> bool:
        lines = self.files.get(file, "").splitlines()[first - 1 : last]
        scanned = tokens("\n".join(lines), file, self._loaded().compiled.program.dialect, first)
        lines_of_tokens = [position.line for position in scanned.positions[:-1]]
        return spans.goes_on(list(zip(scanned.kinds, lines_of_tokens, strict=False)), last, _ENDS)

    def look_on(self, looks: Looks | None) -> None:
        program = self.program
        if program is None:
            return
        for task in program.scheduler.tasks:
            for thread in program.threads.get(task.name, ()):
                number = task.number + 1
                thread.look_on(None if looks is None else (partial(looks[0], number), partial(looks[1], number)))

    def at(self, thread: int) -> At | None:
        return _thread(self._task(thread)).at

    def halt(self, thread: int) -> bool:
        return _thread(self._task(thread)).halt()

    def _prepare(self, runtime: Runtime) -> None:
        """Make what breakpoints and steps need beside the device, so that its cycles go on."""
        code, order = runtime.code, Order.of(runtime.compiled, runtime.code)
        if self._background is None or self._prepared is code or order.is_small:
            return
        self._prepared = code

        def on_done(builds: Sequence[tuple[int, Bulk]] | Failure) -> None:
            if runtime.code is not code:
                return
            if not isinstance(builds, Failure):
                code.adopt((number, build.data) for number, build in builds)
            runtime.is_preparing = False
            runtime.watch()

        runtime.is_preparing = True
        runtime.watch()
        self._background.run(make, order, on_done, virtual_ns=MS)

    # ---- going on

    def pause(self) -> None:
        program = self._loaded()
        program.scheduler.stop()
        for task in program.scheduler.tasks:
            _thread(task).forget_step()
        self._prepare(program.runtime)

    def go_on(self) -> None:
        """Continue all tasks that are halted by a breakpoint, and all tasks after a pause."""
        scheduler = self._loaded().scheduler
        for task in scheduler.tasks:
            if task.phase is Phase.HALTED:
                _thread(task).go_on()
                scheduler.resume(task)
        if scheduler.is_started and not scheduler.is_running:
            scheduler.start()

    def step(self, thread: int, kind: Step) -> None:
        """Step one task; after a pause, the other tasks go on."""
        scheduler, task = self._loaded().scheduler, self._task(thread)
        stepped = _thread(task)
        if not stepped.stack:
            raise ValueError(_BETWEEN)
        stepped.step(kind)
        if task.phase is Phase.HALTED:
            scheduler.resume(task)
        if not scheduler.is_running:
            scheduler.start()

    # ---- values

    def variables(self, path: str) -> Sequence[Variable]:
        program = self._loaded()
        if path.startswith(debugged_scopes.MARK):
            return self._inside(path)
        if path and program.runtime.symbols.find(path) is None:
            parameters = debugged_objects.inside(program.host, path)
            if parameters is not None:
                return parameters
            raise _unknown(program.runtime, path)
        return [self._shown(program.runtime, symbol) for symbol in program.runtime.symbols.children(path)]

    def evaluate(self, text: str, thread: int | None = None, frame: int = 0) -> Variable:
        program = self._loaded()
        if text.startswith(debugged_scopes.MARK):
            return self._shown(program.runtime, self._symbol(text, None))
        expression = expression_of(text)

        def read(path: str) -> Value:
            named = self._named(program, path, thread, frame)
            if named.value is None:
                raise ValueError(f"{path}: {named.about or 'a group of values'}: expected a single value")
            return named.value

        path = path_of(expression, read)
        if path is not None:
            return self._named(program, path, thread, frame)
        value = evaluate(expression, read)
        return Variable(text, text, _TYPES[type(value)], value)

    def _named(self, program: LoadedProgram, path: str, thread: int | None, frame: int) -> Variable:
        """Return a variable, an object, or a parameter of one; variables hide objects of the same name."""
        try:
            return self._shown(program.runtime, self._symbol(path, thread, frame))
        except ValueError:
            parameter = debugged_objects.find(program.host, path)
            other = (
                debugged_objects.shown(program.host, parameter)
                if parameter
                else debugged_objects.group(program.host, path)
            )
            if other is None:
                raise
            return other

    def reader(self, text: str) -> Callable[[], Value | None]:
        runtime = self._loaded().runtime
        compiled, symbol = runtime.compiled, runtime.symbols.find(text)
        slow = super().reader(text)
        if symbol is None or storage(symbol.type) is None:
            return slow

        def read() -> Value | None:
            program = self.program
            if program is None or program.runtime.compiled is not compiled:
                return slow()
            try:
                return program.runtime.read(symbol)
            except ValueError:
                return None

        return read

    def write(self, path: str, value: Value) -> None:
        program = self._loaded()
        parameter = debugged_objects.find(program.host, path)
        if parameter is not None and program.runtime.symbols.find(path) is None:
            debugged_objects.write(program.host, parameter, self._typed(parameter.symbol, value))
            return
        symbol = self._symbol(path, None)
        self._loaded().runtime.write(symbol, self._typed(symbol, value))

    def force(self, path: str, value: Value | None) -> None:
        program = self._loaded()
        if path.startswith(debugged_scopes.MARK):
            raise ValueError(f"{path} cannot be forced: it ends with its call\nexpected a variable of an instance")
        if program.runtime.symbols.find(path) is None and debugged_objects.find(program.host, path) is not None:
            raise ValueError(f"{path} cannot be forced: it is a parameter of the controller\nexpected a variable")
        symbol = self._symbol(path, None)
        self._loaded().runtime.force(symbol, None if value is None else self._typed(symbol, value))

    def forced(self) -> Sequence[Variable]:
        program = self.program
        if program is None:
            return []
        runtime = program.runtime
        return [self._shown(runtime, self._symbol(path, None)) for path in runtime.forced]

    @staticmethod
    def _shown(runtime: Runtime, symbol: Symbol) -> Variable:
        value: Value | None = None
        about = symbol.comment
        if storage(symbol.type) is not None:
            try:
                value = runtime.read(symbol)
            except ValueError as cause:
                about = str(cause)
        is_forced = symbol.path in runtime.forced
        text = "" if value is None else _text(symbol.type, value)
        return Variable(symbol.path, symbol.name, str(symbol.type), value, symbol.is_writable, is_forced, about, text)

    def _symbol(self, path: str, thread: int | None, frame: int = 0) -> Symbol:
        """Find a variable in the scope of a thread's place, or else by its path from the root."""
        if path.startswith(debugged_scopes.MARK):
            thread, frame, path = debugged_scopes.parts_of(path)
        runtime = self._loaded().runtime
        symbol = self._local(path, thread, frame) if thread is not None else None
        symbol = symbol or runtime.symbols.find(path)
        if symbol is None:
            raise _unknown(runtime, path)
        return symbol

    def _local(self, path: str, thread: int, frame: int) -> Symbol | None:
        if frame == 0 and not _thread(self._task(thread)).stack:
            return None
        scope = self._scope(thread, frame)
        return None if scope is None else scope.find(path)

    def _scope(self, thread: int, frame: int) -> Scope | None:
        return Scope.of(self._loaded().runtime, _thread(self._task(thread)), thread, frame)

    def _inside(self, path: str) -> Sequence[Variable]:
        """Return the variables of a frame, or the parts of one of them."""
        runtime = self._loaded().runtime
        thread, frame, rest = debugged_scopes.parts_of(path)
        if rest:
            inside = parts(self._symbol(path, None))
            return [self._shown(runtime, part) for part in inside if part.name[:1] != "$"]
        scope = self._scope(thread, frame)
        return [] if scope is None else [self._shown(runtime, symbol) for symbol in scope.symbols()]

    @staticmethod
    def _typed(symbol: Symbol, value: Value) -> Value:
        """Return a value for a variable; a text may be a constant of the language."""
        if not isinstance(value, str):
            return value
        kind = symbol.type
        if isinstance(kind, StringType) and value[:1] not in ('"', "'"):
            return value
        if isinstance(kind, EnumType):
            numbers = {name.casefold(): number for name, number in kind.values.items()}
            if value.casefold() in numbers:
                return numbers[value.casefold()]
        expected = f"{symbol.path}: expected a constant of type {kind}, got {value!r}"
        try:
            expression = expression_of(value)
        except ValueError as wrong:
            raise ValueError(f"{expected} ({wrong})") from wrong
        match expression:
            case tree.Literal(value=constant):
                return constant
            case tree.Unary(operator="-" | "+"):
                return evaluate(expression, _no_variables)
        raise ValueError(expected)

    # ---- the rest

    def _loaded(self) -> LoadedProgram:
        program = self.program
        if program is None:
            raise ValueError("there is no program: expected a download first")
        return program

    def _task(self, thread: int) -> Task:
        tasks = self._loaded().scheduler.tasks
        if not 1 <= thread <= len(tasks):
            raise ValueError(f"expected a task from 1 to {len(tasks)}, got {thread}")
        return tasks[thread - 1]


def _unknown(runtime: Runtime, path: str) -> ValueError:
    meant = runtime.symbols.closest(path)
    return ValueError(f"{path} is not a variable of the program" + (f"; did you mean {meant}?" if meant else ""))


def _text(kind: Type, value: Value) -> str:
    """Return a time, a date, a REAL, or the name of a value of an enumeration; empty for any other value."""
    match kind:
        case EnumType():
            return next((name for name, number in kind.values.items() if number == value), "")
        case Elementary() if kind is Elementary.REAL or kind.family in (Family.TIME, Family.DATE):
            return writer(kind)(value)
    return ""


_TYPES = {bool: "BOOL", int: "DINT", float: "LREAL", str: "STRING"}


def _no_variables(path: str) -> Value:
    raise ValueError(f"expected a constant, got {path}")


def _thread(task: Task) -> Thread:
    """Return the program that a task is in, or begins with."""
    work = task.work
    assert isinstance(work, Programs)
    thread = work.present
    assert isinstance(thread, Thread)
    return thread


def _reason(task: Task) -> str:
    fault = _thread(task).fault
    return "" if fault is None else str(fault)
