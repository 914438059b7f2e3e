"""The SERCOS drives of one process: each hears the cycle, and the ATs that they leave go back together."""

from typing import Any

from fieldrig_bus.ring.sercos.cycle_wire import CYCLE_HEAD, decode_spread
from fieldrig_bus.ring.sercos.message import Cycle, decode
from fieldrig_bus.ring.transport.spread import Spread, SpreadRack
from fieldrig_bus.ring.transport.wire import HEAD

_START = HEAD.size + CYCLE_HEAD.size


class DriveRack(SpreadRack[Cycle]):
    """The rack of one process."""

    def read_alike(self, data: bytes) -> Cycle | None:
        if len(data) >= _START:
            number, mst_end, is_more = CYCLE_HEAD.unpack_from(data, HEAD.size)
            if not is_more and _START <= mst_end <= len(data):
                return Cycle(number, data[_START:mst_end], data[mst_end:])
        return None

    def read_spread(self, data: bytes) -> tuple[Spread[Cycle], Any]:
        spread = decode_spread(data)
        return spread, decode(spread.answers) if spread.answers else None
