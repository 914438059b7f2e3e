"""Runs an application: variables, equations, actions and tasks, one basic cycle after the other.

Order of a basic cycle (PAML-401, G-16): the parts take what has come in, pipes flow, connected routines run, then
equations, and actions and tasks in the order of their declarations, and the parts give what goes out.  Programs take no
time, but a cycle has room for a number of statements.  What does not fit goes on in the next cycle (`Limits`).
"""

from collections.abc import Callable, Sequence
from typing import Any, Final

from fieldrig.coverage import collecting
from fieldrig.coverage.marks import HIT
from fieldrig.sandbox import bind, compiled
from fieldrig_devices.languages.resumable import Code
from fieldrig_devices.languages.task import Task
from fieldrig_devices.pam.runtime import arithmetic
from fieldrig_devices.pam.runtime.binding import Binding
from fieldrig_devices.pam.runtime.compiler import Compiled
from fieldrig_devices.pam.runtime.equations import Equations
from fieldrig_devices.pam.runtime.faults import Fault, reason
from fieldrig_devices.pam.runtime.item import Item, Objects, Part, Pending, RoutineRef, Value
from fieldrig_devices.pam.runtime.lower.formulas import Formula
from fieldrig_devices.pam.runtime.lower.lowered import SequenceCode, routine_name
from fieldrig_devices.pam.runtime.processor import Limits, Processor, Program
from fieldrig_devices.pam.runtime.reactions import ActionsItem, Runner
from fieldrig_devices.pam.runtime.readings import Readings
from fieldrig_devices.pam.runtime.schedule import Schedule, Unit
from fieldrig_devices.pam.runtime.sequence import TaskItem
from fieldrig_devices.pam.runtime.services import Services
from fieldrig_devices.pam.runtime.waits import Gate
from fieldrig_devices.pam.runtime.watch import Watch
from fieldrig_devices.pam.runtime.watches import Watches

OVERRUN: Final = "02..F060"
EVENTS_LOST: Final = "07..E023"
EQUATIONS_INSTALLED: Final = "07..M015"
STARTING_POWER_ON: Final = "07..M016"
WORKING: Final = "07..M017"
POWER_ON_COMPLETED: Final = "07..M018"

OnMessage = Callable[[str, Sequence[int], str], None]
"""Takes a system message: its code such as 02..F060, its details, and a text for the debugger."""


def silent(_code: str, _details: Sequence[int], _text: str) -> None:
    """Take no notice of a message."""


