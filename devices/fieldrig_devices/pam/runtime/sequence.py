"""One item of a task: at most one of its sequences is alive at a time (sections 2.14 to 2.17).

The sequence that runs calls the functions of `services` at its service statements.
"""

from collections.abc import Callable, Mapping
from enum import Enum
from typing import Final

from fieldrig_devices.languages.debugging.stepping import Goal
from fieldrig_devices.languages.task import Task, TaskState
from fieldrig_devices.pam.runtime.armed import Armed
from fieldrig_devices.pam.runtime.item import Pending, Value
from fieldrig_devices.pam.runtime.kernel import ProgramKernel
from fieldrig_devices.pam.runtime.lower.formulas import Formula
from fieldrig_devices.pam.runtime.lower.lowered import (
    Abort,
    CaseSite,
    Entry,
    SequenceCode,
    StartSite,
    Switch,
    TaskCode,
)
from fieldrig_devices.pam.runtime.schedule import Unit
from fieldrig_devices.pam.runtime.waits import FinishWait, Wait
from fieldrig_devices.pam.runtime.watches import Event

BUSY: Final = "03..E033"
WORKSPACE: Final = "03..E02C"


class SequenceState(Enum):
    DEAD = "dead"
    ACTIVE = "active"
    SUSPENDED = "suspended"


