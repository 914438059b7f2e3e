"""A task: what it runs, when its cycles begin, and what has been measured of them.

Source: PacDrive manual 3113-3311 (digest PD-060 to PD-075).  The figure with the transitions between the states is
lost; only their values and meanings remain.  Our reading: a task is READY until the program is started and after a
reset; then a cyclic task is CRUNNING, a free-running one is RUNNING, and an event task is RUNNING from its event to the
end of its cycle, and FINISHED until the next event.
"""

from collections.abc import Callable
from enum import Enum, IntEnum, auto
from typing import Final, Protocol

from fieldrig.clock import NEVER_NS, US
from fieldrig_devices.iec.host import Pending
from fieldrig_devices.iec.program import TaskKind

TICK_NS: Final = 250 * US
"""The system clock (PD-082), which is also the time slice of equal priorities and the longest chunk."""
LOWEST_PRIORITY: Final = 31
SERIOUS: Final = 10
"""Number of cycle times after which a task is suspended (PD-074)."""


class TaskState(IntEnum):
    """Values of the parameter State (manual table 5-1)."""

    NO_TASK = 0
    READY = 1
    RUNNING = 2
    CRUNNING = 3
    STOPPED = 4
    BP = 5
    ERROR = 6
    FINISHED = 7


class WorkState(Enum):
    """The state of the work of one cycle after a chunk."""

    READY = auto()
    """There is more to do."""
    WAITING = auto()
    """It waits for `wake`, without taking processor time."""
    STOPPED = auto()
    """It has reached a breakpoint."""
    ENDED = auto()
    FAULTED = auto()


class Work(Protocol):
    """The work that a task does in each of its cycles."""

    @property
    def state(self) -> WorkState: ...

    @property
    def wake(self) -> Pending | None:
        """The answer that the work waits for, while it is WAITING."""

    def begin(self) -> None:
        """Begin a new cycle."""

    def run(self, budget_ns: int) -> int:
        """Run for at most this processor time, and return the rest of it; below 0 if a little more was used."""


class Phase(Enum):
    """The place of a task on its way through a cycle."""

    IDLE = auto()
    """It waits for the begin of its next cycle."""
    RELEASED = auto()
    """Its cycle is due and has not begun."""
    ACTIVE = auto()
    """It is in a cycle."""
    WAITING = auto()
    """It is in a cycle and waits for an answer."""
    HALTED = auto()
    """It is in a cycle, at a breakpoint."""
    ERROR = auto()


class Task:
    """One task of a scheduler."""

    def __init__(
        self,
        name: str,
        work: Work,
        *,
        priority: int,
        kind: TaskKind = TaskKind.CYCLIC,
        interval_ns: int = 0,
        event: Callable[[], bool] | None = None,
        is_system: bool = False,
    ) -> None:
        """`event` returns the level of the variable whose rising edge starts an event task.

        A task of the system goes on while the program is stopped, and begins a cycle only by `Scheduler.release`.
        """
        self.name, self.work, self.priority, self.kind = name, work, priority, kind
        self.interval_ns = interval_ns
        self.event, self.is_system = event, is_system
        self.number = 0
        """The position in the task configuration, from 0."""
        self.is_supervised = kind is TaskKind.CYCLIC and not is_system
        self.check_ns = 0
        """The time that replaces the interval in the supervision, by CycleCheckTimeSet; 0 for the interval itself."""
        self.phase = Phase.IDLE
        self.cycles = 0
        self.cycle_ns = 0
        """Time between the last two begins of a cycle (`cycle` in the manual)."""
        self.load_ns = 0
        """Duration of the last cycle from its begin to its end, with all interruptions (`load` in the manual)."""
        self.cpu_ns = 0
        """Processor time since the program was loaded."""
        self.debt_ns = 0
        """Processor time that the present cycle has used and not paid yet."""
        self.order = 0
        """Position among ready tasks of the same priority; the scheduler sets it."""
        self.slice_ns = TICK_NS
        """The rest of the time slice."""
        self.nominal_ns = 0
        """The instant of the grid at which the present or next cycle is due."""
        self.begin_ns = 0
        self.deadline_ns = NEVER_NS
        """The instant at which the supervision looks at the present cycle next."""
        self.was_minor = False
        """True if the present cycle has been reported as a cycle time transgression."""
        self.was_high = False
        """The last level of the event."""
        self.waits_for: Pending | None = None
        """The answer whose arrival makes it ready."""
        self.halted_ns = 0
        """The instant at which it reached a breakpoint."""

    def state(self, *, is_started: bool, is_running: bool) -> TaskState:
        """The state, while the program has been started (and not reset since), and runs (is not stopped)."""
        match self.phase:
            case Phase.ERROR:
                return TaskState.ERROR
            case Phase.HALTED:
                return TaskState.BP
        if not is_started:
            return TaskState.READY
        if not is_running:
            return TaskState.STOPPED
        match self.kind:
            case TaskKind.CYCLIC:
                return TaskState.CRUNNING
            case TaskKind.FREE:
                return TaskState.RUNNING
        if self.phase is not Phase.IDLE:
            return TaskState.RUNNING
        return TaskState.FINISHED if self.cycles else TaskState.READY

    @property
    def limit_ns(self) -> int:
        """The cycle time that the supervision compares with."""
        return self.check_ns or self.interval_ns

    def renew(self) -> None:
        """Forget the cycles so far, before a start from the beginning."""
        self.phase = Phase.IDLE
        self.cycles = self.cycle_ns = self.load_ns = self.check_ns = self.debt_ns = 0
        self.was_minor = self.was_high = False
        self.waits_for = None
        self.deadline_ns = NEVER_NS
