"""Devices for the bench of a PAM: a master that only sends set-points to groups, and a node that does nothing."""

from collections.abc import Sequence

from fieldrig.clock import MS, Clock
from fieldrig.device import Device, Point
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig_bus.ring.pam.message import RingMessage
from fieldrig_devices.pamring.declared import DeclaredNode
from fieldrig_devices.pamring.ends import RingFault
from fieldrig_devices.pamring.frames import Configuration, Group, NodeType, Order, Report, SetPoint, SetPointMode
from fieldrig_devices.pamring.master import RingMaster
from fieldrig_devices.pamring.node import RingNode
from fieldrig_devices.pamring.settings import RingLimits
from fieldrig_devices.pamring.start_up import Phase


class NodeSettings(Settings):
    ring_address: int


class Node(Device):
    """A node of the ring that takes everything and does nothing."""

    def __init__(self, clock: Clock, settings: NodeSettings, ring: Link[RingMessage]) -> None:
        self._end = RingNode(clock, ring, settings.ring_address, NodeType.ST1, 0x0590, self)

    def start(self) -> None:
        self._end.start()

    def forget(self) -> None:
        """There is nothing to forget."""

    def accept(self, item: Configuration) -> bool:
        return True

    def run(self) -> None:
        """There are no inputs."""

    def order(self, order: Order) -> None:
        """A set-point moves nothing."""

    def cycle(self) -> None:
        """Nothing is due."""

    def ring(self, fault: RingFault) -> None:
        """Nothing moves."""


class MasterSettings(Settings):
    addresses: list[int]
    groups: int
    """The first addresses belong to groups of two."""


class Master(Device):
    """Sends a set-point to each group in every cycle of 1 ms."""

    def __init__(self, clock: Clock, settings: MasterSettings, ring: Link[RingMessage]) -> None:
        self._clock, self._settings = clock, settings
        nodes = [
            DeclaredNode(number, NodeType.ST1, address) for number, address in enumerate(settings.addresses, start=1)
        ]
        self._ring = RingMaster(clock, ring, RingLimits(), nodes, self, self._say)
        self._sent = 0

    def start(self) -> None:
        self._ring.start()
        self._cycle()

    def points(self) -> dict[str, Point]:
        return {"sent": Point(lambda: self._sent)}

    def on_report(self, address: int, report: Report) -> None:
        """No node reports anything."""

    def _say(self, code: str, details: Sequence[int], text: str) -> None:
        """Messages have no reader here."""

    def _cycle(self) -> None:
        ring = self._ring
        ring.take()
        if ring.phase is Phase.RUNNING:
            self._send_set_points()
        ring.give()
        self._clock.call_at(self._clock.now_ns() + MS, self._cycle)

    def _send_set_points(self) -> None:
        groups = range(1, self._settings.groups + 1)
        if self._sent == 0:
            for place, address in enumerate(self._settings.addresses[: 2 * len(groups)]):
                self._ring.send(address, Group(1 + place // 2))
        self._sent += 1
        for group in groups:
            self._ring.send_to_group(group, SetPoint(SetPointMode.POSITION, self._sent))
