"""`ring.virtual`: the SERCOS ring in virtual time, and its model; `fibre` has what each drive hears."""

from collections.abc import Iterable, Sequence
from typing import ClassVar, Literal

from pydantic import Field

from fieldrig.bus import ModelBus, Time
from fieldrig_bus.ring.impostors import Impostors
from fieldrig_bus.ring.model import RING, MediumModel
from fieldrig_bus.ring.sercos.family import SercosFamily
from fieldrig_bus.ring.sercos.faults import RingFault
from fieldrig_bus.ring.sercos.fibre import Fibre
from fieldrig_bus.ring.sercos.message import Mdt, Mst, RingMessage
from fieldrig_bus.ring.settings import OrderSettings


class RingModel(MediumModel[RingMessage]):
    """One SERCOS ring: the instants at which the telegrams of `fibre` are heard.

    A drive hears a cycle at the end of the MDT, and the master hears the ATs at the end of the last slot.
    """

    def __init__(
        self, order: Sequence[str], mbaud: int, bypassed: Iterable[str] = (), faults: Iterable[RingFault] = ()
    ) -> None:
        """`order` names stations; stations that it does not name follow in the order of joining."""
        self.fibre = Fibre(order, mbaud, bypassed, faults)
        super().__init__(self.fibre)
        self._impostors = Impostors()
        self._over_ns = 0
        """The instant at which the last cycle that has ended is heard.  A master that begins the next one earlier does
        not overtake it."""

    def submit(self, now_ns: int, member: str, message: RingMessage) -> None:
        fibre = self.fibre
        if message.__class__ is bytes:
            station = fibre.stations[member]
            if message and message[0] == station.address:  # as `lay` does, without the call
                station.at = message
            else:
                station.lay(message)
        elif member != fibre.master:
            self._impostors.drop(member)
        elif isinstance(message, Mst):
            self._end_cycle(now_ns, b"")
            answers = fibre.begin_cycle(now_ns, message)
            self._schedule(fibre.until_ns, RING, answers, (member,))
            self._note_faults(now_ns)
        elif isinstance(message, Mdt):
            self._end_cycle(now_ns, message.data)
            self._note_faults(now_ns)

    def _end_cycle(self, now_ns: int, mdt: bytes) -> None:
        fibre = self.fibre
        heard = fibre.end_cycle(now_ns, mdt)
        if heard:
            self._over_ns = max(self._over_ns, fibre.until_ns)
        for cycle, names in heard:
            self._schedule(self._over_ns, fibre.master or "", cycle, names)


class RingSettings(OrderSettings):
    """Settings that every SERCOS ring has."""

    mbaud: Literal[2, 4, 8, 16] = Field(default=4, description="bit rate on the fibre, in Mbit/s")
    faults: list[RingFault] = Field(default=[], description="faults that the ring has from the start")


class RingVirtual(SercosFamily, ModelBus[RingMessage]):
    about: ClassVar[str] = "SERCOS fibre ring, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})
    settings: RingSettings

    def __init__(self, name: str, settings: RingSettings) -> None:
        super().__init__(name, settings)

    def model(self) -> RingModel:
        settings = self.settings
        return RingModel(settings.order, settings.mbaud, settings.bypassed, settings.faults)
