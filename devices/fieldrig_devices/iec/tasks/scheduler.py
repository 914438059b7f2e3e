"""The processor of a controller, shared by tasks of 32 priorities in chunks of virtual processor time.

Source: PacDrive manual 3113-3311 (digest PD-060 to PD-086).  A chunk lasts at most 250 us and ends early where a task
of higher priority is known to begin.  What a chunk does happens at its begin; then the processor is busy for as long as
the chunk has taken.  So a task of higher priority that becomes ready unexpectedly waits for the end of the chunk, and
for nothing else.  An instruction that takes longer than a chunk is paid for in several of them.  The real-time process
is above all tasks: its time lengthens the chunk that it interrupts.

Left open by the manual, and chosen here: a free-running task begins its next cycle at the next tick of the system clock
of 250 us; a cyclic task that is late by more than its interval leaves out the cycles in between and returns to the
grid; a rising edge is noticed after any chunk and whenever `look` is called.
"""

from bisect import insort
from collections.abc import Callable, Sequence
from functools import partial
from heapq import heappop, heappush
from typing import Final, Protocol

from fieldrig.clock import MS, NEVER_NS, Alarm, Clock
from fieldrig_devices.iec.host import Pending
from fieldrig_devices.iec.program import TaskKind
from fieldrig_devices.iec.tasks.task import SERIOUS, TICK_NS, Phase, Task, WorkState

SHORTEST_NS: Final = 500
"""Processor time that each chunk takes at least, for the change of tasks."""
LONGEST_OVERRUN_NS: Final = 50_000
"""Processor time beyond its end that the last instruction of a chunk may take; the rest is the task's debt, which it
pays in further chunks, so that a long instruction holds up no task of higher priority."""
WINDOW_NS: Final = 100 * MS
"""The time over which the share of the processor is measured."""
LONGEST_CYCLE_NS: Final = 100 * MS
"""The time without an instant between the cycles of all tasks after which waiting for one makes no sense."""


class Owner(Protocol):
    """The controller, which learns what happens to its tasks."""

    def on_cycle_end(self, task: Task, *, is_quiet: bool) -> None:
        """Called at the end of each cycle; `is_quiet` is true if no task is within a cycle."""

    def on_transgression(self, task: Task, elapsed_ns: int, *, is_serious: bool) -> None:
        """Called when a cycle has taken too long; after a serious one, the task is suspended (PD-073, PD-074)."""

    def on_fault(self, task: Task) -> None:
        """Called when the work of a task has FAULTED; the task is suspended."""

    def on_halt(self, task: Task) -> None:
        """Called when a task has reached a breakpoint."""


