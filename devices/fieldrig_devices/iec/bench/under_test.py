"""A program under test: compiled, loaded, and compiled again when a test wants a further instance or mock."""

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from fieldrig.clock import MS, VirtualClock
from fieldrig.errors import ArgumentError, ConfigError, Mistake, RigError
from fieldrig.system.stopwatch import Stopwatch
from fieldrig.text.nearest import closest
from fieldrig_devices.iec.bench.changes import Changes
from fieldrig_devices.iec.bench.mocked import PythonMock
from fieldrig_devices.iec.bench.open_arguments import Shape, shape_of
from fieldrig_devices.iec.bench.owner import Functions
from fieldrig_devices.iec.bench.wrappers import BenchExtension, Call, Calls, Wrapper
from fieldrig_devices.iec.compiler import Compiled, compile_project
from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.loaded import LoadedProgram
from fieldrig_devices.iec.program import Pou, Variable
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.iec.tasks.scheduler import Scheduler
from fieldrig_devices.iec.tasks.task import Task, WorkState
from fieldrig_devices.iec.testing.beginning import begin_program
from fieldrig_devices.iec.testing.compiled import NO_LIMITS
from fieldrig_devices.iec.testing.gathered import with_files_to_give
from fieldrig_devices.iec.testing.judge import Judge
from fieldrig_devices.iec.testing.mocks import Mock, Mocks
from fieldrig_devices.iec.thread import Fault, Thread
from fieldrig_devices.iec.types import BlockType, Type, Value
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.source_file import SourceFile

SLICE_NS: Final = 1_000_000
LONGEST_S: Final = 10.0
"""Time of the host that one call may take: a loop without an end is a fault."""


