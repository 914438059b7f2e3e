"""Base of the SERCOS rings in real time."""

import asyncio
from collections.abc import Callable
from typing import Any

from fieldrig.bus import Attachment
from fieldrig_bus.ring.sercos.family import SercosFamily
from fieldrig_bus.ring.sercos.message import RingMessage
from fieldrig_bus.ring.sercos.rack import DriveRack
from fieldrig_bus.ring.sercos.star import RingStarSettings, Star
from fieldrig_bus.ring.transport.bus import StarBus


class RingStar(SercosFamily, StarBus[RingMessage]):
    """A SERCOS ring in real time; a subclass says what carries it."""

    settings: RingStarSettings

    def make_centre(self, at: Attachment, handler: Callable[[Any], None], loop: asyncio.AbstractEventLoop) -> Star:
        return Star(self.name, at, self.settings, handler, loop)

    def make_rack(self, loop: asyncio.AbstractEventLoop) -> DriveRack:
        return DriveRack(self.name, loop)
