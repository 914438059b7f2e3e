"""The MAx-4 as a CANopen master: boots its slaves, supervises them, and exchanges PDOs with them.

Source: PacDrive manual 458, 3380-3383, 4102-4103 (digest PD-004, PD-302: the library CANopen_M and the file
\\CANMA.CON, without their content); CiA 301 and CiA 302-2.  COB-IDs are those of the predefined connection set.  The
loss and the return of a slave and its emergency messages are logged; a loss is also a diagnosis.
Left out: dynamic PDO linking, node guarding, identity checks, LSS.
"""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import MS, Clock, Timer
from fieldrig.link import Link
from fieldrig_bus.can.frame import STANDARD_MASK, CanFrame
from fieldrig_bus.can.shared import SharedLink
from fieldrig_devices.canopen.cob_id import EXTENDED_KEY
from fieldrig_devices.canopen.managed_slave import ManagedSlave, Presence
from fieldrig_devices.canopen.nmt import BOOT_UP, ERROR_CONTROL_ID
from fieldrig_devices.canopen.service import State
from fieldrig_devices.max4.can.master_settings import CanMasterSettings, CanNodeSettings
from fieldrig_devices.max4.configuration.tree import Object, ObjectTree, Parameter, Type
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.field_data import Data, IoMap, add_object
from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.max4.messages.diagnosis import Sender

SYNC_ID: Final = 0x80
EMCY_ID, EMCY_SIZE = 0x80, 8
TPDO_ID, RPDO_ID, PDO_STEP = 0x180, 0x200, 0x100
OPERATIONAL: Final = bytes((State.OPERATIONAL,))


class CanopenMaster:
    """The master of one controller, which runs from the start of a boot to power-off or reset."""

    def __init__(
        self, clock: Clock, controller: Controller, can: Link[CanFrame], settings: CanMasterSettings, io_map: IoMap
    ) -> None:
        self._clock, self._controller, self._settings, self._io_map = clock, controller, settings, io_map
        shared = SharedLink(can)
        self._can = shared.share()
        self._nodes = {
            symbol: Slave(clock, controller, shared, symbol, node) for symbol, node in settings.nodes.items()
        }
        self._timers: dict[int, Timer] = {}
        controller.on_boot(self._on_boot)
        controller.on_end(self.stop)

    @property
    def nodes(self) -> dict[str, "Slave"]:
        return dict(self._nodes)

    def stop(self) -> None:
        """Stop sending, at power-off or reset."""
        for timer in self._timers.values():
            timer.cancel()
        self._timers.clear()
        for slave in self._nodes.values():
            slave.stop()

    def _on_boot(self) -> None:
        settings = self._settings
        self.add_objects(self._controller.tree)
        own_id = ERROR_CONTROL_ID + settings.node_id
        if settings.heartbeat_ms:
            self._can.send(CanFrame(own_id, BOOT_UP))
        for slave in self._nodes.values():
            slave.boot()
            self._io_map.parts.append(slave)
        self._repeat(CanFrame(own_id, OPERATIONAL), settings.heartbeat_ms)
        self._repeat(CanFrame(SYNC_ID, b""), settings.sync_ms)

    def add_objects(self, tree: ObjectTree) -> None:
        """Add the objects of the nodes to a tree."""
        master = tree.root.add("CANopen master", "CAN_MASTER", "")
        for slave in self._nodes.values():
            slave.add_object(master)

    def _repeat(self, frame: CanFrame, every_ms: int) -> None:
        """Send a frame periodically, for the first time after one period."""
        if not every_ms:
            return

        def again() -> None:
            self._can.send(frame)
            self._repeat(frame, every_ms)

        self._timers[frame.identifier] = self._clock.call_at(self._clock.now_ns() + every_ms * MS, again)


