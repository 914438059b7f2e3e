"""The MAx-4 PacController: its firmware, and the ways from outside into it.

Source: PacDrive system manual 17130061, edition 2003-10 (digest PD-001 to PD-004).
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import Any, ClassVar

from fieldrig.clock import Clock
from fieldrig.device import Device, Point, Tool, Value
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.loop.background import Background
from fieldrig.storage.store import Store
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.ip.message import RelayMessage
from fieldrig_bus.modbus.message import ModbusEvent
from fieldrig_bus.opcua.message import OpcUaMessage
from fieldrig_bus.ring.sercos.message import RingMessage
from fieldrig_bus.serial.message import SerialMessage
from fieldrig_bus.tcp.message import TcpMessage
from fieldrig_bus.wires import Signal
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.languages.debugging.service import DebugService
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.max4.debuggee import PlcDebuggee
from fieldrig_devices.max4.faults import MODELS
from fieldrig_devices.max4.field_buses import FieldBuses
from fieldrig_devices.max4.firmware import Firmware
from fieldrig_devices.max4.front import front_of
from fieldrig_devices.max4.network import Network
from fieldrig_devices.max4.opcua import OpcUaNodes
from fieldrig_devices.max4.operations import Operations
from fieldrig_devices.max4.plc.plc import Plc
from fieldrig_devices.max4.points import input_points, memory_points, parameter_points, state_points
from fieldrig_devices.max4.settings import Max4Settings
from fieldrig_devices.modbus.tools import identification_lines


class Max4(Device):
    """The controller, which connects its firmware with its links."""

    about = "MAx-4 PacController: object tree, messages and diagnosis, master of the SERCOS ring of MC-4 drives"
    has_cycle = True
    trouble_keys: ClassVar[Collection[str]] = ("DiagCode", "plc/fault")
    diagnosis_keys: ClassVar[Collection[str]] = ("*.DiagCode",)
    log_keys: ClassVar[Collection[str]] = ("log",)
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(
        self,
        clock: Clock,
        name: str,
        settings: Max4Settings,
        store: Store,
        background: Background,
        random: Any,
        ring: Link[RingMessage] | None = None,
        wires: Link[Signal] | None = None,
        modbus: list[Link[ModbusEvent]] | None = None,
        can: Link[CanFrame] | None = None,
        opcua: Link[OpcUaMessage] | None = None,
        com1: Link[SerialMessage] | None = None,
        tcp: Link[TcpMessage] | None = None,
        relay: Link[RelayMessage] | None = None,
    ) -> None:
        """Build it off; `random` is the `random.Random` of this device.

        ValueError for settings that do not fit each other, such as start values that no parameter can have."""
        self.name, self._settings = name, settings
        self._points: dict[str, Point] = {}
        self.firmware = firmware = Firmware(clock, settings, store, background, ring, wires, lambda: self._network.com1)
        self.injected = firmware.power.injected
        self._network = Network(clock, random, name, firmware, firmware.disk, settings, com1, tcp, relay)
        firmware.install(self._network.pages)
        self._operations = Operations(clock, firmware, firmware.plc, firmware.project, firmware.disk, settings.version)
        self._debugging = DebugService(clock, PlcDebuggee(firmware.plc, self._operations, background))
        self._field_buses = FieldBuses(clock, firmware, settings, modbus or [], can)
        self._field_buses.add_objects(firmware.tree)
        firmware.plc.check_settings()
        self._opcua = None if opcua is None else self._nodes_at(opcua)
        # After the field buses: they begin a boot with its new axes, and end it, before the other ways from outside.
        firmware.on_boot(self._network.boot)
        firmware.on_end(self._network.end)
        firmware.on_end(self._operations.cancel)
        firmware.on_system, firmware.on_program = self._make_points, self._on_program

    def _nodes_at(self, opcua: Link[OpcUaMessage]) -> OpcUaNodes:
        firmware = self.firmware
        return OpcUaNodes(self.name, self.about, firmware, self._operations.do, lambda: firmware.plc.program, opcua)

    def start(self) -> None:
        self.firmware.power.start(self._settings.off_days)

    def stop(self) -> None:
        self.firmware.cycles.stop()

    @property
    def plc(self) -> Plc:
        """The program of the controller (`iec.controller.exchange.Programmed`)."""
        return self.firmware.plc

    # ---- points

    def front(self) -> Front:
        return front_of(self._points, self._settings)

    @property
    def end_of_cycle(self) -> Callable[[], None] | None:
        """The call at the end of each cycle of the real-time process (`Device.end_of_cycle`)."""
        return self.firmware.cycles.end_of_cycle

    @end_of_cycle.setter
    def end_of_cycle(self, action: Callable[[], None] | None) -> None:
        self.firmware.cycles.end_of_cycle = action

    def points(self) -> Mapping[str, Point]:
        return self._points

    def _make_points(self) -> None:
        """Make the points of the present boot.  A variable of the program has its path, unless a parameter has it."""
        own = dict(self._own_points())
        self._points = own | {path: point for path, point in self.firmware.plc.variables() if path not in own}

    def _own_points(self) -> Iterator[tuple[str, Point]]:
        firmware = self.firmware
        yield from parameter_points(firmware.tree)
        yield from input_points(self._settings, firmware.system.terminals)
        yield from self._operations.points()
        yield from memory_points(firmware.logger, firmware.disk, firmware.memory.ram)
        yield from state_points(firmware)
        yield from firmware.cycles.points()
        yield from firmware.plc.points()

    def _on_program(self) -> None:
        """Make the points again, because another program has been loaded, and offer the new nodes."""
        self._make_points()
        if self._opcua is not None:
            self._opcua.changed()

    # ---- tools (`fieldrig.device.Device`, `iec.controller.holder.ProgramHolder`)

    def troubles(self) -> Mapping[str, Value]:
        axes = self.firmware.axes
        return {**super().troubles(), **{f"{symbol}.DiagCode": axis.diag_code for symbol, axis in axes.items()}}

    def limits_reached(self) -> Mapping[str, float]:
        return self._network.limits_reached()

    def further_point(self, key: str) -> Point | None:
        return self._debugging.point(key)

    def answer(self, question: str, message: Any) -> Any:
        match question:
            case "debug":
                return self._debugging.answer(message)
            case "symbols":
                return {"xml": self.firmware.plc.symbol_list(self.name).decode()}
        return super().answer(question, message)

    @classmethod
    def without_program(cls) -> Sequence[str]:
        """Return changes of a rig file that leave out the program and the settings that refer to it."""
        return ["program=[]"]

    def compile_sources(self, files: Sequence[SourceFile]) -> Compiled:
        """Compile a program for this controller without loading it.  CompileError with every mistake."""
        firmware = self.firmware
        return firmware.plc.order(firmware.project.container(files)).compiled()

    @classmethod
    def tools(cls, name: str, settings: Any, links: Mapping[str, Any]) -> list[Tool]:
        """Return a line for each Modbus bus on which it is a unit."""
        return identification_lines(settings.modbus.unit_id, links.get("modbus", ()))
