"""`ring.virtual`: the fibre ring in virtual time.  What the medium does is in `model`."""

from typing import ClassVar, Literal

from pydantic import Field

from fieldrig.bus import ModelBus, Time
from fieldrig.settings import Settings
from fieldrig_bus.ring import message
from fieldrig_bus.ring.faults import RingFault
from fieldrig_bus.ring.message import Answers, Cycle, Mdt, Mst, RingMessage
from fieldrig_bus.ring.model import RingModel


class RingSettings(Settings):
    mbaud: Literal[2, 4, 8, 16] = Field(default=4, description="MBaud on the fibre")
    order: list[str] = Field(
        default=[], description="drives as the fibre passes them; left out: in the order of the file"
    )
    bypassed: list[str] = Field(
        default=[], description="stations with an optical bypass: without power they don't open the ring"
    )
    faults: list[RingFault] = Field(default=[], description="that the ring has from the start")


class RingVirtual(ModelBus[RingMessage]):
    about: ClassVar[str] = "SERCOS fibre ring, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})
    family: ClassVar[str] = "ring"
    messages: ClassVar[tuple[type, ...]] = (Mst, Mdt, Cycle, Answers, bytes)
    settings: RingSettings

    encode = staticmethod(message.encode)
    decode = staticmethod(message.decode)
    show = staticmethod(message.show)

    def __init__(self, name: str, settings: RingSettings) -> None:
        super().__init__(name, settings)

    def model(self) -> RingModel:
        settings = self.settings
        return RingModel(settings.order, settings.mbaud, settings.bypassed, settings.faults)
