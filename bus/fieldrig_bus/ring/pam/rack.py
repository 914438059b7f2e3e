"""The nodes of one process: each hears the cycle, and the reports that they leave go back together."""

from typing import Any

from fieldrig_bus.ring.pam.cycle_wire import decode_alike, decode_spread
from fieldrig_bus.ring.pam.message import Cycle, decode
from fieldrig_bus.ring.transport.spread import Spread, SpreadRack


class NodeRack(SpreadRack[Cycle]):
    """The rack of one process."""

    def read_alike(self, data: bytes) -> Cycle | None:
        return decode_alike(data)

    def read_spread(self, data: bytes) -> tuple[Spread[Cycle], Any]:
        spread = decode_spread(data)
        return spread, decode(spread.answers) if spread.answers else None
