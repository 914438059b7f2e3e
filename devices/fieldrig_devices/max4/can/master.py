"""The MAx-4 as a CANopen master: the values of its slaves are parameters of its object tree.

Source: PacDrive manual 458, 3380-3383, 4102-4103 (digest PD-004, PD-302: the library CANopen_M and the file
\\CANMA.CON, without their content).  The loss and the return of a slave and its emergency messages are logged; a loss
is also a diagnosis.
"""

from collections.abc import Mapping, Sequence

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.master import CanopenMaster, MasterSlave
from fieldrig_devices.canopen.master_settings import CanMasterSettings
from fieldrig_devices.max4.configuration.tree import Object, ObjectTree, Parameter, Type
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.field_data import Data, IoMap, add_object
from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.max4.messages.diagnosis import Sender
from fieldrig_devices.registers.packed import Element


class TreeMaster:
    """The master of one controller, which runs from the start of a boot to power-off or reset."""

    def __init__(
        self, clock: Clock, controller: Controller, can: Link[CanFrame], settings: CanMasterSettings, io_map: IoMap
    ) -> None:
        self._controller, self._io_map = controller, io_map
        self._master = CanopenMaster(clock, can, settings, self)
        controller.on_boot(self._on_boot)
        controller.on_end(self._master.stop)

    @property
    def nodes(self) -> Mapping[str, MasterSlave]:
        return self._master.nodes

    def _on_boot(self) -> None:
        self.add_objects(self._controller.tree)
        self._master.boot()
        self._io_map.parts.extend(self.nodes.values())

    def add_objects(self, tree: ObjectTree) -> None:
        """Add the objects of the nodes to a tree, which has their values from now on."""
        master = tree.root.add("CANopen master", "CAN_MASTER", "")
        for slave in self.nodes.values():
            _add_slave(master, slave)

    # ---- for the master (`Reporter`)

    def on_lost(self, slave: MasterSlave) -> None:
        self._report(Code.FIELD_BUS_LOST, slave)

    def on_back(self, slave: MasterSlave) -> None:
        self._report(Code.FIELD_BUS_BACK, slave)

    def on_emergency(self, slave: MasterSlave, code: int, register: int) -> None:
        self._report(Code.EMERGENCY, slave, f" {code:04X} {register:02X}")

    def _report(self, code: Code, slave: MasterSlave, more: str = "") -> None:
        self._controller.report(code, Sender("CAN_NODE", slave.name), f"CAN {slave.node.node_id}{more}")


def _add_slave(master: Object, slave: MasterSlave) -> None:
    node_object = add_object(master, "CANopen node", "CAN_NODE", slave.name)
    node, general = slave.node, node_object.group("General")
    general.add(Parameter("NodeId", Type.UINT, first=node.node_id))
    general.add(Parameter("IsRunning", Type.BOOL, read=lambda: node.is_running))
    general.add(Parameter("NmtState", Type.UINT, read=lambda: node.state or 0, about="state in its heartbeat"))
    general.add(Parameter("Losses", Type.UDINT, read=lambda: slave.losses))
    general.add(Parameter("Refused", Type.UINT, read=lambda: len(node.refused), about="objects that it refused"))
    inputs, outputs = node_object.group("Inputs"), node_object.group("Outputs")

    def pack(elements: Sequence[Element], is_output: bool) -> Data:
        return Data(outputs if is_output else inputs, elements, is_output=is_output)

    slave.use(pack)
