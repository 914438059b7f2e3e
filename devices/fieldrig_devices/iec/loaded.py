"""A program in the memory of a controller: its run time, and its tasks on the processor.

The controller that it runs on is its watcher; one with retained variables derives a class of its own.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Protocol
from weakref import proxy

from fieldrig.clock import MS, Clock
from fieldrig_devices.iec import program as ir
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.host import Host
from fieldrig_devices.iec.runtime import Runtime, Start
from fieldrig_devices.iec.tasks.programs import Programs
from fieldrig_devices.iec.tasks.scheduler import Scheduler
from fieldrig_devices.iec.tasks.task import Task, TaskState
from fieldrig_devices.iec.thread import Fault, Thread


class Watcher(Protocol):
    """The controller, which hears of faults and of the ends of cycles."""

    def on_transgression(self, task: Task, elapsed_ns: int, *, is_serious: bool) -> None:
        """Called when a cycle has taken too long; after a serious one the task is suspended."""

    def on_fault(self, task: Task, fault: Fault) -> None:
        """Called when a run-time fault has suspended a task."""

    def on_halt(self, task: Task) -> None:
        """Called when a task has reached a breakpoint, or the end of a step."""

    def on_cycle(self, task: Task) -> None:
        """Called at the end of each cycle."""


class LoadedProgram:
    """One program from its download or the boot until the next one."""

    def __init__(self, clock: Clock, compiled: Compiled, host: Host, watcher: Watcher) -> None:
        self.compiled, self.host = compiled, host
        self._watcher = watcher
        self.runtime = Runtime(compiled, host)
        self.threads: dict[str, list[Thread]] = {}
        """The programs of each task, by the name of the task."""
        tasks = [self._task(number, task) for number, task in enumerate(compiled.program.tasks)]
        # It does not keep the program alive, so the memory is free as soon as the controller drops the program.
        self.scheduler = Scheduler(clock, proxy(self), tasks)

    def _task(self, number: int, task: ir.Task) -> Task:
        threads = [self.runtime.thread(pou, number) for pou in task.programs]
        self.threads[task.name] = threads
        return Task(
            task.name,
            self._work(threads),
            priority=task.priority,
            kind=task.kind,
            interval_ns=self._interval_ns(task),
            event=None if task.event is None else self._level(task.event),
        )

    def _work(self, threads: Sequence[Thread]) -> Programs:
        """Return the work of a task; a controller may do more at the begin of its cycles."""
        return Programs(threads)

    def _interval_ns(self, task: ir.Task) -> int:
        return round(task.interval_ms * MS)

    def _level(self, event: ir.Variable) -> Callable[[], bool]:
        location, memory = event.location, self.runtime.memory
        if location is None:
            return lambda: bool(memory[event.offset])
        area = {"I": self.host.inputs, "Q": self.host.outputs, "M": self.runtime.markers}[location.area]
        return lambda: bool(area[location.byte] >> max(location.bit, 0) & 1)

    # ---- variables

    def cold(self) -> None:
        """Give all variables their start values (PD-051)."""
        self.runtime.initialise(Start.COLD)

    def renew(self) -> None:
        """Give all variables but RETAIN variables their start values."""
        self.runtime.initialise(Start.WARM)

    # ---- online change

    def change(self, compiled: Compiled, on_done: Callable[[], None]) -> Callable[[], bool]:
        """Replace the code at the end of a cycle, when no task is within one (PD-225).

        The task configuration has to be the same as before.  Return a function that withdraws the change, and returns
        false if that is too late.
        """
        action = partial(self._change, compiled, on_done)
        self.scheduler.when_quiet(action)
        return partial(self.scheduler.forget, action)

    def _change(self, compiled: Compiled, on_done: Callable[[], None]) -> None:
        self.compiled = compiled
        self.runtime.change(compiled)
        for task, declared in zip(self.scheduler.tasks, compiled.program.tasks, strict=True):
            if declared.event is not None:
                task.event = self._level(declared.event)
        on_done()

    # ---- for the scheduler (`scheduler.Owner`)

    def on_cycle_end(self, task: Task, *, is_quiet: bool) -> None:
        self._watcher.on_cycle(task)

    def on_transgression(self, task: Task, elapsed_ns: int, *, is_serious: bool) -> None:
        self._watcher.on_transgression(task, elapsed_ns, is_serious=is_serious)

    def on_fault(self, task: Task) -> None:
        assert isinstance(task.work, Programs)
        thread = task.work.present
        assert isinstance(thread, Thread)
        assert thread.fault is not None, "a faulted thread has a fault"
        self._watcher.on_fault(task, thread.fault)

    def on_halt(self, task: Task) -> None:
        self._watcher.on_halt(task)

    # ---- views

    def task(self, name: str) -> Task | None:
        return next((task for task in self.scheduler.tasks if task.name.casefold() == name.casefold()), None)

    def state(self, task: Task) -> TaskState:
        return task.state(is_started=self.scheduler.is_started, is_running=self.scheduler.is_running)


def place_of(task: Task, code: str, text: str) -> Fault | None:
    """Return a fault where the program of a task is in its cycle; None between cycles, and for work of the system."""
    thread = task.work.present if isinstance(task.work, Programs) else None
    return thread.fault_here(code, text) if isinstance(thread, Thread) else None
