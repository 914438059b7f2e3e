"""The MAx-4 as a Modbus client: exchanges values of its object tree with registers and bits of other units.

Source: ours (digest PD-209, PD-306: the library ModBus.lib without its content).  A lost unit is reported in the log
and as a diagnosis; its object in the tree counts requests and errors.
"""

from collections.abc import Callable, Sequence
from functools import partial

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig_bus.modbus.message import ModbusEvent
from fieldrig_devices.max4.configuration.tree import Group, Object, ObjectTree, Parameter, Type
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.field_data import Data, IoMap, add_object
from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.max4.messages.diagnosis import Sender
from fieldrig_devices.modbus.client import ClientUnit, ModbusClient, Pack
from fieldrig_devices.modbus.client_settings import ModbusClientSettings
from fieldrig_devices.registers.packed import Element


class TreeClient:
    """The client of one controller, which runs from the start of a boot to power-off or reset."""

    def __init__(
        self,
        clock: Clock,
        controller: Controller,
        link: Link[ModbusEvent],
        settings: ModbusClientSettings,
        io_map: IoMap,
    ) -> None:
        self._controller, self._io_map = controller, io_map
        self._client = ModbusClient(
            clock,
            link,
            settings,
            partial(self._report, Code.FIELD_BUS_LOST),
            partial(self._report, Code.FIELD_BUS_BACK),
        )
        self.hear = self._client.hear
        controller.on_boot(self._on_boot)
        controller.on_end(self._client.stop)

    def _on_boot(self) -> None:
        units = self.add_objects(self._controller.tree)
        self._client.begin(units)
        self._io_map.parts.extend(units)  # the first update of the IO map starts the requests

    def add_objects(self, tree: ObjectTree) -> Sequence[ClientUnit]:
        """Add the objects of the units to a tree."""
        master = tree.root.add("Modbus client", "MB_CLIENT", "")
        objects: dict[str, Object] = {}

        def pack(name: str) -> Pack:
            node = objects[name] = add_object(master, "Modbus unit", "MB_UNIT", name)
            node.group("General")  # comes first
            return _packer(node)

        units = self._client.make_units(pack)
        for name, unit in units.items():
            _show(objects[name].group("General"), unit)
        return tuple(units.values())

    def _report(self, code: Code, unit: ClientUnit) -> None:
        self._controller.report(code, Sender("MB_UNIT", unit.name), f"Modbus {unit.settings.unit}")


def _packer(node: Object) -> Pack:
    inputs, outputs = node.group("Inputs"), node.group("Outputs")

    def make(elements: Sequence[Element], is_output: bool) -> Data:
        return Data(outputs if is_output else inputs, elements, is_output=is_output)

    return make


def _show(general: Group, unit: ClientUnit) -> None:
    """Add the parameters that report on a unit."""
    counters: tuple[tuple[str, Type, Callable[[], int], str], ...] = (
        ("Requests", Type.UDINT, lambda: unit.requests, ""),
        ("Errors", Type.UDINT, lambda: unit.errors, "requests without a valid response"),
        ("Exceptions", Type.UDINT, lambda: unit.exceptions, ""),
        ("LastException", Type.UINT, lambda: unit.last_exception, ""),
    )
    general.add(Parameter("UnitId", Type.UINT, first=unit.settings.unit))
    general.add(Parameter("IsRunning", Type.BOOL, read=lambda: unit.is_running))
    for name, type, read, about in counters:
        general.add(Parameter(name, type, read=read, about=about))
