"""RUN, STOP and HALT of the controller, with a program or without one.

Source: manual 504-505, 553-583, 774 and 1002 (SCU-018, SCU-028, SCU-056, SCU-099): leaving RUN stops all moves.  The
manual does not describe the states of the controller; ours are those of its family.  A run-time fault and an expired
watchdog lead to HALT, which only a reset ends.  Outputs are off outside RUN.

Without a program, MAST calls one instance of each block in every cycle, so masters work them by their pins.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import Enum
from typing import Final, Protocol

from fieldrig.clock import Clock
from fieldrig.device import Point, Value
from fieldrig.loop.background import Background
from fieldrig.points.checks import choice_in
from fieldrig_devices.hmiscu.io import Terminals
from fieldrig_devices.hmiscu.panel import Panel
from fieldrig_devices.hmiscu.plc.compiling import Compiler
from fieldrig_devices.hmiscu.plc.driven import Driven
from fieldrig_devices.hmiscu.plc.library import MakeBlock
from fieldrig_devices.hmiscu.plc.mast import BlockMast, MastProgram
from fieldrig_devices.hmiscu.plc.system import SystemFunctions
from fieldrig_devices.hmiscu.settings import INPUTS, HmiscuSettings
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.controller.downloads import Downloads
from fieldrig_devices.iec.controller.order import Order
from fieldrig_devices.iec.controller.task_points import task_points
from fieldrig_devices.iec.host import Library
from fieldrig_devices.iec.loaded import place_of
from fieldrig_devices.iec.tasks.task import Task
from fieldrig_devices.iec.thread import Fault, call_hierarchy


class PlcState(Enum):
    STOP = "stop"
    RUN = "run"
    HALT = "halt"


class Owner(Protocol):
    """The controller, which has the blocks and the faces."""

    def on_begin(self) -> None:
        """Called after the inputs have been copied."""

    def call_blocks(self) -> None:
        """Call the blocks of a controller without a program, once in each cycle of MAST."""

    def on_cycle(self) -> None:
        """Called after the outputs have been written."""

    def on_state(self, state: PlcState) -> None:
        """Called when the state has changed."""

    def on_program(self) -> None:
        """Called when another program is there, or none."""

    def restart_channels(self) -> None:
        """Give the parameters of the channels their configured values, at a cold or warm start."""


COMMANDS: Final = ("run", "stop", "reset warm", "reset cold")


class Plc:
    """The programs of one controller."""

    def __init__(
        self,
        clock: Clock,
        settings: HmiscuSettings,
        terminals: Terminals,
        owner: Owner,
        make: MakeBlock,
        instances: Mapping[str, str],
        panel: Panel,
        libraries: Sequence[Library],
        background: Background,
    ) -> None:
        """`instances` are the types of the global variables of the channels.  ConfigError if a program is wrong."""
        self._clock, self._settings, self._terminals, self._owner = clock, settings, terminals, owner
        self._panel, self._system = panel, SystemFunctions()
        own = (panel.library(), self._system.library(), *libraries)
        self.compiler = Compiler(clock, settings, (terminals.inputs, terminals.outputs), make, instances, own)
        self.state = PlcState.STOP
        self.problem = ""
        """Why the controller is in HALT, or why a program was refused."""
        self._held = ""
        """Why the controller may not go to RUN; empty if it may."""
        self._goes_on = False
        self.downloads = Downloads(clock, background, self)
        self.on_load: Callable[[], None] = lambda: None
        """Called when another program has been loaded, or the present one has been changed."""
        self.on_stop: Callable[[Task], None] = lambda task: None
        """Called when a task has reached a breakpoint or has been stopped by a fault."""
        self._mast = BlockMast(clock, settings.mast.cycle_ms, self._on_mast)
        compiled = self.compiler.configured()
        self.program = None if compiled is None else self._made(compiled)
        self.driven = Driven(
            lambda: self.program, (name for name, kind in settings.kinds.items() if kind not in INPUTS)
        )

    def _made(self, compiled: Compiled) -> MastProgram:
        program = MastProgram(self._clock, compiled, self.compiler.host, self, self._settings.mast, self._read)
        self.compiler.connect(program)
        return program

    # ---- loading (`controller.downloads.Plc`)

    def unload(self) -> None:
        """Go to STOP without a program."""
        self._drop()
        self._owner.on_program()

    def load(self, _order: Order, compiled: Compiled) -> None:
        """Go to STOP, and take a program with its start values."""
        self._drop()
        self.program = self._made(compiled)
        self._owner.restart_channels()
        self.on_load()
        self._owner.on_program()

    def present_order(self) -> Order:
        """Return the order to compile the present program again."""
        assert self.program is not None, "there is a program"
        return self.compiler.order(self.program.compiled.files)

    def on_changed(self, _order: Order, _compiled: Compiled) -> None:
        self.on_load()
        self._owner.on_program()

    def on_refused(self, problem: str) -> None:
        self.problem = problem

    def _drop(self) -> None:
        self.downloads.cancel()
        if self.state is PlcState.RUN:
            self._leave(PlcState.STOP)
        if self.program is not None:
            self.program.scheduler.end()
            self.program = None
        self.problem = ""
        self._enter(PlcState.STOP)

    # ---- commands

    def command(self, value: Value) -> None:
        """Carry out one of COMMANDS.  ValueError for anything else, and for `run` in HALT."""
        match choice_in(value, COMMANDS):
            case "run":
                self.run()
            case "stop":
                self.stop()
            case word:
                self.reset(is_cold=word == "reset cold")

    def run(self) -> None:
        """Go to RUN.  ValueError in HALT."""
        if self.state is PlcState.HALT:
            raise ValueError(f"the controller is in HALT: {self.problem}\nexpected a reset first")
        if self._held:
            raise ValueError(f"the controller cannot go to RUN: {self._held}\nexpected it to end first")
        if self.state is PlcState.RUN:
            return
        self._enter(PlcState.RUN)
        self._system.restart()
        if self.program is not None:
            self.program.scheduler.start()
        else:
            self._mast.start()

    def start(self) -> None:
        """Go to RUN as the controller starts by itself, or at the end of what holds it."""
        if self._held:
            self._goes_on = True
        else:
            self.run()

    def stop(self) -> None:
        """Go to STOP, which stops all moves and switches the outputs off."""
        if self.state is PlcState.RUN:
            self._leave(PlcState.STOP)

    def reset(self, *, is_cold: bool) -> None:
        """End HALT, and go to STOP with start values; a warm reset keeps RETAIN variables."""
        if self.state is PlcState.RUN:
            self._leave(PlcState.STOP)
        if self.program is not None:
            self.program.scheduler.reset()
            if is_cold:
                self.program.cold()
            else:
                self.program.renew()
        self.problem = ""
        self._owner.restart_channels()
        self._enter(PlcState.STOP)

    def hold(self, why: str) -> None:
        """Leave RUN, and refuse to go there for this reason."""
        self._goes_on = self.state is PlcState.RUN
        self._held = why
        self.stop()

    def release(self, *, is_start: bool) -> None:
        """Go back to RUN if it was there, with start values at a start."""
        self._held = ""
        if is_start:
            self.reset(is_cold=False)
        if self._goes_on:
            self.run()

    def end(self) -> None:
        """End at power-off."""
        self.downloads.cancel()
        self.stop()
        if self.program is not None:
            self.program.scheduler.end()

    def _leave(self, state: PlcState) -> None:
        if self.program is not None:
            self.program.scheduler.stop()
        self._mast.stop()
        self._terminals.fall()
        self._enter(state)

    def _enter(self, state: PlcState) -> None:
        if state is not self.state:
            self.state = state
            self._owner.on_state(state)

    # ---- cycles

    def _on_mast(self) -> None:
        self._read()
        self._owner.call_blocks()
        self._write()

    def _read(self) -> None:
        self._system.begin_cycle()
        self._terminals.take()
        self._panel.take(self._terminals.inputs)
        self._owner.on_begin()

    def _write(self) -> None:
        if self.state is PlcState.RUN:
            self._terminals.give()
            self._panel.give()
            self._owner.on_cycle()

    # ---- for the loaded program (`loaded.Watcher`)

    def on_transgression(self, task: Task, elapsed_ns: int, *, is_serious: bool) -> None:
        limit = self._settings.mast.watchdog_ms
        fault = place_of(task, "watchdog", f"the watchdog of {task.name} has expired")
        where = "" if fault is None else "\n".join([*call_hierarchy(fault), ""])
        self._halt(task, f"{where}the watchdog of {task.name} has expired: a cycle took {limit} ms of processor time")

    def on_fault(self, task: Task, fault: Fault) -> None:
        self._halt(task, "\n".join(call_hierarchy(fault)) + f"\n{fault.text}")

    def _halt(self, task: Task, problem: str) -> None:
        self.problem = problem
        self._leave(PlcState.HALT)
        self.on_stop(task)

    def on_halt(self, task: Task) -> None:
        self.on_stop(task)

    def on_cycle(self, task: Task) -> None:
        self._write()

    # ---- points

    def points(self) -> Iterator[tuple[str, Point]]:
        yield "plc/state", Point(lambda: self.state.value, about="run, stop or halt")
        yield "plc/command", Point(lambda: "", self.command, about=f"write {', '.join(COMMANDS)}")
        yield "plc/problem", Point(lambda: self.problem, about="why it is in HALT, or why a program was refused")
        yield "plc/progress", Point(lambda: self.downloads.progress, about="progress of a download or an online change")
        yield from self._system.points()
        if self.program is None:
            yield "plc/task/MAST/cycles", Point(lambda: self._mast.cycles)
        else:
            yield from task_points(self.program, lambda: self.program)
