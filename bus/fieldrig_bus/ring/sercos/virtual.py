"""`ring.virtual`: the SERCOS ring in virtual time.  `model` is the medium."""

from typing import ClassVar, Literal

from pydantic import Field

from fieldrig.bus import ModelBus, Time
from fieldrig_bus.ring.sercos.family import SercosFamily
from fieldrig_bus.ring.sercos.faults import RingFault
from fieldrig_bus.ring.sercos.message import RingMessage
from fieldrig_bus.ring.sercos.model import RingModel
from fieldrig_bus.ring.settings import OrderSettings


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
