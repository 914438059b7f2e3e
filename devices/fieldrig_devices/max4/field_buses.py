"""The field buses of the controller: Modbus server and client, CANopen master and slave, and their IO map.

Source: PacDrive manual 458 (digest PD-004): the controller can be a field bus master or slave.
"""

from collections.abc import Sequence
from functools import partial

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.shared import SharedLink
from fieldrig_bus.modbus.message import ClientConnected, ModbusEvent, ModbusRequest
from fieldrig_devices.iec.tasks.system_work import TCP_PRIORITY
from fieldrig_devices.max4.can.face import CanFace
from fieldrig_devices.max4.can.master import TreeMaster
from fieldrig_devices.max4.configuration.tree import ObjectTree
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.field_data import IoMap
from fieldrig_devices.max4.modbus.client import TreeClient
from fieldrig_devices.max4.modbus.face import ModbusFace
from fieldrig_devices.max4.settings import Max4Settings


class FieldBuses:
    """The faces of one controller, connected to its buses."""

    def __init__(
        self,
        clock: Clock,
        controller: Controller,
        settings: Max4Settings,
        modbus: Sequence[Link[ModbusEvent]],
        can: Link[CanFrame] | None,
    ) -> None:
        """ValueError if a bus that the settings name is missing."""
        self._controller = controller
        self._tcp_us = settings.load.tcp_us
        shared = None if can is None else SharedLink(can)
        io_map = IoMap(controller, settings.io_map_ms, settings.load.io_map_us)
        client, master, axes = settings.modbus_client, settings.can_master, settings.can_axes
        terminals = axes.terminals if axes is not None else {}
        switches = {name: named.switches for name, named in terminals.items()}
        self.modbus_face = ModbusFace(clock, controller, modbus, settings.modbus, switches)
        self.modbus_client: TreeClient | None = None
        self.can_master: TreeMaster | None = None
        self._client_link = -1
        if client is not None:
            if client.link > len(modbus):
                raise ValueError(
                    f"modbus_client: link: expected 1 to {len(modbus)}, one of links.modbus, got {client.link}"
                )
            self._client_link = client.link - 1
            self.modbus_client = TreeClient(clock, controller, modbus[client.link - 1], client, io_map)
        if master is not None:
            if shared is None:
                raise ValueError("can_master: expected links.can beside it")
            self.can_master = TreeMaster(clock, controller, shared.share(), master, io_map)
        self.can_face: CanFace | None = None
        if axes is not None:
            if shared is None:
                raise ValueError("can_axes: expected links.can beside it")
            end = shared.share(hears_others=master is not None)
            self.can_face = CanFace(clock, end, controller, axes)
        for number, link in enumerate(modbus):
            link.on_receive(partial(self._on_modbus, number), self.modbus_face.interest)

    def add_objects(self, tree: ObjectTree) -> None:
        """Add the objects of the modules to a tree that no boot uses, so that a program can be compiled for them."""
        if self.modbus_client is not None:
            self.modbus_client.add_objects(tree)
        if self.can_master is not None:
            self.can_master.add_objects(tree)

    def _on_modbus(self, link: int, message: ModbusEvent) -> None:
        if isinstance(message, ModbusRequest):
            self._controller.at_priority(TCP_PRIORITY, self._tcp_us, partial(self.modbus_face.hear, link, message))
        elif isinstance(message, ClientConnected):
            self._controller.tcp_connected(message.peer)
        elif self.modbus_client is not None and link == self._client_link:
            self.modbus_client.hear(message)
