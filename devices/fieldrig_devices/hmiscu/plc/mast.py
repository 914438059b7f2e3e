"""Tasks of a program with a process image and a watchdog.

Source: manual 2315-2320 (SCU-095): inputs are copied before a cycle, outputs after it.  A program with a task
configuration has its own tasks, and each of them does this.  The watchdog counts the virtual processor time that the
cycle itself has taken, so neither a slow host nor another task makes it expire.
"""

from collections.abc import Callable, Sequence

from fieldrig.clock import MS, Alarm, Clock
from fieldrig_devices.hmiscu.settings import MastSettings
from fieldrig_devices.iec import program as ir
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.host import Host
from fieldrig_devices.iec.loaded import LoadedProgram, Watcher
from fieldrig_devices.iec.tasks.programs import Programs, Thread
from fieldrig_devices.iec.tasks.task import Task, WorkState


class MastWork(Programs):
    """The programs of one task."""

    def __init__(self, threads: Sequence[Thread], limit_ns: int, on_begin: Callable[[], None]) -> None:
        """`limit_ns` is the longest processor time of a cycle; 0 for no limit."""
        super().__init__(threads)
        self._limit_ns, self._on_begin = limit_ns, on_begin
        self.spent_ns = 0
        """Processor time of the present cycle."""
        self.is_overrun = False
        """True if the watchdog has ended the present cycle."""

    def begin(self) -> None:
        self.spent_ns, self.is_overrun = 0, False
        self._on_begin()
        super().begin()

    def run(self, budget_ns: int) -> int:
        allowed_ns = min(budget_ns, self._limit_ns - self.spent_ns) if self._limit_ns else budget_ns
        used_ns = allowed_ns - super().run(allowed_ns)
        self.spent_ns += used_ns
        if self._limit_ns and self.spent_ns >= self._limit_ns and self.state is WorkState.READY:
            self.state, self.is_overrun = WorkState.FAULTED, True
        return budget_ns - used_ns


class MastProgram(LoadedProgram):
    """A program whose tasks copy inputs and write outputs."""

    def __init__(
        self,
        clock: Clock,
        compiled: Compiled,
        host: Host,
        watcher: Watcher,
        settings: MastSettings,
        on_begin: Callable[[], None],
    ) -> None:
        self._settings, self._on_begin = settings, on_begin
        super().__init__(clock, compiled, host, watcher)
        for task in self.scheduler.tasks:
            task.is_supervised = False  # the watchdog supervises instead

    def _work(self, threads: Sequence[Thread]) -> Programs:
        return MastWork(threads, self._settings.watchdog_ms * MS, self._on_begin)

    def _interval_ns(self, task: ir.Task) -> int:
        return self._settings.cycle_ms * MS if task.is_default else super()._interval_ns(task)

    def on_fault(self, task: Task) -> None:
        assert isinstance(task.work, MastWork)
        if task.work.is_overrun:
            self._watcher.on_transgression(task, task.work.spent_ns, is_serious=True)
        else:
            super().on_fault(task)


class BlockMast:
    """MAST of a controller without a program, which calls the blocks in each of its cycles."""

    def __init__(self, clock: Clock, cycle_ms: int, on_cycle: Callable[[], None]) -> None:
        self._clock, self._cycle_ns, self._on_cycle = clock, cycle_ms * MS, on_cycle
        self._timer = Alarm(clock)
        self._due_ns = 0
        self.cycles = 0

    def start(self) -> None:
        """Begin with a cycle at the present instant."""
        self._due_ns = self._clock.now_ns()
        self._timer.at(self._due_ns, self._run)

    def stop(self) -> None:
        self._timer.stop()

    def _run(self) -> None:
        # In the raster of the start, so that a late host leaves out cycles and does not shift those that follow.
        self._due_ns += max((self._clock.now_ns() - self._due_ns) // self._cycle_ns, 1) * self._cycle_ns
        self._timer.at(self._due_ns, self._run)
        self.cycles += 1
        self._on_cycle()
