"""A log played to a rig in virtual time, in this process."""

from collections.abc import Iterable
from typing import Any, Final

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import S
from fieldrig.errors import RigError
from fieldrig.link import Link
from fieldrig.traces.trace import TraceEntry
from fieldrig.virtual.node import EventNode
from fieldrig.virtual.rig import Rig
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.replay.families import COMPARED, INNER, MEDIA
from fieldrig_devices.replay.judge import Judge
from fieldrig_devices.replay.opening import Opening
from fieldrig_devices.replay.pace import Pace
from fieldrig_devices.replay.player import Player
from fieldrig_devices.replay.schedule import schedule
from fieldrig_devices.replay.sides import Sides

MEMBER: Final = "replay"
MOST_MEMBERS: Final = 64
"""Senders of the log that are members of their own; the others are one."""
SILENT_NS: Final = 10 * S
"""Time after which a node of which nothing was heard is asked: most say themselves that they have booted."""
LONGEST_NS: Final = 100 * 365 * 24 * 3600 * S


class _Stage:
    """The members that play the senders of the log."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._nodes: dict[tuple[str, str], EventNode] = {}
        self._served: dict[str, list[int]] = {}
        self.clock_node = rig.clients.join(self._free(MEMBER), next(iter(rig.buses)))
        self.members = {self.clock_node.name}

    def link(self, sender: str, bus: str) -> Link[Any]:
        """Return the end of a bus that plays this sender."""
        node = self._nodes.get((sender, bus))
        if node is None:
            node = self._nodes[sender, bus] = self._join(sender, bus)
            self.members.add(node.name)
        return node.link(bus)

    def serve(self, bus: str, units: Iterable[int]) -> None:
        """Have the requests to these units come to the log, which answers them."""
        self.link(MEMBER, bus).on_receive(lambda _: None, list(units))

    def _join(self, sender: str, bus: str) -> EventNode:
        name = sender if sender and len(self._nodes) < MOST_MEMBERS else MEMBER
        name = self._free(name if name not in self._rig.config.devices else MEMBER)
        taken = next((node for (_, at), node in self._nodes.items() if node.name == name and at == bus), None)
        if taken is not None:
            return taken
        if name == self.clock_node.name and bus == next(iter(self._rig.buses)):
            return self.clock_node
        return self._rig.clients.join(name, bus)

    def _free(self, name: str) -> str:
        return name if name not in self._rig.config.devices else f"{name}:log"


def play(entries: Iterable[TraceEntry], rig: Rig, sides: Sides, judge: Judge, pace: Pace) -> None:
    """Play a log; the rig goes on from its present instant to the end of the log."""
    if not rig.buses:
        raise RigError("the rig has no bus to play to", "add the bus of the log to the rig file")
    stage = _Stage(rig)
    for bus, entry in rig.config.buses.items():
        if entry.bus.family == "modbus" and sides.selection.units:
            stage.serve(bus, sorted(sides.selection.units))
    served = sides.selection.units
    dues = schedule(entries, sides, rig.buses, judge.result)
    clock = stage.clock_node.clock

    def player_of(pace: Pace) -> Player:
        return Player(dues, judge, pace, clock, lambda: rig.now_ns, stage.link, lambda: None, served)

    player = Opening(player_of, pace, sides, judge, clock, lambda: rig.now_ns, stage.link, SILENT_NS)

    def hear(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        if bus.family not in COMPARED or (bus.family in INNER and bus.name not in judge.buses):
            return  # most messages of a machine are those of its rings, and few logs have them
        message = delivery.message
        if bus.family == "modbus" and not stage.members.isdisjoint(delivery.receivers):
            if isinstance(message, ModbusResponse):
                player.answered(bus.name, message, delivery.time_ns)
                return
            if isinstance(message, ModbusRequest):
                player.asked(bus.name, message)
        entry = TraceEntry(delivery.time_ns, bus.name, bus.family, delivery.sender, bus.encode(message))
        if delivery.sender in stage.members:
            player.heard_own(entry)
        elif delivery.sender in rig.config.devices or (bus.family in INNER and delivery.sender in MEDIA):
            player.heard(entry)

    end = rig.on_delivery(hear)
    try:
        player.start()
        rig.run_until(rig.now_ns + LONGEST_NS, stop=lambda: player.is_ended)
    finally:
        end()
