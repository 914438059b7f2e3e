"""The PLC: the stored program from the boot to its end, and the commands that an operator gives it.

Source: PacDrive manual 3737-3760, 4093-4110, 6430-6436 (digest PD-041, PD-042, PD-051 to PD-056, PD-220, PD-225).  The
three kinds of start: a boot and a reset are warm, RETAIN variables keep their values; a download and a cold start give
all variables their start values.  A hot restart in the middle of a cycle does not exist, because the controller has no
secured clock without a PN-4 module.  Stop and Reset leave outputs and axes as they are.

What an online change cannot do is what CoDeSys V2.3 refuses: a changed task configuration.
"""

import logging
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Final

from fieldrig.clock import US, Clock
from fieldrig.device import Point, Value
from fieldrig.loop.background import Background, Coarse
from fieldrig.real import progress
from fieldrig_devices.iec.beside import HostFacts
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.layout import Layout
from fieldrig_devices.iec.limits import Limits
from fieldrig_devices.iec.loaded import LONGEST_WAIT_NS, NO_GAP, place_of
from fieldrig_devices.iec.symbol_list import symbol_list
from fieldrig_devices.iec.task_points import state_of, task_forms, task_points
from fieldrig_devices.iec.tasks.system_work import IO_MAP_PRIORITY, TCP_PRIORITY, SystemWork
from fieldrig_devices.iec.tasks.task import Task
from fieldrig_devices.iec.thread import Fault, call_hierarchy
from fieldrig_devices.iec.variable_points import Variables
from fieldrig_devices.languages.beside import Beside, text_of
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.refusal import refused
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.max4.configuration.limits import limits_of
from fieldrig_devices.max4.configuration.program_file import PROGRAM_FILE, Container, container_of
from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.max4.messages.diagnosis import LZS
from fieldrig_devices.max4.plc.compiling import Order, compile_container, compile_order
from fieldrig_devices.max4.plc.host import PlcHost
from fieldrig_devices.max4.plc.library import Functions
from fieldrig_devices.max4.plc.loaded import RetainingProgram
from fieldrig_devices.max4.plc.task_reports import TaskReports

if TYPE_CHECKING:
    from fieldrig_devices.max4.controller import Max4

log = logging.getLogger(__name__)

OnDone = Callable[[str], None]
NO_PROGRAM: Final = "there is no program to start: expected a download first"
_EXT: Final = 48
"""Longest external diagnosis of an entry in the log."""


def _nothing(_problem: str) -> None:
    """The result is not needed."""


