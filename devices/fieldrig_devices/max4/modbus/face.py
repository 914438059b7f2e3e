"""The MAx-4 as a Modbus server: one unit on any number of buses, TCP or serial lines.

Source: ours, as the manual names the library ModBus.lib, but neither its role nor its framing (digest PD-306, 458); the
answers are those of fieldrig_bus.modbus.server.  The server answers once a boot has finished, and is silent without
power and during a boot.  Holding and input registers are the same.  Left out: queues (function 24).
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence

from fieldrig.clock import MS, Clock
from fieldrig.link import Link
from fieldrig_bus.modbus.errors import ILLEGAL_DATA_ADDRESS, ModbusError
from fieldrig_bus.modbus.message import CONNECTIONS, ModbusEvent, ModbusRequest
from fieldrig_bus.modbus.server import ModbusServer
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.axes.positioning import Positioner
from fieldrig_devices.max4.axis_inputs import AxisInputs, check_terminals, terminals_in
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.modbus.axis import AxisRegisters
from fieldrig_devices.max4.modbus.map import Window, controller_entries, inputs, outputs, status_of
from fieldrig_devices.max4.modbus.markers import MarkerBits, MarkerRegisters
from fieldrig_devices.max4.modbus.settings import AxisLimits, ModbusFaceSettings
from fieldrig_devices.modbus.port import ModbusPort
from fieldrig_devices.registers.live import Entry, LiveBits, LiveRegisters
from fieldrig_devices.registers.value import REFUSALS


class _Unit:
    """Implements `DataModel` of fieldrig_bus.modbus.server for one bus, from one boot to the next."""

    def __init__(self, controller: Controller, axes: Iterable[AxisRegisters], settings: ModbusFaceSettings) -> None:
        self._controller = controller
        self.entries: list[Entry] = [
            *controller_entries(controller),
            *Window(controller).entries(),
            *(entry for axis in axes for entry in axis.entries()),
        ]
        own = LiveRegisters(self.entries, settings.word_order, REFUSALS[settings.refusal])
        self.holding_registers = MarkerRegisters(own, lambda: controller.markers)
        self.input_registers = self.holding_registers
        self.coils = MarkerBits(LiveBits(outputs(controller)), lambda: controller.markers)
        self.discrete_inputs = LiveBits(inputs(controller))

    def fifo(self, address: int) -> list[int]:
        raise ModbusError(ILLEGAL_DATA_ADDRESS)

    def exception_status(self) -> int:
        return status_of(self._controller) & 0xFF


class ModbusFace:
    """The server of one controller."""

    def __init__(
        self,
        clock: Clock,
        controller: Controller,
        links: Sequence[Link[ModbusEvent]],
        settings: ModbusFaceSettings,
        switches: Mapping[str, Mapping[int, str]],
    ) -> None:
        """`switches` are the limit switches of axes from other settings: names of inputs by bit, by axis.

        ValueError if the settings do not fit the configuration of the controller.
        """
        check_terminals(
            controller, "modbus.limits", {name: limits.switches.values() for name, limits in settings.limits.items()}
        )
        self._switches = switches
        self._clock, self._controller, self._settings = clock, controller, settings
        self._axes: list[AxisRegisters] = []
        self._positioners: list[Positioner] = []
        self._requested_ns = clock.now_ns()
        self._ports = [ModbusPort(clock, link, {}, settings.turnaround_ns, self._on_request) for link in links]
        controller.on_boot(self._on_boot)
        if links:
            controller.each_cycle(self._on_cycle)

    def hear(self, link: int, message: ModbusEvent) -> None:
        """Take a message that has arrived on this one of the links, from 0."""
        if self._controller.is_booted and isinstance(message, ModbusRequest):
            self._ports[link].on_message(message)

    @property
    def interest(self) -> list[int | str]:
        """The messages to receive: requests to the unit, and new connections."""
        return [self._settings.unit_id, CONNECTIONS]

    def entries(self) -> Iterator[Entry]:
        """The register map of the present configuration, in the order of addresses."""
        return iter(_Unit(self._controller, self._axes, self._settings).entries)

    def _on_boot(self) -> None:
        """Connect to the axes and the tree of the new boot."""
        controller, settings = self._controller, self._settings
        self._axes = [self._registers(number, axis) for number, axis in enumerate(controller.axes.values())]
        self._positioners = [axis.positioner for axis in self._axes]
        for port in self._ports:
            unit = _Unit(controller, self._axes, settings)
            port.servers = {settings.unit_id: ModbusServer(unit, settings.identification)}

    def _registers(self, number: int, axis: Axis) -> AxisRegisters:
        controller, settings = self._controller, self._settings
        limits = settings.limits.get(axis.name, AxisLimits())
        switches = {**self._switches.get(axis.name, {}), **limits.switches}
        return AxisRegisters(
            number,
            axis,
            settings.units.get(axis.name, settings.increments_per_unit),
            controller.cycle_ns,
            AxisInputs(terminals_in(controller.tree, switches)),
            limits.software,
        )

    def _on_request(self) -> None:
        self._requested_ns = self._clock.now_ns()

    def _on_cycle(self) -> None:
        for positioner in self._positioners:
            if positioner.is_moving and positioner.travel.is_there:
                positioner.watch()
        watchdog_ns = self._settings.watchdog_ms * MS
        if watchdog_ns and self._clock.now_ns() - self._requested_ns > watchdog_ns:
            self._on_request()
            for axis in self._axes:
                axis.halt()
