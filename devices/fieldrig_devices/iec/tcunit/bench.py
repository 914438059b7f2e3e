"""Runs the suites of a project in virtual time."""

import sys
from collections.abc import Callable, Iterator
from math import inf
from pathlib import Path
from typing import Final

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.system.stopwatch import Stopwatch
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.layout import MOST_STACKS, STACK_SIZE
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.iec.symbols import Symbol
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.iec.tcunit import library, paths, program
from fieldrig_devices.iec.tcunit.files.library import Files
from fieldrig_devices.iec.tcunit.json.natives import Documents
from fieldrig_devices.iec.tcunit.natives import Natives
from fieldrig_devices.iec.tcunit.project import Sources
from fieldrig_devices.iec.tcunit.session import Parameters, Session
from fieldrig_devices.iec.thread import Fault, Thread
from fieldrig_devices.iec.types import Value
from fieldrig_devices.languages import faults
from fieldrig_devices.languages.resumable import Activation
from fieldrig_devices.languages.writer import Build

LONGEST_NS: Final = 600 * S
"""Virtual time after which suites that have not finished are given up."""
CYCLE_NS: Final = 3_600 * S
"""Processor time of the program that one cycle may take."""
SLICE_NS: Final = 10 * MS
"""Processor time after which the limits are looked at."""
ENDLESS: Final = "the cycle does not end"