class Runtime:
    """The programs of an application; `start` connects it to the objects.

    Implements `item.Kernel` for the objects, and `kernel.ProgramKernel` for the programs.
    """

    def __init__(
        self,
        program: Compiled,
        on_message: OnMessage = silent,
        limits: Limits | None = None,
        readings: Readings | None = None,
    ) -> None:
        self.program, self._on_message, self._limits = program, on_message, limits or Limits()
        self.readings = readings or Readings()
        self.thirds = program.thirds
        """BASIC_PAM_CYCLE in thirds of a millisecond."""
        self._flags = [0, 0]
        self.schedule = Schedule(self._flags)
        self.watches = Watches(program.layout.size)
        self.watches.on_fault = self._on_formula_fault
        statements = self._limits.statements_per_ms * self.thirds // 3
        self.processor = Processor(self.schedule, self.watches, self._flags, statements)
        self.processor.on_fault, self.processor.on_overrun = self._on_fault, self._on_overrun
        self.cells: list[Any] = list(program.layout.start_values())
        """The values of all variables and equations, then the formal parameters."""
        self.items: dict[str, Sequence[Item]] = {}
        """The items of all objects by their names."""
        self.scope: dict[str, Any] = {}
        """The names that generated code sees."""
        self._objects: Objects | None = None
        self._parts: list[Part] = []
        self.services = Services(self, program.code.sites)
        self.gates: dict[tuple[str, str], Gate] = {}
        """The gates of CONDITION DUPL_START (`TaskItem.gate_of`)."""
        self.tasks: list[TaskItem] = []
        self.actions: list[ActionsItem] = []
        self._by_name: dict[tuple[str, int], TaskItem] = {}
        self.is_working = False
        """True when all POWERON parts have finished (PAML-264)."""
        self.is_stopped = False
        """True after a fatal message."""
        self._is_losing_events = False
        """True from the first connected routine that is lost until none is waiting."""
        self.is_paused = False
        """True while a debugger holds all programs."""
        self.fault: Fault | None = None
        self.failed: Task | None = None
        """The task of the program that the fault is in."""
        self.forced: dict[int, Value] = {}
        """Variables that a debugger holds, by their cells: they have these values when a basic cycle begins."""
        self.on_stop: Callable[[], None] = lambda: None
        """Called when a program reaches a breakpoint, has made a step, or stops by a fault."""

    # ---- for objects (`item.Kernel`)

    @property
    def cycle_number(self) -> int:
        """Number of basic cycles since power-on."""
        return self.schedule.cycle

    def touched(self, name: str) -> None:
        self.watches.touched(name)

    def start_routine(self, routine: RoutineRef) -> None:
        """Have a connected routine run, in this basic cycle if its programs have not run yet (PAML-273)."""
        if not routine.routine or self.is_stopped:
            return
        types = self._fitting(routine)
        values = [
            float(value) if value_type == "real" else value
            for value, value_type in zip(routine.arguments, types, strict=True)
        ]
        if (
            self.routines.is_full
        ):  # the application has more events in each cycle than it can handle (manual line 12194)
            if not self._is_losing_events:
                self.report(EVENTS_LOST)
            self._is_losing_events = True
            return
        self._is_losing_events &= not self.routines.is_idle
        self.routines.add(routine_name(routine.routine, types), 0, values)
        self.processor.call()

    def _fitting(self, routine: RoutineRef) -> tuple[Any, ...]:
        """Return the types of arguments for which there is code: those of the arguments, or else the first."""
        known = self.program.code.signatures[routine.routine]
        own = tuple(_TYPES[type(value)] for value in routine.arguments)
        return own if own in known else known[0]

    def report(self, code: str, details: Sequence[int] = ()) -> None:
        self._tell(code, details, "")

    def _tell(self, code: str, details: Sequence[int], text: str) -> None:
        if code[4] == "F":
            self.is_stopped = True
        self._on_message(code, details, text)

    # ---- start

    def start(self, objects: Objects, others: Sequence[Part] = ()) -> None:
        """Connect the programs to all objects of the application, and let the POWERON parts begin."""
        self._objects, self._parts = objects, [objects, *others]
        code = self.program.code
        items = self.items
        for part in self._parts:
            items |= part.items
        numbers = arithmetic.functions(self.readings)
        scope = self.scope = {"M": self.cells, "W": self._flags, **numbers, **self.services.functions()}
        if code.marked.hits:
            collecting.use(code.marked)
            scope[HIT] = code.marked.hits
        scope |= Binding(self, items, self.watches.functions).of(code.uses.table)
        formulas = compiled(code.formulas.source, self.program.names, self.program.rules, "<formulas>")
        functions = bind(formulas, scope)
        self.watches.functions += [functions[formula.function] for formula in code.formulas.table]
        names = {name: value for name, value in scope.items() if name != "__builtins__"}
        self.code = Code(code.routines, names, max(code.stack_size, 1), self.program.rules)
        self.routines = Runner(self, "connected routines", self._frame())
        self._power_on = Runner(self, "power-on actions", self._frame())
        self._make_units()
        self.equations = Equations(self, code.equations, items)
        self.watch = Watch(self, self.program, items, scope)
        """Computes expressions for a debugger."""
        self._begin()

    def cover(self, mark: int) -> None:
        self.program.code.marked.hits[mark] = 1

    def _frame(self) -> int:
        """Return where the formal parameters of another program begin."""
        first = len(self.cells)
        self.cells += [0] * max(self.program.code.stack_size, 1)
        return first

    def _make_units(self) -> None:
        code = self.program.code
        actions = {group.name: group for group in code.actions}
        tasks = {task.name: task for task in code.tasks}
        for name in code.order:
            for item in self.active(name):
                if name in tasks:
                    unit = TaskItem(self, self._by_name, tasks[name], item, self._frame())
                    self.tasks.append(unit)
                    self._by_name[name, item] = unit
                else:
                    self.actions.append(ActionsItem(self, actions[name], item, self._frame()))

    def _begin(self) -> None:
        self.equations.begin()
        if self.equations.has_linked_outputs:
            self.report(EQUATIONS_INSTALLED)
        for unit in self.schedule.units.values():
            unit.begin()
        self.report(STARTING_POWER_ON)
        for part in self.program.code.power_on:
            for item in self.active(part.owner) if part.is_per_item else (0,):
                self._power_on.add(part.routine, item)
        for task in self.tasks:
            first = task.code.power_on
            if first is not None and (first.is_per_item or task.item == 0) and task.start(first):
                task.wake()

    def active(self, name: str) -> Sequence[int]:
        """Return the items of an object, from 0, whose components are on the ring (G-46)."""
        layout = self.program.layout
        numbers, group = range(layout.counts[name]), layout.groups.get(name)
        if group is None or self._objects is None:
            return numbers
        return [number for number in numbers if self._objects.is_active(group, number)]

    # ---- the basic cycle

    def cycle(self) -> None:
        """Run one basic cycle."""
        self.schedule.begin()
        for part in self._parts:
            part.take()
        assert self._objects is not None
        self._objects.flow()
        if not self.is_stopped and not self.is_paused:
            for cell, value in self.forced.items():
                self.poke(cell, value)
            self.processor.begin()
            self._run_programs()
        for part in self._parts:
            part.give()

    def _run_programs(self) -> None:
        self.run_routines()
        self.equations.evaluate()
        if not self.is_working:
            self._finish_power_on()
        self._serve_units()

    def _serve_units(self) -> None:
        while not self.is_stopped:
            unit = self.schedule.next()
            if unit is None:
                return
            unit.serve()
            self.run_routines()

    def _finish_power_on(self) -> None:
        self._power_on.run()
        if not self._power_on.is_idle or any(task.is_alive for task in self.tasks):
            return
        self.is_working = True
        self.report(POWER_ON_COMPLETED)
        self.report(WORKING)
        for unit in self.schedule.units.values():
            if self.readings.events_at_start == "none":
                unit.forget_events()
            self.schedule.enter(unit, self.schedule.cycle)

    def has_stopped(self) -> bool:
        """Return whether the application has just been stopped."""
        return self.is_stopped

    def run_routines(self) -> None:
        """Run the connected routines that wait (PAML-274)."""
        if not self.routines.is_idle and not self.is_stopped:
            self.routines.run()

    def run(self, program: Program) -> None:
        """Run a program until it waits, ends or gives way."""
        self.processor.run(program, gives_way=not self.routines.is_idle)

    def later(self, slot: int, answer: Value | Pending) -> bool:
        """Keep the answer to an inquiry of the present statement; True if it is still under way."""
        return self.services.later(slot, answer)

    def connect(self, blocks: Sequence[Item]) -> None:
        assert self._objects is not None
        self._objects.connect(blocks)

    # ---- for debuggers

    @property
    def programs(self) -> list[Program]:
        """All programs: the items of tasks, then those of actions, and what runs on behalf of the PAM itself."""
        return [*self.tasks, *(group.runner for group in self.actions), self.routines, self._power_on]

    def go_on(self, program: Program) -> None:
        """Have a program continue from a breakpoint in the next basic cycle."""
        owners: list[tuple[Program, Unit]] = [(task, task) for task in self.tasks]
        owners += [(group.runner, group) for group in self.actions]
        for owned, unit in owners:
            if owned is program:
                unit.enter_next()

    def write_input(self, item: Item, path: str, value: Value) -> None:
        """Give an input another value; only an application without a machine can do it."""
        hold = getattr(item, "hold", None)
        if hold is None:
            raise ValueError(f"{path} is an input of the machine: expected a variable or an output")
        hold(value)

    # ---- faults

    def _on_fault(self, program: Program) -> None:
        fault = program.task.fault
        assert fault is not None
        self._fail(*reason(fault), program)

    def _on_overrun(self, program: Program) -> None:
        if self._limits.is_overrun_fatal:
            text = f"the programs do not come to rest after {self.processor.statements} statements in a basic cycle"
            self._fail(OVERRUN, text, program)

    def _fail(self, code: str, text: str, program: Program) -> None:
        task = program.task
        file, line = self.program.code.place(task.line)
        title = self.program.code.titles[self.code.names_of_routines[task.routine]]
        self.failed = task
        self._stop(Fault(code, text, title, file, line))

    def _on_formula_fault(self, cause: BaseException, formula: Formula) -> None:
        self._stop(Fault(*reason(cause), "", formula.place.file, formula.place.line))

    def _stop(self, fault: Fault) -> None:
        if self.is_stopped:
            return
        self.is_stopped, self.fault = True, fault
        self._tell(fault.code, (), str(fault))
        self.on_stop()

    def stop_by(self, code: str, details: Sequence[int], text: str, sequence: SequenceCode) -> None:
        """Stop the application because of an error in its declarations, at a sequence that cannot start."""
        place = sequence.place
        self.is_stopped = True
        self.fault = Fault(code, text, f"{sequence.task}.{sequence.name or 'POWERON'}", place.file, place.line)
        self._tell(code, details, text)
        self.on_stop()

    def on_stopped(self) -> None:
        """A program has reached a breakpoint."""
        self.on_stop()

    def poke(self, cell: int, value: Value) -> None:
        """Write a variable, and look at what waits for it."""
        if self.cells[cell] != value:
            self.cells[cell] = value
            self.watches.changed(cell)


_TYPES: Final = {bool: "flag", int: "integer", float: "real"}