class UnderTest:
    """The program, its clock and its memory (`owner.Owner`), and the watcher of its tasks (`loaded.Watcher`)."""

    def __init__(self, files: Sequence[SourceFile], dialect: str, resource: str) -> None:
        """ConfigError with every mistake of the program."""
        self._files, self.dialect, self._resource = files, DIALECTS[dialect], resource
        self.clock, judge = VirtualClock(), Judge()
        self._host = StandaloneHost(self.clock)
        self._host.libraries = (judge.library,)
        judge.calls = self._mocked
        self._wrappers: list[Wrapper] = []
        self._mocks: Sequence[Mock] = ()
        self.calls: Mapping[Wrapper, Calls] = {}
        self._shapes: dict[str, Shape] = {}
        self.on_renewed: Callable[[], None] = lambda: None
        """Called when code and places of variables have changed."""
        self.on_method: Callable[[BlockType, int], Functions] = lambda kind, address: {}
        """Called for the methods of an instance that no wrapper has."""
        self._python: dict[str, PythonMock] = {}
        self._raised: BaseException | None = None
        self.events: list[str] = []
        self.changes = Changes()
        self._load(self._compiled(None))

    def _load(self, compiled: Compiled) -> None:
        self.clock.instant_ns = 0
        self._program = LoadedProgram(self.clock, compiled, self._host, self)
        begin_program(self.runtime)
        self._fresh = self.runtime.fresh()
        self._have_tasks_run = False

    @property
    def runtime(self) -> Runtime:
        return self._program.runtime

    @property
    def cells(self) -> list[Value]:
        return self.runtime.memory

    @property
    def now_ns(self) -> int:
        return self.clock.instant_ns

    @property
    def compiled(self) -> Compiled:
        return self._program.compiled

    @property
    def scheduler(self) -> Scheduler:
        return self._program.scheduler

    def start(self) -> None:
        self._have_tasks_run = True
        self.changes.begin(self.now_ns, self.cells)
        self._program.scheduler.start()

    def reset(self) -> None:
        """Begin again at time 0, without mocks."""
        self._python.clear()
        self.begin_again()

    def begin_again(self) -> None:
        """Begin again at time 0.  What knows the places of variables has to look for them again."""
        self.events.clear()
        if self._have_tasks_run:
            self._program.scheduler.end()
            self._load(self.compiled)
        else:
            self.clock.instant_ns = 0
            self._fresh()

    # ---- compiling

    def _compiled(self, previous: Compiled | None) -> Compiled:
        extension = BenchExtension(self._wrappers, list(self._python), self._shapes)
        try:
            compiled = compile_project(
                self._files,
                self._host,
                self.dialect,
                limits=NO_LIMITS,
                previous=None if previous is None else previous.layout,
                resource=self._resource,
                extension=extension,
                in_advance=False,
            )
        except CompileError as wrong:
            told = with_files_to_give(wrong.mistakes, [Path(file.name) for file in self._files], self.dialect)
            raise ConfigError([_mistake(one) for one in told if not one.is_note]) from wrong
        if extension.mocks.unknown:
            name = extension.mocks.unknown[-1]
            raise ArgumentError(f"{name} cannot be mocked", "expected a function or a block with code in the program")
        self._mocks, self.calls = extension.mocks.by_number, extension.calls
        return compiled

    def renew(self, new: Wrapper | None = None) -> None:
        """Compile the program again with a further instance or mock, and go on with all values and forces."""
        self._program.change(self._compiled(self.compiled), lambda: None)
        now, forced = self.runtime.fresh(), dict(self.runtime.forced)
        self._program.cold()
        begin_program(self.runtime)
        self._fresh = self.runtime.fresh()
        started = [] if new is None else self._cells_of(new)
        now()
        if new is not None:
            _, base = self.of_wrapper(new)
            self.cells[base : base + len(started)] = started
        for path, value in forced.items():
            self.runtime.force(self.runtime.find(path), value)
        self.changes.begin(self.now_ns, self.cells)  # variables may be at other places now
        self.on_renewed()

    def _cells_of(self, wrapper: Wrapper) -> list[Value]:
        pou, base = self.of_wrapper(wrapper)
        assert pou.type is not None, "a wrapper is a block"
        return self.cells[base : base + pou.type.size]

    def add(self, wrapper: Wrapper) -> None:
        """Add a wrapper, if it is not there yet."""
        if wrapper in self._wrappers:
            return
        self._wrappers.append(wrapper)
        try:
            self.renew(wrapper)
        except RigError:
            self._wrappers.remove(wrapper)
            raise

    def fit(self, call: Call, name: str, value: Any) -> None:
        """Give an argument of a call the type that a value needs, if the argument has none of its own."""
        if name not in call.opens:
            return
        own, spec = call.opens[name]
        before, shape = self._shapes, shape_of(spec, value, f"{call.shown}.{name}")
        if shape == before.get(own):
            return
        self._shapes = {**before, own: shape}
        try:
            self.renew()
        except RigError:
            self._shapes = before
            raise

    # ---- names

    def functions_at(self, kind: BlockType, address: int, name: str) -> Functions:
        line = (kind.name, *(kind.pou.also if kind.pou is not None else ()))
        if not any(self.dialect.key(f"{one}.{name}") in self.compiled.program.pous for one in line):
            return {}
        return self.on_method(kind, address)

    def pou(self, name: str) -> Pou:
        """Return a unit of the program, or a method such as "Drive.Move".  ArgumentError for an unknown one."""
        pous = self.compiled.program.pous
        pou = pous.get(self.dialect.key(name)) if isinstance(name, str) else None
        if pou is None or (pou.owner is not None and not Mocks.may_be(pou)):
            known = [
                one.name for one in pous.values() if one.owner is None and not one.is_native and " " not in one.name
            ]
            raise ArgumentError(f"the program has no block or function {name!r}", closest(str(name), known))
        return pou

    def declared(self, path: str) -> Variable | None:
        """Return the variable whose declaration has the beginning of a path; None for what is inside a library."""
        first, _, others = path.partition(".")
        key, program = self.dialect.key, self.compiled.program
        found = program.globals.get(key(first))
        pou = program.pous.get(key(first))
        if pou is not None and pou.owner is None and others:
            found = pou.variables.get(key(re.split(r"[.\[]", others)[0]))
        return found

    def of_wrapper(self, wrapper: Wrapper) -> tuple[Pou, int]:
        """Return the block that calls, and the address of its instance."""
        program, key = self.compiled.program, self.dialect.key
        return program.pous[key(wrapper.pou)], program.globals[key(wrapper.instance)].offset

    def variable(self, wrapper: Wrapper, name: str) -> tuple[Type, int]:
        """Return type and address of a variable of the block that calls, or of an argument beside it."""
        pou, base = self.of_wrapper(wrapper)
        key = self.dialect.key(name)
        own = pou.variables.get(key)
        found = self.compiled.program.globals[key] if own is None else own
        return found.type, found.offset if own is None else base + own.offset

    # ---- running

    def runner(self, wrapper: Wrapper, action: str = "") -> Callable[[], None]:
        """Return a function that runs a wrapper, or an action of it, once, with the code of now."""
        pou, base = self.of_wrapper(wrapper)
        thread = self.runtime.thread(pou)
        thread.enter((f"{wrapper.pou}.{action}" if action else wrapper.pou).lower(), base)
        return self.runner_of(thread)

    def runner_of(self, thread: Thread) -> Callable[[], None]:
        """Return a function that runs a thread once.  RigError for a fault, and for a loop without an end."""

        def run() -> None:
            thread.start()
            thread.run(SLICE_NS)
            if thread.state is WorkState.READY:
                watch = Stopwatch()
                while thread.state is WorkState.READY and watch.busy_seconds < LONGEST_S:
                    thread.run(SLICE_NS)
            if thread.state is not WorkState.ENDED:
                self.raise_from_mock()
                fault = thread.fault or thread.fault_here("timeout", f"a loop without an end in {LONGEST_S:g} s")
                raise RigError(str(fault), "the program has the line in brackets")

        return run

    # ---- mocks

    def mock(self, name: str, call: Callable[..., Any]) -> PythonMock:
        """Put a mock in the place of a unit."""
        pou = self.pou(name)
        before, made = self._python.get(pou.name), PythonMock(self, pou.name, call)
        self._python[pou.name] = made
        if any(mock.pou.name == pou.name for mock in self._mocks):
            return made
        try:
            self.renew()
        except RigError:
            del self._python[pou.name]
            if before is not None:
                self._python[pou.name] = before
            raise
        return made

    def _mocked(self, number: int, address: int) -> bool:
        """Answer a call by Python; false if the code of the program is to run."""
        mock = self._mocks[number]
        python = self._python.get(mock.pou.name)
        if python is None or not python.is_on:
            return False
        try:
            python.answer(mock, address)
        except Exception as raised:
            self._raised = raised
            raise ValueError(f"the mock of {mock.pou.name} has raised {raised!r}") from raised
        return True

    def raise_from_mock(self) -> None:
        """Raise what a mock has raised, in the test."""
        if self._raised is not None:
            raised, self._raised = self._raised, None
            raise raised

    # ---- for the program

    def on_transgression(self, task: Task, elapsed_ns: int, *, is_serious: bool) -> None:
        kind = "10 times its cycle time, and has been suspended" if is_serious else "its cycle time"
        self.events.append(f"Task {task.name} has taken {elapsed_ns / MS:g} ms, more than {kind}.")

    def on_fault(self, task: Task, fault: Fault) -> None:
        self.events.append(f"Task {task.name} has been suspended by {fault}.")

    def on_halt(self, task: Task) -> None:
        """Nothing: there are no breakpoints."""

    def on_cycle(self, task: Task) -> None:
        self.changes.look(self.now_ns, self.cells)


def _mistake(one: Any) -> Mistake:
    expected = f"expected {one.expected}" if one.expected else ""
    return Mistake(one.file, one.line, "", one.what, "\n".join(filter(None, (expected, one.hint))))
