"""The SERCOS drives of one process: each hears the cycle, and the ATs that they leave go back together."""

from fieldrig_bus.ring.sercos.cycle_wire import CYCLE_HEAD, Spread, decode_spread
from fieldrig_bus.ring.sercos.message import Cycle, RingMessage, decode
from fieldrig_bus.ring.transport.rack import Rack
from fieldrig_bus.ring.transport.wire import HEAD

_START = HEAD.size + CYCLE_HEAD.size


class DriveRack(Rack["Cycle | tuple[Spread, RingMessage | None]"]):
    """The rack of one process.  A cycle that all drives hear alike, which nearly all are, takes a short way."""

    def read(self, data: bytes) -> "Cycle | tuple[Spread, RingMessage | None]":
        """The cycle that all drives hear; otherwise what each station hears, and the answers for observers."""
        if len(data) >= _START:
            number, mst_end, is_more = CYCLE_HEAD.unpack_from(data, HEAD.size)
            if not is_more and _START <= mst_end <= len(data):
                return Cycle(number, data[_START:mst_end], data[mst_end:])
        spread = decode_spread(data)
        return spread, decode(spread.answers) if spread.answers else None

    def deliver(self, cycle: "Cycle | tuple[Spread, RingMessage | None]", instant_ns: int) -> None:
        if isinstance(cycle, Cycle):
            for station in self.answering:
                station.at.deliver(station.handler, cycle, instant_ns)
            return
        spread, answers = cycle
        if len(spread.heard) == 1 and not spread.heard[0][1]:
            self._deliver_to_all(spread.heard[0][0], answers, instant_ns)
        else:
            heard = {name: cycle for cycle, names in spread.heard for name in names}
            self._deliver_to_some(heard, answers, instant_ns)

    def _deliver_to_all(self, cycle: Cycle, answers: RingMessage | None, instant_ns: int) -> None:
        for station in tuple(self.stations.values()):
            if station.addresses is not None:
                station.at.deliver(station.handler, cycle, instant_ns)
            elif answers is not None:
                station.at.deliver(station.handler, answers, instant_ns)
                station.at.deliver(station.handler, cycle, instant_ns)

    def _deliver_to_some(self, heard: dict[str, Cycle], answers: RingMessage | None, instant_ns: int) -> None:
        for name, station in tuple(self.stations.items()):
            if name in heard:
                station.at.deliver(station.handler, heard[name], instant_ns)
            elif station.addresses is None and answers is not None:
                for message in (answers, *dict.fromkeys(heard.values())):
                    station.at.deliver(station.handler, message, instant_ns)
