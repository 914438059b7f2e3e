"""Kinds for the tests of faults in running rigs; the processes of a rig import this module by name."""

from typing import ClassVar, Literal

from fieldrig.bus import Attachment, DirectBus, Time
from fieldrig.clock import MS, Clock
from fieldrig.device import Device
from fieldrig.faults.faults import Fault, Faults, Timed
from fieldrig.faults.injected import InjectedFaults
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig.testing import RecordedLink
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.signals import codec
from fieldrig_bus.wires import Signal


class Mute(Timed):
    what: Literal["mute"]


class Beacon(Device):
    """Sends one frame every 10 ms, unless it is mute."""

    def __init__(self, clock: Clock, can: Link[CanFrame]) -> None:
        self._clock, self._can = clock, can
        self._faults = self.injected = InjectedFaults[Fault[Mute]](clock, {"mute": Mute}, Faults(Fault))

    def start(self) -> None:
        if self._faults.first(Mute) is None:
            self._can.send(CanFrame(0x185, b"\x01"))
        self._clock.call_at(self._clock.now_ns() + 10 * MS, self.start)


class Seedling(Device):
    """A device with one end of a bus."""

    def __init__(self, soil: Link[Signal]) -> None:
        self._soil = soil


class SoilSettings(Settings):
    pass


class Soil(DirectBus[Signal]):
    """Tells the seed that it got."""

    times: ClassVar[frozenset[Time]] = frozenset({"real"})
    family: ClassVar[str] = "wires"
    messages: ClassVar[tuple[type, ...]] = (Signal,)

    def __init__(self, name: str, settings: SoilSettings) -> None:
        super().__init__(name, settings)

    encode = staticmethod(codec.encode)
    decode = staticmethod(codec.decode)
    show = staticmethod(codec.show)

    async def open(self, at: Attachment) -> Link[Signal]:
        at.heard(at.member, Signal("seed", at.seed))
        return RecordedLink()

    async def close(self, member: str) -> None:
        """There is nothing to close."""