class Bench:
    """One program with suites, its clock and its session."""

    def __init__(self, given: Sources) -> None:
        """NothingToRunError if there are no suites; CompileError if nothing of the project compiles."""
        self.clock = VirtualClock()
        self.host = StandaloneHost(self.clock)
        self._watch = Stopwatch()
        self.session = Session(self.clock.now_ns, self._path_of, self._place, busy_s=lambda: self._watch.busy_seconds)
        natives = Natives(self.session)
        self.files = Files()
        documents = Documents()
        self.host.libraries = (natives.library(), self.files.library(), documents.library())
        self.program = program.built(given, self.host)
        compiled = self.program.compiled
        lists = _lists(self.program)
        self.instances = paths.suites(compiled.program, lists)
        """The paths of the suites, and the names of their blocks, by address."""
        # Only one thread runs at a time, so that it may have the stacks of all.
        self.runtime = Runtime(compiled, self.host, MOST_STACKS * STACK_SIZE)
        natives.memory = self.files.disk.memory = self.runtime.contents
        documents.use(self.runtime.contents, compiled.program)
        wanted = paths.told((*given.files, *given.library_files))
        for address, path in paths.texts(compiled.program, lists, wanted, paths.head(given.name)):
            self.runtime.contents.cells[address] = path
        self._tell("_AppInfo.ProjectName", given.name)
        self.session.parameters = self._parameters()
        self.operands: Callable[[str, int, Activation], str] = lambda file, line, at: ""
        """Return the operands of a condition in a line that has failed, for the report."""
        self._links = list(self._linked(given))
        self._threads = [self.runtime.thread(pou) for task in compiled.program.tasks for pou in task.programs]
        self.interval_ns = round(self.program.interval_ms * MS)
        self._cycles = 0
        self.faults: list[str] = []
        """Faults at run time outside of all suites."""

    def run(self, longest_ns: int = LONGEST_NS, limit_s: float = inf) -> None:
        """Run cycles until all suites have finished, at most for this virtual time.

        A suite that has a processor for longer than `limit_s` for each of its tests ends, and the others go on.
        """
        began_s = self._watch.busy_seconds
        while not self.session.is_over and self.clock.now_ns() < longest_ns:
            self.cycle(limit_s)
            self.session.end_slow(limit_s)
            if self._watch.busy_seconds - began_s > limit_s * (1 + self.session.parts):
                break  # what is beside the suites takes the time
            if not self.session.has_run and self.clock.now_ns() > 10 * S:
                break
            self.clock.advance_to(self.clock.now_ns() + self.interval_ns)

    def cycle(self, limit_s: float = inf) -> None:
        """Run one cycle of the programs.  A fault ends the suite that is running, and the others go on."""
        self._count_cycle()
        for output, into in self._links:
            self.runtime.write(into, self.runtime.read(output))
        began_s = self._watch.busy_seconds
        for thread in self._threads:
            thread.start()
            left_ns = CYCLE_NS
            while thread.state is WorkState.READY:
                left_ns -= SLICE_NS - thread.run(SLICE_NS)
                is_beside = self.session.running is None and self._watch.busy_seconds - began_s > limit_s
                if left_ns < 0 or is_beside or self.session.is_stuck(limit_s):
                    self._give_up(thread, str(thread.fault_here("cycle", ENDLESS) or ENDLESS))
                    break
            if thread.state is WorkState.FAULTED:
                self._give_up(thread, _told(thread.fault))

    def _linked(self, given: Sources) -> Iterator[tuple[Symbol, Symbol]]:
        """Yield the outputs of the program with the inputs that get their values, as far as they are compiled."""
        for ends in given.links:
            output, into = (self.runtime.symbols.find(path) for path in ends)
            if output is not None and into is not None and output.is_value and output.type == into.type:
                yield output, into

    def _count_cycle(self) -> None:
        """Tell the program the number of the cycle, which TwinCAT has in `_TaskInfo`."""
        self._cycles += 1
        for name, value in (("CycleCount", self._cycles), ("FirstCycle", self._cycles == 1)):
            self._tell(f"_TaskInfo[1].{name}", value)

    def _tell(self, name: str, value: Value) -> None:
        """Give a variable of TwinCAT its value, if the program has it."""
        symbol = self.runtime.symbols.find(name)
        if symbol is not None:
            self.runtime.write(symbol, value)

    def _give_up(self, thread: Thread, fault: str) -> None:
        if self.session.running is None:
            self.faults.append(fault)
        self.session.give_up(fault)

    # ---- for the session

    def _path_of(self, address: int) -> str:
        return self.instances[address][0] if address in self.instances else f"{address:#x}"

    def file_of(self, path: str) -> Path:
        """Return the file with the block of a suite."""
        block = next((name for known, name in self.instances.values() if known == path), "")
        return Path(next((item.file for item in self.program.items if item.name == block.casefold()), ""))

    def _place(self) -> tuple[str, int, str]:
        """Return the file and the line of the assert that is running, and the operands of its condition."""
        code, lowered = self.runtime.code, self.program.compiled.code
        # A native function is called by generated code, whose frames of Python have the places.
        calls = faults.running(code, Build.FAST, sys._getframe())
        for number, call in reversed(list(enumerate(calls))):
            file = lowered.files[code.names_of_routines[call.routine]]
            if file != library.FILE:
                line = code.line(call.routine, call.pc)
                # The frame of a routine that is inlined in its caller is not known.
                is_inlined = number > 0 and calls[number - 1].frame == call.frame
                return file, line, "" if is_inlined else self.operands(file, line, call)
        return "", 0, ""

    def _parameters(self) -> Parameters:
        return Parameters(
            int(self._constant("MaxNumberOfTestsForEachTestSuite")),
            int(self._constant("MaxNumberOfAssertsForEachTestSuite")),
            bool(self._constant("LogExtendedResults")),
            int(self._constant("TimeBetweenTestSuitesExecution")) * MS,
        )

    def _constant(self, name: str) -> Value:
        """Return a parameter of TcUnit, with the value that the project gives it."""
        known = self.program.compiled.program.globals
        variable = next(known[key] for key in (name.casefold(), f"{library.LIST}.{name}".casefold()) if key in known)
        assert not isinstance(variable.initial, list | dict)
        return variable.initial or 0


def _told(fault: Fault | None) -> str:
    """Return the text of a fault, with the place in the program even if a native function has raised it."""
    if fault is not None and fault.file == library.FILE and fault.calls:
        return f"{fault.text} in {fault.calls[0]}"
    return str(fault)


def _lists(given: program.TestProgram) -> dict[str, str]:
    lists = {}
    for item in given.items:
        if isinstance(item.declaration, tree.Variables) and item.declaration.name:
            lists[item.name] = item.declaration.name
            lists[f"{item.declaration.name}.{item.name}".casefold()] = ""
    return lists
