"""A single CiA 402 drive on a bench, with its motor and load: node 5, operational, in cycles of 1 ms."""

from collections.abc import Callable
from typing import Any, Self

from canopen_bench import RecordedCan
from cia402_bench import ENABLED, ByObject

from fieldrig.clock import MS, VirtualClock
from fieldrig.storage.store import MemoryStore, Store
from fieldrig.testing import RecordedLink
from fieldrig_bus.wires import Signal
from fieldrig_devices.cia402.single.device import Cia402Drive
from fieldrig_devices.cia402.single.settings import Cia402DriveSettings


class SingleDriveBench(ByObject):
    """The drive with these keys of its rig file."""

    def __init__(self, store: Store | None = None, clock: VirtualClock | None = None, **keys: Any) -> None:
        self.clock, self.store = clock or VirtualClock(), store or MemoryStore()
        self.can, self.wires = RecordedCan(), RecordedLink[Signal]()
        settings = Cia402DriveSettings.model_validate({"node_id": 5, **keys})
        self.drive = Cia402Drive(self.clock, "axis", settings, self.can, self.store, self.wires)
        self.node = self.drive.node
        self.drive.start()
        self.send("000#01 05")
        self.after(5)

    def enabled(self, mode: int) -> Self:
        """Enable operation in this mode."""
        self.put(0x6060, mode).control(0x06).control(0x07).control(0x0F).after(2)
        assert self.status(0x6F) == ENABLED
        return self

    def until(self, is_so: Callable[[], bool], within_ms: int = 60_000) -> int:
        """Let time pass until it is so; the milliseconds that it takes."""
        for passed in range(within_ms):
            if is_so():
                return passed
            self.after(1)
        raise AssertionError(f"it doesn't come within {within_ms} ms")

    def read(self, key: str) -> Any:
        return self.drive.points()[key].read()

    def write_point(self, key: str, value: Any) -> None:
        write = self.drive.points()[key].write
        assert write is not None
        write(value)

    def wire(self, name: str, value: bool | float) -> Self:
        """Drive a wire of the drive."""
        self.wires.deliver(Signal(name, value))
        return self

    def now_ms(self) -> float:
        return self.clock.now_ns() / MS
