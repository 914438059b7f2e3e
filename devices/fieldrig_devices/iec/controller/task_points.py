"""The tasks of a program as points."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Final

from fieldrig.clock import US
from fieldrig.device import Point, Value
from fieldrig_devices.iec.loaded import LoadedProgram
from fieldrig_devices.iec.tasks.task import Task, TaskState

_TASK_POINTS: Final[tuple[tuple[str, Callable[[LoadedProgram, Task], Value], str], ...]] = (
    ("state", lambda program, task: int(program.state(task)), ""),
    ("load", lambda _, task: task.load_ns // US, "us"),
    ("cycle", lambda _, task: task.cycle_ns // US, "us"),
    ("cycles", lambda _, task: task.cycles, ""),
    ("cpu", lambda _, task: task.cpu_ns // US, "us"),
    ("priority", lambda _, task: task.priority, ""),
)


def task_points(program: LoadedProgram, present: Callable[[], LoadedProgram | None]) -> Iterator[tuple[str, Point]]:
    """Yield the points of all tasks of `program`, as they are in the program that `present` returns at the reading."""

    def of_task(name: str, read: Callable[[LoadedProgram, Task], Value]) -> Value:
        now = present()
        task = None if now is None else now.task(name)
        return 0 if now is None or task is None else read(now, task)

    for task in program.scheduler.tasks:
        for name, read, unit in _TASK_POINTS:
            yield f"plc/task/{task.name}/{name}", Point(partial(of_task, task.name, read), unit=unit)


def state_of(program: LoadedProgram | None) -> str:
    """Return none, ready, running or stopped; error if a task is suspended."""
    if program is None:
        return "none"
    scheduler = program.scheduler
    if any(program.state(task) is TaskState.ERROR for task in scheduler.tasks):
        return "error"
    return "running" if scheduler.is_running else "stopped" if scheduler.is_started else "ready"