class Slave:
    """One slave, and its part of the IO map."""

    def __init__(
        self, clock: Clock, controller: Controller, shared: SharedLink, symbol: str, settings: CanNodeSettings
    ) -> None:
        self._controller, self._settings, self.symbol = controller, settings, symbol
        self._sender = Sender("CAN_NODE", symbol)
        self._can = shared.share()
        self.node = ManagedSlave(
            clock,
            shared.share(),
            settings.node_id,
            settings.heartbeat_ms,
            self._on_lost,
            self._on_back,
            configuration=settings.configuration(),
            limit_ms=settings.limit_ms,
        )
        self._inputs: dict[int, Data] = {}
        self._outputs: dict[int, Data] = {}
        """Output data by COB-ID."""
        self._heard: dict[int, bytes] = {}
        self._sent: dict[int, bytes] = {}
        self._is_lost = self._is_zeroed = False
        self._losses = 0
        self._hears: dict[int, Callable[[CanFrame], None]] = {EMCY_ID + settings.node_id: self._on_emergency}
        for number in settings.inputs:
            self._hears[self._cob_id(TPDO_ID, number)] = self._on_pdo
        self._can.on_receive(self._on_frame, [[cob_id, EXTENDED_KEY | STANDARD_MASK] for cob_id in self._hears])

    def boot(self) -> None:
        self._losses, self._is_lost, self._is_zeroed = 0, False, False
        self._heard.clear()
        self._sent.clear()
        self.node.start()

    def add_object(self, master: Object) -> None:
        """Add the object of the node, with its data, to the tree that it belongs to from now on."""
        node_object = add_object(master, "CANopen node", "CAN_NODE", self.symbol)
        node, general = self.node, node_object.group("General")
        general.add(Parameter("NodeId", Type.UINT, first=node.node_id))
        general.add(Parameter("IsRunning", Type.BOOL, read=lambda: node.is_running))
        general.add(Parameter("NmtState", Type.UINT, read=lambda: node.state or 0, about="state in its heartbeat"))
        general.add(Parameter("Losses", Type.UDINT, read=lambda: self._losses))
        general.add(Parameter("Refused", Type.UINT, read=lambda: len(node.refused), about="objects that it refused"))
        settings, inputs, outputs = self._settings, node_object.group("Inputs"), node_object.group("Outputs")
        self._inputs = {
            self._cob_id(TPDO_ID, number): Data(inputs, elements, is_output=False)
            for number, elements in settings.inputs.items()
        }
        self._outputs = {
            self._cob_id(RPDO_ID, number): Data(outputs, elements, is_output=True)
            for number, elements in settings.outputs.items()
        }

    def stop(self) -> None:
        self.node.stop()

    # ---- IO map

    def take(self) -> None:
        if self._is_zeroed:
            self._is_zeroed = False
            for data in self._inputs.values():
                data.clear()
        for cob_id, received in self._heard.items():
            self._inputs[cob_id].unpack(received)
        self._heard.clear()

    def give(self) -> None:
        if not self.node.is_running:
            return
        for cob_id, data in self._outputs.items():
            packed = data.packed()
            if packed != self._sent.get(cob_id):
                self._sent[cob_id] = packed
                self._can.send(CanFrame(cob_id, packed))

    # ---- events of the slave

    def _on_lost(self) -> None:
        self._is_lost = True
        self._losses += 1
        self._heard.clear()
        self._is_zeroed = self._settings.lost_inputs == "zero"
        self._controller.report(Code.FIELD_BUS_LOST, self._sender, self._place)

    def _on_back(self) -> None:
        self._sent.clear()
        if self._is_lost:
            self._is_lost = False
            self._controller.report(Code.FIELD_BUS_BACK, self._sender, self._place)
        if self._settings.ask:
            for cob_id in self._inputs:
                self._can.send(CanFrame(cob_id, is_remote=True))

    def _on_frame(self, frame: CanFrame) -> None:
        if self.node.presence is not Presence.OFF and not frame.is_remote:
            self._hears[frame.identifier](frame)

    def _on_pdo(self, frame: CanFrame) -> None:
        if self.node.is_running:
            self._heard[frame.identifier] = frame.data

    def _on_emergency(self, frame: CanFrame) -> None:
        if len(frame.data) == EMCY_SIZE:
            code = int.from_bytes(frame.data[:2], "little")
            self._controller.report(Code.EMERGENCY, self._sender, f"{self._place} {code:04X} {frame.data[2]:02X}")

    @property
    def _place(self) -> str:
        return f"CAN {self.node.node_id}"

    def _cob_id(self, first: int, number: int) -> int:
        return first + (number - 1) * PDO_STEP + self.node.node_id
