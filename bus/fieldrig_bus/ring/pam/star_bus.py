"""Base of the rings of a PAM in real time."""

import asyncio
from collections.abc import Callable
from typing import Any

from fieldrig.bus import Attachment
from fieldrig_bus.ring.pam.family import PamRingFamily
from fieldrig_bus.ring.pam.message import RingMessage
from fieldrig_bus.ring.pam.rack import NodeRack
from fieldrig_bus.ring.pam.star import PamRingStarSettings, PamStar
from fieldrig_bus.ring.transport.bus import StarBus


class PamRingStar(PamRingFamily, StarBus[RingMessage]):
    """A PAM's ring in real time; a subclass says what carries it."""

    settings: PamRingStarSettings

    def make_centre(self, at: Attachment, handler: Callable[[Any], None], loop: asyncio.AbstractEventLoop) -> PamStar:
        return PamStar(self.name, at, self.settings, handler, loop, self.carrier.most_behind)

    def make_rack(self, loop: asyncio.AbstractEventLoop) -> NodeRack:
        return NodeRack(self.name, loop)
