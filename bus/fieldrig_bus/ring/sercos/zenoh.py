"""`ring.zenoh`: the SERCOS ring in real time over Zenoh, also between machines."""

from collections.abc import Mapping
from typing import ClassVar

from fieldrig_bus.ring.sercos.star import RingStarSettings
from fieldrig_bus.ring.sercos.star_bus import RingStar
from fieldrig_bus.ring.transport.zenoh import ENVIRONMENT, EXCHANGE_NS, ZenohCarrier, ZenohSettings


class RingZenohSettings(ZenohSettings, RingStarSettings):
    """Settings of a SERCOS ring over Zenoh."""


class RingZenoh(RingStar):
    about: ClassVar[str] = "SERCOS fibre ring, in real time over Zenoh"
    exchange_ns: ClassVar[int] = EXCHANGE_NS
    has_threads: ClassVar[bool] = True
    environment: ClassVar[Mapping[str, str]] = ENVIRONMENT
    settings: RingZenohSettings

    def __init__(self, name: str, settings: RingZenohSettings) -> None:
        super().__init__(name, settings)
        self.carrier = ZenohCarrier(name, settings.endpoint)
