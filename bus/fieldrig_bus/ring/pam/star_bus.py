"""Base of the rings of a PAM in real time."""

import asyncio
from collections.abc import Callable
from typing import Any, ClassVar

from fieldrig.bus import Attachment
from fieldrig_bus.ring.pam.cycle_wire import decode_alike, decode_spread
from fieldrig_bus.ring.pam.family import PamRingFamily
from fieldrig_bus.ring.pam.message import Cycle, RingMessage, decode
from fieldrig_bus.ring.pam.star import PamRingStarSettings, PamStar
from fieldrig_bus.ring.transport.bus import StarBus
from fieldrig_bus.ring.transport.spread import Spread, SpreadRack


class NodeRack(SpreadRack[Cycle]):
    """The nodes of one process: each hears the cycle, and the reports that they leave go back together."""

    def read_alike(self, data: bytes) -> Cycle | None:
        return decode_alike(data)

    def read_spread(self, data: bytes) -> tuple[Spread[Cycle], Any]:
        spread = decode_spread(data)
        return spread, decode(spread.answers) if spread.answers else None


class PamRingStar(PamRingFamily, StarBus[RingMessage]):
    """A PAM's ring in real time; a subclass says what carries it."""

    virtual_kind: ClassVar[str | None] = "pamring.virtual"
    settings: PamRingStarSettings

    def make_centre(self, at: Attachment, handler: Callable[[Any], None], loop: asyncio.AbstractEventLoop) -> PamStar:
        return PamStar(self.name, at, self.settings, handler, loop, self.carrier.most_behind)

    def make_rack(self, loop: asyncio.AbstractEventLoop) -> NodeRack:
        return NodeRack(self.name, loop)
