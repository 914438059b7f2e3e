"""The PLC: the stored program from the boot to its end, and the commands that an operator gives it.

Source: PacDrive manual 3737-3760, 4093-4110, 6430-6436 (digest PD-041, PD-042, PD-051 to PD-056, PD-220, PD-225).  The
three kinds of start: a boot and a reset are warm, RETAIN variables keep their values; a download and a cold start give
all variables their start values.  A hot restart in the middle of a cycle does not exist, because the controller has no
secured clock without a PN-4 module.  Stop and Reset leave outputs and axes as they are.
"""

import logging
from collections.abc import Callable, Iterator
from typing import Final, Protocol

from fieldrig.clock import US, Clock
from fieldrig.device import Point, Value
from fieldrig.loop.background import Background
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.controller.downloads import Downloads
from fieldrig_devices.iec.controller.order import Order
from fieldrig_devices.iec.controller.task_points import state_of, task_points
from fieldrig_devices.iec.controller.variable_points import Variables
from fieldrig_devices.iec.symbol_list import symbol_list
from fieldrig_devices.iec.tasks.task import Task
from fieldrig_devices.iec.thread import call_hierarchy
from fieldrig_devices.languages.beside import text_of
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.refusal import refused
from fieldrig_devices.max4.configuration.program_file import PROGRAM_FILE, Container
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.max4.messages.diagnosis import LZS
from fieldrig_devices.max4.plc.compiling import Compiler
from fieldrig_devices.max4.plc.host import PlcHost
from fieldrig_devices.max4.plc.library import Functions
from fieldrig_devices.max4.plc.loaded import RetainingProgram
from fieldrig_devices.max4.plc.retain_store import Ram
from fieldrig_devices.max4.plc.system_tasks import SystemTasks
from fieldrig_devices.max4.plc.task_reports import TaskReports
from fieldrig_devices.max4.project import Project
from fieldrig_devices.max4.reports import Reports
from fieldrig_devices.max4.settings import Max4Settings
from fieldrig_devices.max4.storage.disk import FlashDisk
from fieldrig_devices.max4.system import System

log = logging.getLogger(__name__)

NO_PROGRAM: Final = "there is no program to start: expected a download first"
_EXT: Final = 48
"""Longest external diagnosis of an entry in the log."""


class Owner(Controller, Protocol):
    """The controller, as its PLC sees it."""

    @property
    def system(self) -> System:
        """The system of the present boot."""

    def now_ms(self) -> int:
        """Timer1, without its overflow."""

    def renew_points(self) -> None:
        """Make the points again, because another program has been loaded."""


