"""Reports about the tasks of a program, as diagnoses of the controller.

Source: PacDrive manual 3242-3261, 4056-4121 (digest PD-073, PD-074, PD-101, PD-102).  The external diagnosis of a cycle
time transgression is "actual cycle time/configured cycle time" in ms, that of a run-time fault the POU and the line;
the manual gives no form for either.  A task that goes on transgressing is reported again after the first report has
been acknowledged.
"""

from collections.abc import Callable, Mapping
from typing import Final

from fieldrig.clock import MS
from fieldrig_devices.iec.loaded import place_of
from fieldrig_devices.iec.tasks.task import Task
from fieldrig_devices.iec.thread import Fault
from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.max4.messages.diagnosis import Sender
from fieldrig_devices.max4.reports import Reports

CODES: Final[Mapping[str, Code]] = {
    "division": Code.DIVISION_ERROR,
    "array bounds": Code.ARRAY_BOUNDS,
    "subrange": Code.VALUE_RANGE,
    "pointer": Code.POINTER,
    "stack": Code.STACK,
    "string": Code.STRING,
    "native": Code.FUNCTION,
}


class TaskReports:
    """The reports about the tasks of one controller, which watches its program by them (`loaded.Watcher`)."""

    def __init__(self, reports: Reports) -> None:
        self._reports = reports
        self.last_fault: Fault | None = None
        """The last fault that has suspended a task since the last reset."""
        self.on_stop: Callable[[Task], None] = lambda task: None
        """Called when a task has reached a breakpoint or has been stopped by a fault."""

    def reset(self) -> None:
        """Withdraw what only a reset of the tasks ends."""
        self.last_fault = None
        self._reports.withdraw(Code.SERIOUS_CYCLE_ERROR)

    def on_transgression(self, task: Task, elapsed_ns: int, *, is_serious: bool) -> None:
        if is_serious:
            self.last_fault = place_of(task, "cycle time", "the cycle took too long")
        code = Code.SERIOUS_CYCLE_ERROR if is_serious else Code.CYCLE_ERROR
        sender = sender_of(task)
        if not self._reports.is_pending(code, sender):
            self._reports.report(code, sender, f"{_ms(elapsed_ns)}/{_ms(task.limit_ns)}")

    def on_fault(self, task: Task, fault: Fault) -> None:
        self.last_fault = fault
        self._reports.report(CODES.get(fault.code, Code.FUNCTION), sender_of(task), f"{fault.pou} {fault.line}")
        self.on_stop(task)

    def on_halt(self, task: Task) -> None:
        self.on_stop(task)

    def on_cycle(self, task: Task) -> None:
        """The end of a cycle is no report."""


def sender_of(task: Task) -> Sender:
    return Sender("IEC_TASK", task.name)


def _ms(time_ns: int) -> str:
    return f"{time_ns / MS:.3f}".rstrip("0").rstrip(".")
