"""What the SERCOS rings in real time have in common."""

import asyncio
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from fieldrig.bus import Attachment
from fieldrig_bus.ring.sercos import message
from fieldrig_bus.ring.sercos.faults import MODELS
from fieldrig_bus.ring.sercos.message import Answers, Cycle, Mdt, Mst, RingMessage
from fieldrig_bus.ring.sercos.rack import DriveRack
from fieldrig_bus.ring.sercos.star import Star
from fieldrig_bus.ring.sercos.virtual import RingSettings
from fieldrig_bus.ring.transport.bus import StarBus, StarSettings


class RingStarSettings(StarSettings, RingSettings):
    """Settings of a SERCOS ring in real time."""


class RingStar(StarBus[RingMessage]):
    """A SERCOS ring in real time; a subclass says what carries it."""

    family: ClassVar[str] = "ring"
    messages: ClassVar[tuple[type, ...]] = (Mst, Mdt, Cycle, Answers, bytes)
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS
    settings: RingStarSettings

    encode = staticmethod(message.encode)
    decode = staticmethod(message.decode)
    show = staticmethod(message.show)
    check = staticmethod(message.check_sent)
    check_interest = staticmethod(message.check_interest)

    def make_centre(self, at: Attachment, handler: Callable[[Any], None], loop: asyncio.AbstractEventLoop) -> Star:
        return Star(self.name, at, self.settings, handler, loop)

    def make_rack(self, loop: asyncio.AbstractEventLoop) -> DriveRack:
        return DriveRack(self.name, loop)
