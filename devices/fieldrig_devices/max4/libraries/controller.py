"""The controller as the motion libraries see it, and a MAx-4 as such a controller."""

from typing import Final, Protocol

from fieldrig_devices.max4.axes.axis import INCREMENTS, Axis
from fieldrig_devices.max4.axes.encoder import LogicEncoder, MasterEncoder
from fieldrig_devices.max4.storage.disk import FlashDisk
from fieldrig_devices.max4.system import System

FEED: Final = "FeedConst"


class Encoder(Protocol):
    """A master: its position is that of the present cycle of the real-time process (PD-182)."""

    position: float


class MotionController(Protocol):
    """The controller, by logical addresses."""

    @property
    def cycle_ns(self) -> int:
        """Cycle of the ring."""

    def axis(self, address: int) -> Axis | None: ...

    def increments_per_unit(self, axis: Axis) -> float:
        """Encoder increments of one unit of length of this axis; 0 if its parameters do not give one."""

    def encoder(self, address: int) -> Encoder | None:
        """A logic or master encoder."""

    def read_file(self, name: str) -> bytes:
        """A file of the flash disk.  ValueError if there is none."""


class SystemMotion:
    """The axes and encoders of one boot of a MAx-4."""

    def __init__(self, system: System, disk: FlashDisk) -> None:
        self._disk = disk
        self.cycle_ns = system.cycle_ns
        self._axes = {axis.log_adr: axis for axis in system.axes.values()}
        self._feeds = {axis.log_adr: axis.object[FEED] for axis in system.axes.values()}
        process = system.process
        encoders: list[LogicEncoder | MasterEncoder] = [*process.logic_encoders, *process.master_encoders]
        self._encoders: dict[int, Encoder] = {encoder.object.log_adr: encoder for encoder in encoders}

    def axis(self, address: int) -> Axis | None:
        return self._axes.get(address)

    def encoder(self, address: int) -> Encoder | None:
        return self._encoders.get(address)

    def increments_per_unit(self, axis: Axis) -> float:
        feed = float(self._feeds[axis.log_adr].value)
        return INCREMENTS / feed if feed else 0.0

    def read_file(self, name: str) -> bytes:
        return self._disk.read(name)
