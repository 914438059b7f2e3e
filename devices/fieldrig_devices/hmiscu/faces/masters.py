"""The controller as a Modbus client and as a CANopen master: their values are points of the controller.

Source: ours, as the library manual has no field buses.  Values of other units and nodes enter before a cycle of MAST,
and those for them leave after it, like inputs and outputs.  The function FieldbusIsRunning tells a program whether a
unit or node is there.
"""

import logging
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial

from fieldrig.clock import Clock
from fieldrig.device import Point, Value
from fieldrig.link import Link
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusEvent
from fieldrig_devices.canopen.master import CanopenMaster, MasterSlave
from fieldrig_devices.canopen.master_settings import CanMasterSettings
from fieldrig_devices.iec.host import Library, NativeFunction, Results
from fieldrig_devices.modbus.client import ClientUnit, ModbusClient
from fieldrig_devices.modbus.client_settings import ModbusClientSettings
from fieldrig_devices.registers.live_table import Lookup
from fieldrig_devices.registers.packed import Element, Packed

log = logging.getLogger(__name__)

TEXT = """
FUNCTION FieldbusIsRunning : BOOL
VAR_INPUT
  Name : STRING(80); (* of the unit or node in the settings *)
END_VAR
{native}
END_FUNCTION
"""


class PointCell:
    """A point as the place of a value."""

    def __init__(self, name: str, point: Point) -> None:
        self._name, self._point = name, point

    @property
    def value(self) -> Value:
        value = self._point.read()
        return 0 if isinstance(value, str) else value

    def put(self, value: Value) -> None:
        assert self._point.write is not None, "`_cells` has checked it"
        try:
            self._point.write(value)
        except ValueError as refused:
            log.debug("%s: %s", self._name, refused)


class Masters:
    """The client and the master of one controller, each of which may be missing."""

    def __init__(self, find: Lookup, is_driven: Callable[[str], bool]) -> None:
        self._find, self._is_driven = find, is_driven
        self._client: ModbusClient | None = None
        self._master: CanopenMaster | None = None
        self._units: dict[str, ClientUnit] = {}
        self._nodes: dict[str, MasterSlave] = {}

    def add_client(self, clock: Clock, link: Link[ModbusEvent], settings: ModbusClientSettings) -> None:
        """ValueError for values without a point."""
        self._client = ModbusClient(clock, link, settings, partial(_report, "lost"), partial(_report, "back"))
        self._units = dict(self._client.make_units(lambda name: partial(self._pack, f"modbus_client.units.{name}")))

    def add_master(self, clock: Clock, can: Link[CanFrame], settings: CanMasterSettings) -> None:
        """ValueError for values without a point."""
        self._master = CanopenMaster(clock, can, settings, self)
        self._nodes = dict(self._master.nodes)
        for name, node in self._nodes.items():
            node.use(partial(self._pack, f"can_master.nodes.{name}"))

    def _pack(self, key: str, elements: Sequence[Element], is_output: bool) -> Packed:
        return Packed(elements, [self._cell(key, element, is_output) for element in elements])

    def _cell(self, key: str, element: Element, is_output: bool) -> PointCell:
        point = self._find(element.name)
        if point is None:
            raise ValueError(f"{key}: expected a point of the controller, got {element.name}")
        if point.write is None and not is_output:
            raise ValueError(f"{key}: expected a point that can be set, got {element.name}")
        if not is_output and self._is_driven(element.name):
            raise ValueError(f"{key}: expected a variable that the program only reads, got {element.name}")
        if isinstance(point.read(), str):
            raise ValueError(f"{key}: expected a number or a bit, got the text {element.name}")
        return PointCell(element.name, point)

    # ---- the life of the controller

    def start(self) -> None:
        if self._client is not None:
            self._client.begin(tuple(self._units.values()))
        if self._master is not None:
            self._master.boot()

    def stop(self) -> None:
        if self._client is not None:
            self._client.stop()
        if self._master is not None:
            self._master.stop()

    def hear(self, message: ModbusEvent) -> None:
        """Take a message that has arrived at the bus of the client."""
        if self._client is not None:
            self._client.hear(message)

    def take(self) -> None:
        for part in self._parts():
            part.take()

    def give(self) -> None:
        for part in self._parts():
            part.give()

    def _parts(self) -> Iterable[ClientUnit | MasterSlave]:
        yield from self._units.values()
        yield from self._nodes.values()

    # ---- what is known of units and nodes

    def library(self) -> Library:
        return Library("HMISCU_Fieldbus", TEXT, {"fieldbusisrunning": NativeFunction(self._is_running)}, {})

    def _is_running(self, name: str) -> Results:
        unit, node = self._units.get(name), self._nodes.get(name)
        return ((unit is not None and unit.is_running) or (node is not None and node.node.is_running),)

    def points(self) -> Iterator[tuple[str, Point]]:
        for name, unit in self._units.items():
            yield f"modbus_client/{name}/running", Point(partial(getattr, unit, "is_running"))
            for counter in ("requests", "errors", "exceptions"):
                yield f"modbus_client/{name}/{counter}", Point(partial(getattr, unit, counter))
        for name, node in self._nodes.items():
            yield f"can_master/{name}/running", Point(partial(getattr, node.node, "is_running"))
            yield f"can_master/{name}/losses", Point(partial(getattr, node, "losses"))

    def troubles(self) -> dict[str, Value]:
        """Return how often units failed to answer and nodes were lost, by the keys of the points."""
        return {
            **{f"modbus_client/{name}/errors": unit.errors for name, unit in self._units.items()},
            **{f"can_master/{name}/losses": node.losses for name, node in self._nodes.items()},
        }

    # ---- for the CANopen master (`Reporter`)

    def on_lost(self, slave: MasterSlave) -> None:
        log.warning("CANopen node %s is lost", slave.name)

    def on_back(self, slave: MasterSlave) -> None:
        log.warning("CANopen node %s is back", slave.name)

    def on_emergency(self, slave: MasterSlave, code: int, register: int) -> None:
        log.warning("CANopen node %s signals %04X, error register %02X", slave.name, code, register)


def _report(what: str, unit: ClientUnit) -> None:
    log.warning("Modbus unit %s is %s", unit.name, what)