class Plc:
    """The PLC of one controller."""

    def __init__(self, clock: Clock, controller: "Max4", background: Background) -> None:
        self._clock, self._controller = clock, controller
        self._beside = Beside[Compiled](background)
        self._is_changing = False
        """True while a compiled program waits for the end of a cycle."""
        self.program: RetainingProgram | None = None
        self._variables = Variables(lambda: self.program)
        self.problem = ""
        """Why the stored program is not loaded, or the loaded one not stored; empty if it is, or if there is none."""
        self.last_fault: Fault | None = None
        self.on_cycle_end: Callable[[Task], None] | None = None
        """Called at the end of each cycle of a task, for a recorder."""
        self.on_load: Callable[[], None] = lambda: None
        """Called when another program has been loaded, or the present one has been changed."""
        self.on_stop: Callable[[Task], None] | None = None
        """Called when a task has reached a breakpoint or has been stopped by a fault."""
        self._compiled: tuple[Container, object, Compiled] | None = None
        self._functions = Functions(clock, controller, self)
        self._reports = TaskReports(controller.reports)
        self._system_work = {priority: SystemWork() for priority in (IO_MAP_PRIORITY, TCP_PRIORITY)}
        self._system_tasks = {
            priority: Task(f"system {priority}", work, priority=priority, is_system=True)
            for priority, work in self._system_work.items()
        }

    # ---- loading

    def check_settings(self) -> None:
        """Compile the program of the rig file.  ConfigError with every mistake, by file, line and column."""
        container = self.project()
        if container is None:
            return
        try:
            self._compile(container, self._host())
        except CompileError as cause:
            paths = {path.name: str(path) for path in self._controller.settings.program}
            raise refused(cause, paths) from cause

    def project(self) -> Container | None:
        """The sources that the rig file names, as they are at present; None if it names none."""
        settings = self._controller.settings
        try:
            return container_of(settings.program, settings.dialect, settings.resource) if settings.program else None
        except OSError as cause:
            raise ValueError(f"a source cannot be read: {cause.filename}: {cause.strerror}") from cause

    def boot(self) -> None:
        """Load the stored program, with the tree of the new boot."""
        self.end()
        self.problem = ""
        data = self._controller.project.program
        if not data:
            return
        try:
            container = Container.decode(data)
            self._load(self._compile(container, self._host()), is_cold=False)
        except (ValueError, CompileError) as wrong:
            self.problem = text_of(wrong.mistakes) if isinstance(wrong, CompileError) else str(wrong)
            log.warning("%s: %s", PROGRAM_FILE, self.problem)

    def end(self) -> None:
        """End the program, at power-off or before a boot."""
        self._beside.cancel()
        self._is_changing = False
        self._unload()

    def _unload(self) -> None:
        if self.program is not None:
            self.program.scheduler.end()
            self.program = None
        for work in self._system_work.values():
            work.clear()
        for task in self._system_tasks.values():
            task.renew()
        self._functions.end()

    def download(self, container: Container, on_done: OnDone = _nothing) -> None:
        """Compile a program beside the running one; then stop that, and load this with its start values.

        `on_done` is called with the mistakes, one a line, if it does not compile: the present program goes on.  It is
        called with an empty text when the program has been loaded, and has to store it.
        """
        host = self._host()
        order = self._order(container, host)

        def load(compiled: Compiled) -> None:
            self._compiled = container, (host.objects, host.object_types), compiled
            self._load(compiled, is_cold=True)
            self._controller.renew_points()
            on_done("")

        self._compile_beside(order, load, on_done)

    def change(self, container: Container, on_done: OnDone = _nothing) -> None:
        """Change the running program at the end of a cycle; its variables keep their values (PD-225).

        `on_done` is called as for `download`, with the reason too if there is no instant between the cycles of all
        tasks within LONGEST_WAIT_NS.  ValueError if there is no program.
        """
        program = self.program
        if program is None:
            raise ValueError("an online change needs a program in the controller: expected a download first")
        host = program.host
        order = self._order(container, host, program.compiled.layout)

        def load(compiled: Compiled) -> None:
            if self.program is not program:
                self._refuse("the program has ended before its change", on_done)
            elif task_forms(compiled) != task_forms(program.compiled):
                self._refuse(
                    "the task configuration has changed: expected a download, which stops the program", on_done
                )
            else:
                self._compiled = container, (host.objects, host.object_types), compiled
                self._is_changing = True
                withdraw = program.change(compiled, changed)
                if self._is_changing:
                    self._clock.call_at(self._clock.now_ns() + LONGEST_WAIT_NS, partial(give_up, withdraw))

        def give_up(withdraw: Callable[[], bool]) -> None:
            if withdraw():
                self._is_changing = False
                self._refuse(NO_GAP, on_done)

        def changed() -> None:
            self._is_changing = False
            self.on_load()
            self._controller.renew_points()
            on_done("")

        self._compile_beside(order, load, on_done)

    @property
    def progress(self) -> str:
        """The progress of a program that is not loaded yet; empty if there is none."""
        return "waiting for the end of a cycle" if self._is_changing else self._beside.progress

    def _compile_beside(self, order: Order, load: Callable[[Compiled], None], on_done: OnDone) -> None:
        def on_compiled(found: Compiled | str) -> None:
            if isinstance(found, Compiled):
                self.problem = ""
                load(found)
            else:
                self._refuse(found, on_done)

        self._beside.compile(compile_order, order, order.duration_ns, on_compiled)

    def _refuse(self, problem: str, on_done: OnDone) -> None:
        """Report that a program has not been loaded, which leaves the present one."""
        self.problem = problem
        log.warning("the program was refused: %s", problem)
        self._controller.renew_points()
        self._controller.report(Code.PROGRAM_REFUSED, LZS, problem.partition(": ")[0][:_EXT])
        on_done(problem)

    def _order(self, container: Container, host: PlcHost, previous: Layout | None = None) -> Order:
        settings = self._controller.settings
        return Order(container, HostFacts.of(host), settings.retain, self._limits, previous, settings.costs)

    @property
    def _limits(self) -> Limits:
        return limits_of(self._controller.version)

    def _host(self) -> PlcHost:
        controller = self._controller
        libraries = self._functions.libraries(controller.system)
        return PlcHost(controller.system, libraries, controller.now_ms, self._on_input)

    def _compile(self, container: Container, host: PlcHost) -> Compiled:
        """Compile a program, unless the same one has been compiled for the same objects."""
        known, objects = self._compiled, (host.objects, host.object_types)
        if known is not None and known[:2] == (container, objects):
            return known[2]
        settings, report = self._controller.settings, Coarse(progress.report)
        compiled = compile_container(
            container, host, settings.retain, self._limits, report=report, costs=settings.costs
        )
        self._compiled = container, objects, compiled
        return compiled

    def _load(self, compiled: Compiled, *, is_cold: bool) -> None:
        controller = self._controller
        self._unload()
        self._reports.reset()
        host = self._host()
        self.program = RetainingProgram(
            self._clock, compiled, host, self, controller.ram, controller.disk.section("RETAIN.MAP")
        )
        if is_cold:
            self.program.cold()
        else:
            self.program.warm()
        self.problem, self.last_fault = "", None
        controller.system.process.take = self.program.take
        self.on_load()

    # ---- for tools

    def compile_sources(self, files: Sequence[SourceFile]) -> Compiled:
        """Compile a program for this controller without loading it.  CompileError with every mistake."""
        settings = self._controller.settings
        container = Container(tuple(files), settings.dialect, settings.resource)
        return compile_container(container, self._host(), settings.retain, self._limits, costs=settings.costs)

    def symbol_list(self) -> bytes:
        """The symbols of the loaded program in XML.  ValueError if there is none."""
        if self.program is None:
            raise ValueError("there is no program: expected a download first")
        name = self._controller.name
        return symbol_list(self.program.runtime.symbols, name, name)

    # ---- commands

    @property
    def is_running(self) -> bool:
        return self.program is not None and self.program.scheduler.is_running

    def start(self) -> None:
        """Start the program, or continue it after a stop.  ValueError if there is none."""
        if self.program is None:
            raise ValueError(f"the stored program cannot be loaded\n{self.problem}" if self.problem else NO_PROGRAM)
        self.program.scheduler.start()
        self._controller.report(Code.PROGRAM_STARTED, LZS)

    def stop(self) -> None:
        """Interrupt the program."""
        if self.program is not None:
            self.program.scheduler.stop()

    def reset(self, *, is_cold: bool = False) -> None:
        """End the program, and with it all task errors; the next start is from its beginning."""
        if self.program is None:
            return
        self.program.scheduler.reset()
        self._functions.end()
        if is_cold:
            self.program.cold()
        else:
            self.program.renew()
        self.last_fault = None
        self._reports.reset()

    # ---- the rest of the controller

    def at_priority(self, priority: int, duration_us: int, action: Callable[[], None]) -> None:
        """Do work of the system when it is its turn among the tasks; at once while no program runs."""
        work = self._system_work[priority]
        if self.program is not None and (self.program.scheduler.is_running or work.is_busy):
            work.add(duration_us * US, action)
            self.program.scheduler.release(self._system_tasks[priority])
        else:
            action()

    @property
    def load_percent(self) -> int | None:
        """CycleLoad as measured, or None while no program has been started."""
        if self.program is None or not self.program.scheduler.is_started:
            return None
        return round(100 * self.program.scheduler.share)

    def task_value(self, number: int, name: str) -> Value:
        """A parameter of the IEC Task object with this number, from 0 (PD-029)."""
        program = self.program
        if program is None or number >= len(program.scheduler.tasks):
            return 0
        task = program.scheduler.tasks[number]
        match name:
            case "State":
                return int(program.state(task))
            case "Load":
                return task.load_ns // US
        return task.cycle_ns // US

    def _on_input(self) -> None:
        if self.program is not None:
            self.program.scheduler.look()

    # ---- for the loaded program (`loaded.Watcher`)

    def on_transgression(self, task: Task, elapsed_ns: int, *, is_serious: bool) -> None:
        if is_serious:
            self.last_fault = place_of(task, "cycle time", "the cycle took too long")
        self._reports.transgression(task, elapsed_ns, is_serious=is_serious)

    def on_fault(self, task: Task, fault: Fault) -> None:
        self.last_fault = fault
        self._reports.fault(task, fault)
        if self.on_stop is not None:
            self.on_stop(task)

    def on_halt(self, task: Task) -> None:
        if self.on_stop is not None:
            self.on_stop(task)

    def on_cycle(self, task: Task) -> None:
        if self.on_cycle_end is not None:
            self.on_cycle_end(task)

    # ---- points

    def points(self) -> Iterator[tuple[str, Point]]:
        """The points of the PLC, if there is a program file."""
        program = self.program
        if program is None:
            if self.problem:
                yield "plc/problem", Point(lambda: self.problem, about="why the last program was not loaded")
            return
        yield (
            "plc/state",
            Point(lambda: state_of(self.program), about="ready, running, stopped, or error if a task is suspended"),
        )
        yield "plc/progress", Point(lambda: self.progress, about="progress of a download or an online change")
        yield "plc/problem", Point(lambda: self.problem, about="why the last program was not loaded")
        yield "plc/fault", Point(lambda: self._fault(), about="call hierarchy of the last run-time fault")
        yield "plc/code_size", Point(lambda: self.program.compiled.code_size if self.program else 0, unit="Byte")
        yield "plc/data_size", Point(lambda: self.program.compiled.data_size if self.program else 0, unit="Byte")
        yield from task_points(program, lambda: self.program)

    def variables(self) -> Iterator[tuple[str, Point]]:
        """The variables of the program: those of the project, then those of its programs."""
        return self._variables.points(self._variables.programs())

    def _fault(self) -> str:
        return "" if self.last_fault is None else "\n".join(call_hierarchy(self.last_fault))
