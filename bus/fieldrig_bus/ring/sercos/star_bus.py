"""Base of the SERCOS rings in real time."""

import asyncio
from collections.abc import Callable
from typing import Any, ClassVar

from fieldrig.bus import Attachment
from fieldrig_bus.ring.sercos.cycle_wire import CYCLE_HEAD, decode_spread
from fieldrig_bus.ring.sercos.family import SercosFamily
from fieldrig_bus.ring.sercos.message import Cycle, RingMessage, decode
from fieldrig_bus.ring.sercos.star import RingStarSettings, Star
from fieldrig_bus.ring.transport.bus import StarBus
from fieldrig_bus.ring.transport.spread import Spread, SpreadRack
from fieldrig_bus.ring.transport.wire import HEAD

_START = HEAD.size + CYCLE_HEAD.size


class DriveRack(SpreadRack[Cycle]):
    """The drives of one process: each hears the cycle, and the ATs that they leave go back together."""

    def read_alike(self, data: bytes) -> Cycle | None:
        if len(data) >= _START:
            number, mst_end, is_more = CYCLE_HEAD.unpack_from(data, HEAD.size)
            if not is_more and _START <= mst_end <= len(data):
                return Cycle(number, data[_START:mst_end], data[mst_end:])
        return None

    def read_spread(self, data: bytes) -> tuple[Spread[Cycle], Any]:
        spread = decode_spread(data)
        return spread, decode(spread.answers) if spread.answers else None


class RingStar(SercosFamily, StarBus[RingMessage]):
    """A SERCOS ring in real time; a subclass says what carries it."""

    virtual_kind: ClassVar[str | None] = "ring.virtual"
    settings: RingStarSettings

    def make_centre(self, at: Attachment, handler: Callable[[Any], None], loop: asyncio.AbstractEventLoop) -> Star:
        return Star(self.name, at, self.settings, handler, loop)

    def make_rack(self, loop: asyncio.AbstractEventLoop) -> DriveRack:
        return DriveRack(self.name, loop)