class TaskItem(Unit):
    def __init__(
        self,
        kernel: ProgramKernel,
        all_tasks: "Mapping[tuple[str, int], TaskItem]",
        code: TaskCode,
        item: int,
        frame: int,
    ) -> None:
        """`all_tasks` has every item of every task that is there, by name and number, as XEQ_TASK starts them."""
        super().__init__(kernel.schedule, code.cycles)
        self._kernel, self._all_tasks, self.code, self.item, self._frame = kernel, all_tasks, code, item, frame
        self.name = code.name if code.count == 1 else f"{code.name}[{item + 1}]"
        self.watches, self.readings = kernel.watches, kernel.readings
        self.task = Task(kernel.code)
        self.sequence: SequenceCode | None = None
        """The sequence that is alive."""
        self.wait: Wait | None = None
        self._blocked: FinishWait | None = None
        """The end that an exception with XEQ_TASK ... WAIT waits for, beside the wait of the sequence itself."""
        self.exception: Armed | None = None
        self.timed_out = False
        """TIMEOUT, which the last CONDITION or EXCEPTION has set (G-23)."""
        self.next_sequence: str | None = None
        """The sequence that takes the place of the present one."""
        self._fired = -1
        """The basic cycle in which an exception has occurred last."""
        self.is_doomed = False
        """True if the sequence has to end because of an error of its own."""
        self.answers: list[Value | Pending | None] = []
        self.on_end: list[Callable[[], None]] = []
        """Called when the sequence that is alive has ended."""
        self.goal: Goal | None = None
        """The end of a step of the debugger."""
        self.events = [
            (Event(self.watches, event.formula, item, self.wake, self.readings), event.sequence)
            for event in code.events
        ]

    # ---- states

    @property
    def state(self) -> SequenceState:
        if self.sequence is None:
            return SequenceState.DEAD
        is_waiting = self.wait is not None or self._blocked is not None
        return SequenceState.SUSPENDED if is_waiting else SequenceState.ACTIVE

    @property
    def is_alive(self) -> bool:
        return self.sequence is not None

    def begin(self) -> None:
        """Look at the events from now on."""
        for event, _ in self.events:
            event.begin()

    def forget_events(self) -> None:
        for event, _ in self.events:
            event.forget()

    def start(self, sequence: SequenceCode) -> bool:
        """Let a sequence become active; False if its workspace is too small."""
        if sequence.used > sequence.workspace and self.readings.checks_workspaces:
            sizes = f"Allocated: {sequence.workspace} Used: {sequence.used}"
            text = f"rt_kernel S{sequence.number:03} WORKSPACE {sizes}"  # manual line 12655
            details = sequence.number, sequence.workspace, sequence.used
            self._kernel.stop_by(WORKSPACE, details, text, sequence)
            return False
        self.sequence, self.next_sequence, self.is_doomed = sequence, None, False
        self.task.start(sequence.routine, self._frame, self.item)
        return True

    def end(self) -> None:
        """Let the sequence be dead: it has ended, or it is aborted."""
        if self.sequence is None:
            return
        gate = self._kernel.gates.get(self.gate_of(self.sequence))
        self.sequence = None
        self.task.stop()
        self.leave_wait()
        if self._blocked is not None:
            self._blocked.end()
            self._blocked = None
        self.disarm()
        if gate is not None:
            gate.leave(self)
        ended, self.on_end = self.on_end, []
        for on_end in ended:
            on_end()

    def gate_of(self, sequence: SequenceCode) -> tuple[str, str]:
        """Return the key of the gate at which a sequence waits for its turn."""
        return self.code.name, sequence.name

    def leave_wait(self) -> None:
        if self.wait is not None:
            self.wait.end()
            self.wait = None

    # ---- in the cycles of the task

    def serve(self) -> None:
        if self.task.state is TaskState.STOPPED:
            return
        if self._kernel.is_working:
            self._take_events()
        if self.sequence is None:
            return
        exception = self.exception
        if exception is not None and exception.has_occurred and (self.readings.exceptions_wake or self._has_waited()):
            self._fire(exception)
        if self._is_ready():
            self._run()

    def _take_events(self) -> None:
        """Start the sequence of an event, if no other is alive; an event that comes too early is lost (PAML-293)."""
        for event, sequence in self.events:
            if event.take() and not self.is_alive:
                self.timed_out = False
                self.start(self.code.sequences[sequence])
            if event.is_polled:
                self.enter(self.cycle + 1)

    def _is_ready(self) -> bool:
        """Return whether the sequence goes on now."""
        if self.sequence is None or not self._has_waited():
            return False
        if self.next_sequence is not None:
            self._change_sequence()
        return self.sequence is not None

    def _has_waited(self) -> bool:
        """Return whether the sequence waits for nothing; leave a wait that is over."""
        if self._blocked is not None:
            if not self._blocked.is_over():
                return False
            self._blocked.end()
            self._blocked = None
        if self.wait is not None:
            if not self.wait.is_over():
                return False
            self.leave_wait()
        return True

    def _change_sequence(self) -> None:
        """Abort the sequence and start the one that takes its place."""
        name = self.next_sequence
        assert name is not None
        self.end()
        self.start(self.code.sequences[name])

    def _run(self) -> None:
        """Run until the sequence waits, ends or gives way."""
        kernel = self._kernel
        while self.sequence is not None and not kernel.is_stopped:
            kernel.run(self)
            if kernel.has_stopped():
                return
            match self.task.state:
                case TaskState.STOPPED:
                    kernel.on_stopped()
                    return
                case TaskState.ENDED if self.next_sequence is not None:
                    self._change_sequence()
                    continue
                case TaskState.ENDED:
                    self.end()
                    return
            if self.is_doomed:
                self.end()
                return
            if self.next_sequence is not None:
                self._change_sequence()
            elif self.exception is not None and self.exception.has_occurred:
                if self._fired == self.cycle:  # armed again by what it has led to, while its event is true
                    self.enter(self.cycle + 1)
                    return
                self._fire(self.exception)
                if not self._is_ready():
                    return
            elif self.wait is not None:
                return
            else:
                kernel.processor.give_way(self)
                return

    # ---- exceptions

    def on_exception(self) -> None:
        """The event of the exception has occurred: the present statement is completed first (PAML-377)."""
        self._kernel.processor.interrupt(self)
        self.wake()

    def _fire(self, exception: Armed) -> None:
        self._fired = self.cycle
        self.timed_out = exception.take()
        match exception.site.action:
            case Switch(sequence=sequence):
                self.end()
                self.start(self.code.sequences[sequence])
            case Entry(pc=pc):
                self.leave_wait()
                self.next_sequence = None
                assert self.sequence is not None
                self.task.start(self.sequence.routine, self._frame, self.item)
                self.task.go_to(pc)
            case Abort():
                self.end()
            case StartSite() as start:
                other = self.start_other(start)
                if other is not None and start.mode == "WAIT":
                    self._blocked = FinishWait(self, other)
                    self._blocked.begin()
                if self.is_doomed:
                    self.end()

    def start_other(self, site: StartSite) -> "TaskItem | None":
        """Start a sequence of another task; a task that is busy stops this one with an error (PAML-326, PAML-383)."""
        if site.mode == "ABORT":
            self.end()  # aborted first (PAML-375)
        item = self.item if site.is_indexed else 0
        other = self._all_tasks.get((site.task, item))
        if other is None:  # the component is not there
            return None
        if other.is_alive:
            self.fail(BUSY)
            return None
        other.timed_out = False
        if other.start(other.code.sequences[site.sequence]):
            other.wake()
        return other

    def fail(self, error: str) -> None:
        """Report an error of the sequence, which ends it (PAML-326, PAML-353)."""
        self._kernel.report(error, (self.sequence.number if self.sequence is not None else 0,))
        self.is_doomed = True

    def disarm(self) -> None:
        if self.exception is not None:
            self.exception.end()
            self.exception = None

    # ---- for waits and exceptions

    def value(self, formula: Formula) -> Value | None:
        """Return the value of a formula for this item; None if an answer is missing."""
        return self._kernel.processor.value(formula, self.item, self)

    def chosen(self, site: CaseSite) -> str | None:
        """Return the sequence of the first condition that is true."""
        for number, (formula, sequence) in enumerate(site.branches):
            if self.value(formula):
                self._cover(site, number)
                return sequence
        return None

    def late(self, site: CaseSite) -> str | None:
        """Return the sequence of the time-out, which has come."""
        self._cover(site, -1)
        return site.on_timeout

    def _cover(self, site: CaseSite, branch: int) -> None:
        if site.marks:
            self._kernel.cover(site.marks[branch])
