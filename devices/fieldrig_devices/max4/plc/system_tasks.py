"""Work of the system, such as TCP/IP and the IO map, which takes its turn among the tasks of a program."""

from collections.abc import Callable

from fieldrig.clock import US
from fieldrig_devices.iec.tasks.scheduler import Scheduler
from fieldrig_devices.iec.tasks.system_work import IO_MAP_PRIORITY, TCP_PRIORITY, SystemWork
from fieldrig_devices.iec.tasks.task import Task


class SystemTasks:
    """The tasks of the system, one for each of its priorities."""

    def __init__(self) -> None:
        self._work = {priority: SystemWork() for priority in (IO_MAP_PRIORITY, TCP_PRIORITY)}
        self._tasks = {
            priority: Task(f"system {priority}", work, priority=priority, is_system=True)
            for priority, work in self._work.items()
        }

    def clear(self) -> None:
        """Drop the work that waits, at the end of a program."""
        for work in self._work.values():
            work.clear()
        for task in self._tasks.values():
            task.renew()

    def do(self, scheduler: Scheduler | None, priority: int, duration_us: int, action: Callable[[], None]) -> None:
        """Call `action` when it is its turn among the tasks of this scheduler; at once while no program runs."""
        work = self._work[priority]
        # After a stop the work that waits is still done, and what comes meanwhile must not overtake it.
        if scheduler is not None and (scheduler.is_running or work.is_busy):
            work.add(duration_us * US, action)
            scheduler.release(self._tasks[priority])
        else:
            action()
