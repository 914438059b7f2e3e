"""A program that runs alone, without a controller: its tasks on a virtual clock, and what has happened to them."""

from collections.abc import Mapping

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.debuggee import IecDebuggee
from fieldrig_devices.iec.loaded import LoadedProgram
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.iec.tasks.task import Task
from fieldrig_devices.iec.thread import Fault
from fieldrig_devices.languages.debugging.debuggee import Reset


class Solo(IecDebuggee):
    """A program with its clock.  `run_until` moves the clock."""

    def __init__(self, clock: VirtualClock, host: StandaloneHost, compiled: Compiled) -> None:
        super().__init__()
        self._clock = clock
        self._program = LoadedProgram(clock, compiled, host, self)
        self.events: list[str] = []
        """Faults and cycles that took too long, in whole sentences."""

    @property
    def program(self) -> LoadedProgram:
        return self._program

    def start(self) -> None:
        self._program.scheduler.start()

    def stop(self) -> None:
        self._program.scheduler.stop()

    def reset(self, kind: Reset) -> None:
        self._program.scheduler.reset()
        if kind is Reset.WARM:
            self._program.renew()
        else:
            self._program.cold()

    def download(self, files: Mapping[str, str], *, is_online: bool) -> None:
        raise ValueError("this program runs alone: expected `fieldrig iec run` with the new files")

    def run_until(self, time_ns: int) -> None:
        self._clock.advance_to(time_ns)

    @property
    def is_over(self) -> bool:
        """True if every task has ended with an error."""
        return all(self._state(self._program, task).value == "failed" for task in self._program.scheduler.tasks)

    # ---- for the program (`loaded.Watcher`)

    def on_transgression(self, task: Task, elapsed_ns: int, *, is_serious: bool) -> None:
        kind = "10 times its cycle time, and has been suspended" if is_serious else "its cycle time"
        self.events.append(f"Task {task.name} has taken {elapsed_ns / 1e6:g} ms, more than {kind}.")

    def on_fault(self, task: Task, fault: Fault) -> None:
        self.events.append(f"Task {task.name} has been suspended by {fault}.")
        self.on_stop()

    def on_halt(self, task: Task) -> None:
        self.on_stop()

    def on_cycle(self, task: Task) -> None:
        """Nothing: a program alone is not recorded."""
