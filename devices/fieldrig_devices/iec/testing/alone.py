"""A program with its tests, without a controller: its memory, which is fresh in each test, its tasks, and its clock."""

from collections.abc import Callable, Iterable, Iterator

from fieldrig.clock import MS
from fieldrig_devices.iec.layout import DATA
from fieldrig_devices.iec.loaded import LoadedProgram
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.tasks.task import Task
from fieldrig_devices.iec.testing.beginning import begin_program
from fieldrig_devices.iec.testing.compiled import Tested
from fieldrig_devices.iec.testing.extension import CaseBlock
from fieldrig_devices.iec.thread import Fault

LOOK_NS = 1 * MS
"""The time between two looks at an expectation, if the program has no tasks whose cycles end."""


class TaskFaultError(Exception):
    """A task of the program has been suspended."""

    def __init__(self, task: str, fault: Fault) -> None:
        super().__init__(f"the task {task} was suspended by {fault}")
        self.fault = fault


class Alone:
    """The world of a test without a rig (`judge.World`), and the watcher of its program (`loaded.Watcher`)."""

    def __init__(self, tested: Tested) -> None:
        self._tested = tested
        self.is_pressed: Callable[[], None] = lambda: None
        """Called now and then while time passes; it raises if the test takes too long."""
        self._load()

    def _load(self) -> None:
        tested = self._tested
        tested.clock.instant_ns = 0
        self._program = LoadedProgram(tested.clock, tested.compiled, tested.host, self)
        begin_program(self.runtime)
        self._fresh = self.runtime.fresh()
        layout, key = tested.compiled.layout, tested.compiled.program.dialect.key
        slots = {block.instance: layout.slots[key(block.instance)] for block in tested.blocks}
        self._own = {name: range(slot.address, slot.address + slot.size) for name, slot in slots.items()}
        self._shared = list(_between(DATA, layout.end, self._own.values()))
        self._is_used = False
        tested.judge.use(tested.assertions, self.runtime.memory)

    @property
    def runtime(self) -> Runtime:
        return self._program.runtime

    @property
    def now_ns(self) -> int:
        return self._tested.clock.instant_ns

    def begin(self, block: CaseBlock) -> None:
        """Give all variables their start values, at the time 0; no test uses those of another one."""
        self._look: Callable[[], bool] | None = None
        self._fault: TaskFaultError | None = None
        if self._is_used:
            self._program.scheduler.end()
            self._load()
        else:
            self._tested.clock.instant_ns = 0
            self._fresh((*self._shared, self._own[block.instance]))

    def fault(self, where: str, fault: str) -> None:
        raise ValueError("there is no rig that could have a fault: expected RIG 'file.yaml' in the test")

    def clear_faults(self, where: str) -> None:
        self.fault(where, "")

    # ---- time

    def run_until(self, until_ns: int) -> None:
        """Let time pass in which nothing runs."""
        self._tested.clock.instant_ns = max(until_ns, self.now_ns)

    def run_tasks(
        self, until_ns: int, look: Callable[[], bool] | None = None, _reads: frozenset[str] | None = None
    ) -> None:
        """Let the tasks run; call `look` after each of their cycles, until it is false, and at the end."""
        clock, scheduler = self._tested.clock, self._program.scheduler
        self._is_used, self._look = True, look
        has_tasks = bool(scheduler.tasks)
        scheduler.start()
        while self.now_ns < until_ns and (look is None or self._look is not None):
            clock.advance_to(min(until_ns, self.now_ns + LOOK_NS))
            self._check()
            self.is_pressed()
            if not has_tasks:
                self._looked()
        if self._look is not None:
            self._looked()
        scheduler.stop()

    def _looked(self) -> None:
        if self._look is not None and not self._look():
            self._look = None

    def _check(self) -> None:
        if self._fault is not None:
            raise self._fault

    # ---- for the program

    def on_transgression(self, task: Task, elapsed_ns: int, *, is_serious: bool) -> None:
        """Nothing: a long cycle is seen in what it does."""

    def on_fault(self, task: Task, fault: Fault) -> None:
        self._fault = TaskFaultError(task.name, fault)

    def on_halt(self, task: Task) -> None:
        """Nothing: a test has no breakpoints."""

    def on_cycle(self, task: Task) -> None:
        self._looked()


def _between(first: int, end: int, ranges: Iterable[range]) -> Iterator[range]:
    """Yield the addresses that are in none of the ranges."""
    for one in sorted(ranges, key=lambda one: one.start):
        if one.start > first:
            yield range(first, one.start)
        first = max(first, one.stop)
    if end > first:
        yield range(first, end)
