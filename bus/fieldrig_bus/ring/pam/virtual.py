"""`pamring.virtual`: the ring of a PAM in virtual time.  `model` is the medium."""

from typing import ClassVar

from pydantic import Field

from fieldrig.bus import ModelBus, Time
from fieldrig_bus.ring.pam.family import PamRingFamily
from fieldrig_bus.ring.pam.faults import RingFault
from fieldrig_bus.ring.pam.message import RingMessage
from fieldrig_bus.ring.pam.model import PamRingModel
from fieldrig_bus.ring.settings import OrderSettings


class PamRingSettings(OrderSettings):
    """Settings that every ring of a PAM has."""

    faults: list[RingFault] = Field(default=[], description="faults that the ring has from the start")


class PamRingVirtual(PamRingFamily, ModelBus[RingMessage]):
    about: ClassVar[str] = "ring of a PAM with its ST1 and Smart-IO nodes, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})
    settings: PamRingSettings

    def __init__(self, name: str, settings: PamRingSettings) -> None:
        super().__init__(name, settings)

    def model(self) -> PamRingModel:
        settings = self.settings
        return PamRingModel(settings.order, settings.bypassed, settings.faults)
