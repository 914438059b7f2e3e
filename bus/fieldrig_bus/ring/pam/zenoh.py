"""`pamring.zenoh`: the ring of a PAM in real time over Zenoh, also between machines."""

from collections.abc import Mapping
from typing import ClassVar, Final

from fieldrig_bus.ring.pam.star import PamRingStarSettings
from fieldrig_bus.ring.pam.star_bus import PamRingStar
from fieldrig_bus.ring.transport.zenoh import ENVIRONMENT, EXCHANGE_NS, ZenohCarrier, ZenohSettings

MOST_BEHIND: Final = 160
"""Cycles that wait for a process that stands still: a node must not miss an order, but sockets have no more room."""


class PamRingZenohSettings(ZenohSettings, PamRingStarSettings):
    """Settings of a PAM's ring over Zenoh."""


class PamRingZenoh(PamRingStar):
    about: ClassVar[str] = "ring of a PAM with its nodes, in real time over Zenoh"
    exchange_ns: ClassVar[int] = EXCHANGE_NS
    has_threads: ClassVar[bool] = True
    environment: ClassVar[Mapping[str, str]] = ENVIRONMENT
    settings: PamRingZenohSettings

    def __init__(self, name: str, settings: PamRingZenohSettings) -> None:
        super().__init__(name, settings)
        self.carrier = ZenohCarrier(name, settings.endpoint, MOST_BEHIND)