class Scheduler:
    """The processor of one controller.  Only tasks of the system run before `start`."""

    def __init__(self, clock: Clock, owner: Owner, tasks: Sequence[Task] = ()) -> None:
        """`tasks` are in the order of the task configuration."""
        self._clock, self._owner = clock, owner
        self.tasks = tuple(tasks)
        for number, task in enumerate(self.tasks):
            task.number = number
        self.current: Task | None = None
        """The task whose chunk the processor is busy with."""
        self.is_running = self.is_started = False
        self.busy_ns = 0
        """Processor time of all tasks and of the real-time process."""
        self._events = [task for task in self.tasks if task.event is not None]
        self._ready: list[Task] = []
        self._sleeping: list[tuple[int, int, Task]] = []
        self._active: list[Task] = []
        """Tasks of the program that are within a cycle."""
        self._active_ns = 0
        """The instant since which there has been such a task."""
        self._is_ended = False
        """True if the present chunk ends a cycle."""
        self._free_ns = self._due_ns = 0
        self._timer = Alarm(self._clock)
        self._order = 0
        self._stopped_ns = 0
        self._on_quiet: list[Callable[[], None]] = []
        self._window_ns = self._window_busy_ns = 0
        self._share: float | None = None

    # ---- the program is started, stopped, reset

    def start(self) -> None:
        """Start all tasks, or continue after `stop`; the time that has passed in between does not count."""
        if self.is_running:
            return
        now_ns = self._clock.now_ns()
        self.is_running = True
        if self.is_started:
            pause_ns = max(now_ns - self._stopped_ns, 0)
            self._sleeping = [(when_ns + pause_ns, number, task) for when_ns, number, task in self._sleeping]
            for task in self.tasks:
                task.nominal_ns += pause_ns
            self._delay(pause_ns)
        else:
            self.is_started, self._share = True, None
            self._window_ns, self._window_busy_ns = now_ns, self.busy_ns
            for task in self.tasks:
                task.nominal_ns = now_ns
                if task.event is None:
                    heappush(self._sleeping, (now_ns, task.number, task))
                else:
                    task.was_high = task.event()
        self._kick()

    def stop(self) -> None:
        """Interrupt all tasks where they are, at the end of the present chunk."""
        if self.is_running:
            self.is_running = False
            self._stopped_ns = max(self._clock.now_ns(), self._free_ns)

    def reset(self) -> None:
        """End all tasks; this is also the end of a suspension after an error."""
        self.is_running = self.is_started = False
        self._ready = [task for task in self._ready if task.is_system]
        self._sleeping.clear()
        self._active.clear()
        if self.current is not None and not self.current.is_system:
            self.current = None
        for task in self.tasks:
            task.renew()
        self._run_quiet()

    def end(self) -> None:
        """End everything, for example at power-off."""
        self.reset()
        self._ready.clear()
        self.current = None
        self._timer.stop()

    def _delay(self, pause_ns: int) -> None:
        """Leave time out of the measurement of the present cycles."""
        for task in self._active:
            task.begin_ns += pause_ns
            task.deadline_ns += pause_ns
        if self._is_ended and self.current is not None:  # its last chunk still takes the processor
            self.current.begin_ns += pause_ns

    # ---- what else happens

    def take(self, duration_ns: int) -> None:
        """Take processor time now, above all priorities: the real-time process."""
        self._free_ns = max(self._free_ns, self._clock.now_ns()) + duration_ns
        self.busy_ns += duration_ns

    def release(self, task: Task) -> None:
        """Let a task of the system begin a cycle, unless it is in one."""
        if task.phase is Phase.IDLE:
            self._make_ready(task, Phase.RELEASED)
            self._kick()

    def look(self) -> None:
        """Look for rising edges of events after a change from outside."""
        if self.is_running and self._look():
            self._kick()

    def resume(self, task: Task) -> None:
        """Continue a task after a breakpoint; the time that it was halted does not count."""
        if task.phase is Phase.HALTED:
            task.begin_ns += self._clock.now_ns() - task.halted_ns
            self._supervise(task)
            self._make_ready(task, Phase.ACTIVE)
            self._kick()

    @property
    def is_quiet(self) -> bool:
        """True if no task is within a cycle."""
        return not self._active

    @property
    def is_crowded(self) -> bool:
        """True if some task has been within a cycle at every instant for a long time."""
        return bool(self._active) and self._clock.now_ns() - self._active_ns >= LONGEST_CYCLE_NS

    def when_quiet(self, action: Callable[[], None]) -> None:
        """Call `action` when no task is within a cycle, which may be at once."""
        if self._active:
            self._on_quiet.append(action)
        else:
            action()

    def forget(self, action: Callable[[], None]) -> bool:
        """Do not call an action of `when_quiet` any more.  Return false if it has been called."""
        is_waiting = action in self._on_quiet
        if is_waiting:
            self._on_quiet.remove(action)
        return is_waiting

    def set_check_time(self, task: Task, check_ns: int) -> None:
        """Supervise a task by this time instead of its interval; 0 returns to the interval (PD-077)."""
        task.check_ns = check_ns
        if task.phase is not Phase.IDLE:
            self._supervise(task)

    @property
    def share(self) -> float:
        """The share of the processor that the tasks and the real-time process took lately, from 0 to 1."""
        passed_ns = self._clock.now_ns() - self._window_ns
        if self._share is None or passed_ns >= WINDOW_NS:
            return self._measured(passed_ns)
        return self._share

    def _measured(self, passed_ns: int) -> float:
        return min((self.busy_ns - self._window_busy_ns) / max(passed_ns, 1), 1.0)

    # ---- the processor

    def _kick(self) -> None:
        """Let the processor look at its tasks as soon as it is free."""
        self._wake_at(max(self._clock.now_ns(), self._free_ns))

    def _wake_at(self, when_ns: int) -> None:
        if when_ns < self._timer.when_ns:
            self._due_ns = when_ns
            self._timer.at(when_ns, self._on_time)

    def _on_time(self) -> None:
        now_ns = self._clock.now_ns()
        if now_ns > self._due_ns:  # a blocked host has left time out
            self._delay(now_ns - self._due_ns)
        if now_ns < self._free_ns:  # the real-time process has taken time
            self._wake_at(self._free_ns)
            return
        task = self.current
        if task is not None:
            self.current = None
            self._end_chunk(task, now_ns)
        if now_ns - self._window_ns >= WINDOW_NS:
            self._share = self._measured(now_ns - self._window_ns)
            self._window_ns, self._window_busy_ns = now_ns, self.busy_ns
        if self.is_running:
            sleeping = self._sleeping
            while sleeping and sleeping[0][0] <= now_ns:
                self._make_ready(heappop(sleeping)[2], Phase.RELEASED)
            if self._active:
                self._check(now_ns)
        task = self._next()
        if task is not None:
            self._chunk(task, now_ns)
        elif self.is_running:
            self._rest()

    def _next(self) -> Task | None:
        """The ready task of the highest priority; while the program is stopped, of the tasks of the system."""
        ready = self._ready
        if self.is_running:
            return ready[0] if ready else None
        return next((task for task in ready if task.is_system), None)

    def _rest(self) -> None:
        """Sleep until the next cycle, or until the supervision looks at a waiting task."""
        next_ns = self._sleeping[0][0] if self._sleeping else NEVER_NS
        for task in self._active:
            next_ns = min(next_ns, task.deadline_ns)
        if next_ns < NEVER_NS:
            self._wake_at(next_ns)

    def _make_ready(self, task: Task, phase: Phase) -> None:
        task.phase = phase
        task.slice_ns = TICK_NS
        self._order += 1
        task.order = self._order
        insort(self._ready, task, key=_key)

    def _chunk(self, task: Task, now_ns: int) -> None:
        """Run a chunk, which has its effects now and keeps the processor busy until `_free_ns`."""
        if task.phase is Phase.RELEASED:
            self._begin_cycle(task, now_ns)
        budget_ns = self._budget(task, now_ns)
        self.current = task
        used_ns = self._pay(task, budget_ns) if task.debt_ns else self._run(task, budget_ns)
        task.cpu_ns += used_ns
        task.slice_ns -= used_ns
        self.busy_ns += used_ns
        self._free_ns = max(self._free_ns, now_ns) + used_ns
        if task.is_system:  # work that takes the host longer than the processor comes after a cycle that is due
            self._free_ns = max(self._free_ns, now_ns + self._clock.late_ns())
        self._is_ended = self.current is task and not task.debt_ns and task.work.state is WorkState.ENDED
        if self._is_ended:
            self._leave(task)
            if not task.is_system:
                self._owner.on_cycle_end(task, is_quiet=not self._active)
        self._wake_at(self._free_ns)

    @staticmethod
    def _run(task: Task, budget_ns: int) -> int:
        """Let a task run, and return the processor time of the chunk."""
        used_ns = max(budget_ns - task.work.run(budget_ns), SHORTEST_NS)
        if used_ns <= budget_ns + LONGEST_OVERRUN_NS:
            return used_ns
        paid_ns = max(budget_ns, SHORTEST_NS)
        task.debt_ns = used_ns - paid_ns
        return paid_ns

    @staticmethod
    def _pay(task: Task, budget_ns: int) -> int:
        """Let a task pay processor time that it has used already, and return how much."""
        paid_ns = max(min(task.debt_ns, budget_ns), SHORTEST_NS)
        task.debt_ns = max(task.debt_ns - paid_ns, 0)
        return paid_ns

    def _budget(self, task: Task, now_ns: int) -> int:
        """The rest of the slice, or the time until a task of higher priority begins."""
        end_ns = now_ns + task.slice_ns
        if self.is_running and self._sleeping and self._sleeping[0][0] < end_ns:  # while stopped, none of them begins
            above = (when_ns for when_ns, _, other in self._sleeping if other.priority < task.priority)
            end_ns = min(end_ns, min(above, default=end_ns))
        return end_ns - now_ns

    def _begin_cycle(self, task: Task, now_ns: int) -> None:
        task.phase = Phase.ACTIVE
        if not task.is_system:
            if not self._active:
                self._active_ns = now_ns
            self._active.append(task)
        if task.cycles:
            task.cycle_ns = now_ns - task.begin_ns
        task.begin_ns, task.was_minor = now_ns, False
        task.work.begin()
        self._supervise(task)

    def _end_chunk(self, task: Task, now_ns: int) -> None:
        """Do what follows from a chunk that has ended now."""
        if self._is_ended:
            self._end_cycle(task, now_ns)
        else:
            self._interrupt(task, now_ns)
        if self._events and self.is_running:
            self._look()
        if self._on_quiet and not self._active:
            self._run_quiet()

    def _interrupt(self, task: Task, now_ns: int) -> None:
        """Put a task aside within its cycle."""
        match WorkState.READY if task.debt_ns else task.work.state:
            case WorkState.READY:
                if task.slice_ns <= 0:  # the next one of this priority
                    self._ready.remove(task)
                    self._make_ready(task, Phase.ACTIVE)
            case WorkState.WAITING:
                self._wait(task)
            case WorkState.STOPPED:
                self._ready.remove(task)
                task.phase, task.halted_ns, task.deadline_ns = Phase.HALTED, now_ns, NEVER_NS
                self._owner.on_halt(task)
            case WorkState.FAULTED:
                self._suspend(task)
                self._owner.on_fault(task)

    def _end_cycle(self, task: Task, now_ns: int) -> None:
        task.load_ns = now_ns - task.begin_ns
        task.cycles += 1
        task.phase = Phase.IDLE
        if task.is_supervised and task.load_ns > task.limit_ns + TICK_NS:
            self._transgress(task, task.load_ns)
        task.deadline_ns = NEVER_NS
        if task.is_system:
            if task.work.state is WorkState.READY:  # a job has arrived during the chunk
                self._make_ready(task, Phase.RELEASED)
        elif task.event is None and task.phase is Phase.IDLE:
            step_ns = TICK_NS if task.kind is TaskKind.FREE else task.interval_ns
            # A free-running task takes a tick behind the present instant, so that there is time for others.  A cyclic
            # one that is late takes the last instant of its grid that has passed, and begins at once (PD-069).
            passed = (now_ns - task.nominal_ns) // step_ns
            task.nominal_ns += step_ns * (passed + 1 if task.kind is TaskKind.FREE else max(passed, 1))
            heappush(self._sleeping, (task.nominal_ns, task.number, task))

    def _wait(self, task: Task) -> None:
        wake = task.work.wake
        if wake is None or wake.is_done:
            return  # it goes on in its turn
        self._ready.remove(task)
        task.phase, task.waits_for = Phase.WAITING, wake
        wake.on_done = partial(self._on_woken, task, wake)

    def _on_woken(self, task: Task, wake: Pending) -> None:
        if task.phase is Phase.WAITING and task.waits_for is wake:  # not after a reset or an error
            self._make_ready(task, Phase.ACTIVE)
            self._kick()

    def _look(self) -> bool:
        """Release the tasks whose event has a rising edge.  Return true if there was one."""
        is_any = False
        for task in self._events:
            assert task.event is not None
            is_high = task.event()
            if is_high and not task.was_high and task.phase is Phase.IDLE:
                self._make_ready(task, Phase.RELEASED)
                is_any = True
            task.was_high = is_high
        return is_any

    def _run_quiet(self) -> None:
        actions, self._on_quiet = self._on_quiet, []
        for action in actions:
            action()

    # ---- supervision

    def _supervise(self, task: Task) -> None:
        """Set the instant of the next look at the present cycle, which is one tick after its limit."""
        if task.is_supervised:
            limit_ns = SERIOUS * task.limit_ns if task.was_minor else task.limit_ns + TICK_NS
            task.deadline_ns = task.begin_ns + limit_ns + TICK_NS

    def _check(self, now_ns: int) -> None:
        for task in tuple(self._active):
            if now_ns >= task.deadline_ns:
                self._transgress(task, now_ns - task.begin_ns)

    def _transgress(self, task: Task, elapsed_ns: int) -> None:
        if not task.was_minor:
            task.was_minor = True
            self._owner.on_transgression(task, elapsed_ns, is_serious=False)
        if elapsed_ns > SERIOUS * task.limit_ns:
            self._suspend(task)
            self._owner.on_transgression(task, elapsed_ns, is_serious=True)
        else:
            self._supervise(task)

    def _suspend(self, task: Task) -> None:
        self._leave(task)
        task.phase, task.deadline_ns = Phase.ERROR, NEVER_NS

    def _leave(self, task: Task) -> None:
        """Take a task out of the ready tasks and of those within a cycle."""
        if task in self._ready:
            self._ready.remove(task)
        if task in self._active:
            self._active.remove(task)


def _key(task: Task) -> tuple[int, int]:
    return task.priority, task.order
