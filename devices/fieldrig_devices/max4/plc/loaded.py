"""A program in the memory of the MAx-4, with its retained values."""

from collections.abc import Callable

from fieldrig.clock import Clock
from fieldrig.storage.store import Store
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.loaded import LoadedProgram, Watcher
from fieldrig_devices.iec.tasks.task import Task
from fieldrig_devices.max4.plc.host import PlcHost
from fieldrig_devices.max4.plc.retain import RetainMap, leaves_of
from fieldrig_devices.max4.plc.retain_store import Ram, RetainStore


class RetainingProgram(LoadedProgram):
    """A program whose RETAIN variables are stored between the cycles of all tasks.

    If some task is always within a cycle, for example in a long WAITT, they are stored as they are.
    """

    host: PlcHost

    def __init__(
        self, clock: Clock, compiled: Compiled, host: PlcHost, watcher: Watcher, ram: Ram, maps: Store
    ) -> None:
        super().__init__(clock, compiled, host, watcher)
        self._ram, self._maps = ram, maps
        self._retain = self._retain_store()

    def _retain_store(self) -> RetainStore:
        map, runtime = RetainMap(leaves_of(self.compiled.program)), self.runtime
        return RetainStore(self._ram, self._maps, map, runtime.memory, runtime.markers)

    def warm(self) -> None:
        """Give all variables their start values, and RETAIN variables their retained ones (PD-056)."""
        super().cold()
        self._retain.restore()
        self.runtime.give_markers()

    def cold(self) -> None:
        super().cold()
        self._retain.restore_nothing()

    def _change(self, compiled: Compiled, on_done: Callable[[], None]) -> None:
        def begin() -> None:
            self._retain = self._retain_store()
            self._retain.begin()
            on_done()

        super()._change(compiled, begin)

    def take(self, duration_ns: int) -> None:
        """Give the real-time process its processor time, and store what changes where no cycle ends."""
        scheduler = self.scheduler
        scheduler.take(duration_ns)
        if scheduler.is_crowded or (scheduler.is_quiet and not scheduler.is_running):
            self._retain.commit()

    def on_cycle_end(self, task: Task, *, is_quiet: bool) -> None:
        if is_quiet:
            self._retain.commit()
        super().on_cycle_end(task, is_quiet=is_quiet)