class Plc:
    """The PLC of one controller."""

    def __init__(
        self,
        clock: Clock,
        owner: Owner,
        settings: Max4Settings,
        project: Project,
        disk: FlashDisk,
        ram: Ram,
        reports: Reports,
        background: Background,
    ) -> None:
        self._clock, self._owner, self._settings, self._project = clock, owner, settings, project
        self._ram, self._maps = ram, disk.section("RETAIN.MAP")
        self.downloads = Downloads(clock, background, self)
        self.program: RetainingProgram | None = None
        self._variables = Variables(lambda: self.program)
        self.problem = ""
        """Why the stored program is not loaded, or the loaded one not stored; empty if it is, or if there is none."""
        self.on_load: Callable[[], None] = lambda: None
        """Called when another program has been loaded, or the present one has been changed."""
        self._compiler = Compiler(settings)
        self._functions = Functions(clock, disk, owner.logger, lambda: self.program)
        self._reports = TaskReports(reports)
        self._system_tasks = SystemTasks()

    # ---- loading

    def check_settings(self) -> None:
        """Compile the program of the rig file.  ConfigError with every mistake, by file, line and column."""
        container = self._project.sources()
        if container is None:
            return
        try:
            self._compiler.compiled(self.order(container))
        except CompileError as cause:
            paths = {path.name: str(path) for path in self._settings.program}
            raise refused(cause, paths) from cause

    def order(self, container: Container) -> Order:
        """Return the order to compile a program for the objects of the present boot."""
        return self._compiler.order(container, self._host())

    def _host(self) -> PlcHost:
        system = self._owner.system
        return PlcHost(system, self._functions.libraries(system), self._owner.now_ms, self._on_input)

    def boot(self) -> None:
        """Load the stored program, with the tree of the new boot."""
        self.end()
        self.problem = ""
        data = self._project.program
        if not data:
            return
        try:
            compiled = self._compiler.compiled(self.order(Container.decode(data)))
            self._load(compiled, is_cold=False)
        except (ValueError, CompileError) as wrong:
            self.problem = text_of(wrong.mistakes) if isinstance(wrong, CompileError) else str(wrong)
            log.warning("%s: %s", PROGRAM_FILE, self.problem)

    def end(self) -> None:
        """End the program, at power-off or before a boot."""
        self.downloads.cancel()
        self._unload()

    def _unload(self) -> None:
        if self.program is not None:
            self.program.scheduler.end()
            self.program = None
        self._system_tasks.clear()
        self._functions.end()

    def _load(self, compiled: Compiled, *, is_cold: bool) -> None:
        self._unload()
        self._reports.reset()
        host = self._host()
        host.connect()
        self.program = program = RetainingProgram(self._clock, compiled, host, self._reports, self._ram, self._maps)
        if is_cold:
            program.cold()
        else:
            program.warm()
        self.problem = ""
        self._owner.system.process.take = program.take
        self.on_load()

    # ---- downloads (`controller.downloads.Plc`)

    def load(self, order: Order, compiled: Compiled) -> None:
        self._compiler.keep(order, compiled)
        self._load(compiled, is_cold=True)
        self._owner.renew_points()

    def present_order(self) -> Order:
        """Return the order to compile the stored program again."""
        return self.order(Container.decode(self._project.program))

    def on_changed(self, order: Order, compiled: Compiled) -> None:
        self._compiler.keep(order, compiled)
        self.problem = ""
        self.on_load()
        self._owner.renew_points()

    def on_refused(self, problem: str) -> None:
        self.problem = problem
        self._owner.renew_points()
        self._owner.report(Code.PROGRAM_REFUSED, LZS, problem.partition(": ")[0][:_EXT])

    # ---- for tools

    def symbol_list(self, name: str) -> bytes:
        """The symbols of the loaded program in XML, for a controller of this name.  ValueError if there is none."""
        if self.program is None:
            raise ValueError("there is no program: expected a download first")
        return symbol_list(self.program.runtime.symbols, name, name)

    @property
    def on_stop(self) -> Callable[[Task], None]:
        return self._reports.on_stop

    @on_stop.setter
    def on_stop(self, action: Callable[[Task], None]) -> None:
        self._reports.on_stop = action

    # ---- commands

    @property
    def is_running(self) -> bool:
        return self.program is not None and self.program.scheduler.is_running

    def start(self) -> None:
        """Start the program, or continue it after a stop.  ValueError if there is none."""
        if self.program is None:
            raise ValueError(f"the stored program cannot be loaded\n{self.problem}" if self.problem else NO_PROGRAM)
        self.program.scheduler.start()
        self._owner.report(Code.PROGRAM_STARTED, LZS)

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
        self._reports.reset()

    # ---- the rest of the controller

    def at_priority(self, priority: int, duration_us: int, action: Callable[[], None]) -> None:
        """Do work of the system when it is its turn among the tasks; at once while no program runs."""
        scheduler = None if self.program is None else self.program.scheduler
        self._system_tasks.do(scheduler, priority, duration_us, action)

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

    # ---- points

    def points(self) -> Iterator[tuple[str, Point]]:
        """The points of the PLC, if there is a program file."""
        program = self.program
        problem = Point(lambda: self.problem, about="why the last program was not loaded")
        if program is None:
            if self.problem:
                yield "plc/problem", problem
            return
        yield (
            "plc/state",
            Point(lambda: state_of(self.program), about="ready, running, stopped, or error if a task is suspended"),
        )
        yield "plc/progress", Point(lambda: self.downloads.progress, about="progress of a download or an online change")
        yield "plc/problem", problem
        yield "plc/fault", Point(lambda: self._fault(), about="call hierarchy of the last run-time fault")
        yield "plc/code_size", Point(lambda: self.program.compiled.code_size if self.program else 0, unit="Byte")
        yield "plc/data_size", Point(lambda: self.program.compiled.data_size if self.program else 0, unit="Byte")
        yield from task_points(program, lambda: self.program)

    def variables(self) -> Iterator[tuple[str, Point]]:
        """The variables of the program: those of the project, then those of its programs."""
        return self._variables.points(self._variables.programs())

    def _fault(self) -> str:
        fault = self._reports.last_fault
        return "" if fault is None else "\n".join(call_hierarchy(fault))
