"""The MAx-4 PacController: boot, messages and diagnosis, memory, real-time process, and the master of the fibre ring.

Source: PacDrive system manual 17130061, edition 2003-10; digest sections 1.1 to 1.7, 1.10, 1.16, 1.17.  IEC programs
run in its PLC (`plc/`).
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from ipaddress import IPv6Address, ip_address
from typing import Any, ClassVar

from fieldrig.clock import Clock
from fieldrig.device import Device, Point, Tool, Value
from fieldrig.link import Link
from fieldrig.loop.background import Background
from fieldrig.storage.store import Store
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.shared import SharedLink
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
from fieldrig_devices.max4.acknowledgement import Acknowledgement
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.boot import Boot
from fieldrig_devices.max4.com1.parameters import Com1Parameters
from fieldrig_devices.max4.com1.port import Com1
from fieldrig_devices.max4.configuration.program_file import PROGRAM_FILE
from fieldrig_devices.max4.configuration.tree import ObjectTree
from fieldrig_devices.max4.configuration.version import TIME_STAMPS, version_of
from fieldrig_devices.max4.cycles import Cycles
from fieldrig_devices.max4.debuggee import PlcDebuggee
from fieldrig_devices.max4.faults import MODELS
from fieldrig_devices.max4.field_buses import FieldBuses
from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.max4.messages.diagnosis import LZS, MAX4, Diagnosis, Sender
from fieldrig_devices.max4.messages.logger import Logger
from fieldrig_devices.max4.network import Network
from fieldrig_devices.max4.opcua import OpcUaNodes
from fieldrig_devices.max4.operations import Operations
from fieldrig_devices.max4.pages.site import default_pages
from fieldrig_devices.max4.plc.plc import Plc
from fieldrig_devices.max4.points import input_points, memory_points, parameter_points
from fieldrig_devices.max4.power import Power
from fieldrig_devices.max4.project import Project
from fieldrig_devices.max4.reports import Reports
from fieldrig_devices.max4.settings import Max4Settings
from fieldrig_devices.max4.storage.disk import FlashDisk
from fieldrig_devices.max4.storage.memory import Memory
from fieldrig_devices.max4.system import System
from fieldrig_devices.modbus.tools import identification_lines


class Max4(Device):
    """The controller, which connects its parts, and boots and ends them together."""

    about = "MAx-4 PacController: object tree, messages and diagnosis, master of the SERCOS ring of MC-4 drives"
    trouble_keys: ClassVar[Collection[str]] = ("DiagCode", "plc/fault")
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
        self._clock, self.name, self._settings, self._wires = clock, name, settings, wires
        self._points: dict[str, Point] = {}
        self._err_shown = False
        self._boot_actions: list[Callable[[], None]] = []
        self._end_actions: list[Callable[[], None]] = []
        version = version_of(settings.version)
        self.disk = FlashDisk(store, settings.disk_bytes)
        self.memory = Memory(store, self.disk, settings.retain, has_battery=settings.retain_battery)
        self._boot = Boot(
            clock,
            settings.boot,
            on_started=lambda: self.report(Code.BOOT_STARTED, MAX4),
            on_program=self._on_autostart,
            on_finished=lambda: self.report(Code.BOOT_FINISHED, MAX4),
        )
        self.logger = Logger(self.memory.ram.log, self.disk, self._boot.now_ms)
        self.logger.is_plain = version < TIME_STAMPS
        self.reports = Reports(self.logger, settings.language, settings.diagnosis_classes, self._on_diagnosis)
        self.cycles = Cycles(clock, ring, settings, self._boot, self.reports)
        self._acknowledgement = Acknowledgement(self.reports, lambda: self.cycles.bus)
        self._power = Power(clock, self.memory, self, self._set_delay)
        self.injected = self._power.injected
        self._network = Network(clock, random, self, self.disk, settings, com1, tcp, relay)
        self._project = Project(settings, self.disk, default_pages() if self._network.has_pages else None)
        self.plc = Plc(clock, self, settings, self._project, self.disk, self.memory.ram, self.reports, background)
        self.system = System(clock, settings, settings.configuration, settings.parameters, wires, self)
        if self.system.unknown:
            raise ValueError("parameters: " + "; ".join(self.system.unknown))
        if self._project.install(self.system.stored_values()):
            self.memory.ram.retained.clear()
        self.disk.on_write = lambda file: self.report(Code.FILE_WRITTEN, LZS, file)
        self._operations = Operations(clock, self, self.plc, self._project, self.disk, version)
        self._debugging = DebugService(clock, PlcDebuggee(self, self.plc, self._operations, background))
        shared = None if can is None else SharedLink(can)
        self._field_buses = FieldBuses(clock, self, settings, modbus or [], shared)
        self._field_buses.add_objects(self.tree)
        self.plc.check_settings()
        self._opcua = None if opcua is None else self._nodes_at(opcua)

    def _nodes_at(self, opcua: Link[OpcUaMessage]) -> OpcUaNodes:
        return OpcUaNodes(self.name, self.about, self, self._operations.do, lambda: self.plc.program, opcua)

    # ---- power, boot, reset

    def start(self) -> None:
        self._power.start(self._settings.off_days)

    def stop(self) -> None:
        self.cycles.stop()

    @property
    def is_on(self) -> bool:
        return self._power.is_on

    def power_on(self) -> None:
        """Start a boot with the present files."""
        self.memory.move_to_store()
        loaded = self._project.load()
        self.reports.diagnosis.reset()
        self._boot.begin()
        self.system = System(self._clock, self._settings, loaded.configuration, loaded.values, self._wires, self)
        for axis in self.axes.values():
            axis.on_quit(self._acknowledgement.of_axis)
        self.logger.filter = int(self.tree.get("MAx-4.General.MsgFilter"))
        if self.tree.get("MAx-4.General.RetainInit"):
            self.memory.ram.retained.clear()
        if not loaded.is_good:
            self._when_heard(Code.CONFIGURATION, MAX4, self._project.configuration_file)
        for action in self._boot_actions:
            action()
        self._network.boot()
        self.plc.boot()
        if self.plc.problem:
            self._when_heard(Code.PROGRAM, LZS, PROGRAM_FILE)
        self._boot.go(has_autostart=self._settings.autostart and self.plc.program is not None)
        self._points = self._present_points()
        self.system.start()
        self.cycles.begin(self.system)

    def _when_heard(self, code: Code, sender: Sender, ext: str = "") -> None:
        self._boot.when_heard(lambda: self.report(code, sender, ext))

    def on_memory_lost(self) -> None:
        self._when_heard(Code.RAM_LOST, MAX4)

    def power_off(self) -> None:
        self._end()
        self.reports.diagnosis.reset()
        self.system.terminals.fall()

    def _end(self) -> None:
        for action in self._end_actions:
            action()
        self._network.end()
        self._operations.cancel()
        self.plc.end()
        self.cycles.end()
        self._boot.end()

    def reset(self) -> None:
        """Carry out a system reset (PD-045): report it and boot again."""
        self.report(Code.SYSTEM_RESET, MAX4)
        self._end()
        self.power_on()

    def _on_autostart(self) -> None:
        self.plc.start()
        self.report(Code.AUTOSTART, LZS)

    def _set_delay(self, us: int) -> None:
        self.system.process.delay_us = us

    # ---- for the faces (`core.Controller`)

    @property
    def axes(self) -> Mapping[str, Axis]:
        return self.system.axes

    @property
    def tree(self) -> ObjectTree:
        return self.system.tree

    @property
    def diagnosis(self) -> Diagnosis:
        return self.reports.diagnosis

    @property
    def cycle_ns(self) -> int:
        return self.system.cycle_ns

    @property
    def is_booted(self) -> bool:
        return self._boot.is_finished

    @property
    def markers(self) -> bytearray | None:
        program = self.plc.program
        return None if program is None else program.runtime.markers

    def each_cycle(self, action: Callable[[], None]) -> None:
        self.cycles.add(action)

    def at_priority(self, priority: int, duration_us: int, action: Callable[[], None]) -> None:
        self.plc.at_priority(priority, duration_us, action)

    def on_boot(self, action: Callable[[], None]) -> None:
        self._boot_actions.append(action)

    def on_end(self, action: Callable[[], None]) -> None:
        self._end_actions.append(action)

    def section(self, name: str) -> Store:
        return self.disk.section(name)

    def report(self, code: int, sender: Sender, ext: str = "") -> None:
        if self.is_on:
            self.reports.report(code, sender, ext)

    def tcp_connected(self, peer: str) -> None:
        """Report that a server has accepted a connection from this IP address (PD-283)."""
        address = ip_address(peer.partition("%")[0])
        if isinstance(address, IPv6Address) and address.ipv4_mapped is not None:
            address = address.ipv4_mapped
        self.report(Code.TCP_CONNECTED, LZS, address.packed.hex())

    def login_refused(self, name: str) -> None:
        """Report that logins with this user name have failed several times."""
        self.report(Code.LOGIN_REFUSED, LZS, name)

    def quit_all(self) -> None:
        self._acknowledgement.of_all(self.axes.values())

    # ---- for the parts that need more (`plc.Owner`, `operations.Owner`, `own_object.Owner`, `network.Host`)

    def now_ms(self) -> int:
        return self._boot.now_ms()

    @property
    def com1(self) -> Com1:
        return self._network.com1

    @property
    def com1_parameters(self) -> Com1Parameters:
        return self.system.com1

    def renew_points(self) -> None:
        """Make the points again, because another program has been loaded, and offer the new nodes."""
        self._points = self._present_points()
        if self._opcua is not None:
            self._opcua.changed()

    # ---- LEDs, points

    def _on_diagnosis(self) -> None:
        is_flashing = self.diagnosis.code != 0
        if is_flashing is not self._err_shown:
            self._err_shown = is_flashing
            self.system.terminals.drive(self._settings.err_wire, is_flashing)

    def points(self) -> Mapping[str, Point]:
        return self._points

    def _present_points(self) -> dict[str, Point]:
        """The points of the present boot.  A variable of the program has its path, unless a parameter has it."""
        own = dict(self._own_points())
        return own | {path: point for path, point in self.plc.variables() if path not in own}

    def _own_points(self) -> Iterator[tuple[str, Point]]:
        yield from parameter_points(self.tree)
        yield from input_points(self._settings, self.system.terminals)
        yield from self._operations.points()
        yield from memory_points(self.logger, self.disk, self.memory.ram)
        yield "power", Point(lambda: self.is_on)
        yield "booted", Point(lambda: self.is_booted)
        yield "reset_needed", Point(self._is_reset_needed, about="true if the stored configuration has changed")
        yield "program", Point(lambda: "running" if self.plc.is_running else "stopped")
        yield "led.power", Point(lambda: "on" if self.is_on else "off")
        yield "led.err", Point(lambda: "flashing" if self.diagnosis.code else "off")
        yield "led.run", Point(lambda: "on" if self.plc.is_running else "off")
        yield from self.cycles.points()
        yield from self.plc.points()

    def _is_reset_needed(self) -> bool:
        """True if the configuration on the disk differs from the one in use (PD-027)."""
        return self._project.load().configuration != self.system.configuration

    # ---- tools (`fieldrig.device.Device`, `iec.controller.holder.ProgramHolder`)

    def troubles(self) -> Mapping[str, Value]:
        return {**super().troubles(), **{f"{symbol}.DiagCode": axis.diag_code for symbol, axis in self.axes.items()}}

    def answer(self, question: str, message: Any) -> Any:
        match question:
            case "debug":
                return self._debugging.answer(message)
            case "symbols":
                return {"xml": self.plc.symbol_list(self.name).decode()}
        return super().answer(question, message)

    @classmethod
    def without_program(cls) -> Sequence[str]:
        """Return changes of a rig file that leave out the program and the settings that refer to it."""
        return ["program=[]"]

    def compile_sources(self, files: Sequence[SourceFile]) -> Compiled:
        """Compile a program for this controller without loading it.  CompileError with every mistake."""
        return self.plc.order(self._project.container(files)).compiled()

    @classmethod
    def tools(cls, name: str, settings: Any, links: Mapping[str, Any]) -> list[Tool]:
        """Return a line for each Modbus bus on which it is a unit."""
        return identification_lines(settings.modbus.unit_id, links.get("modbus", ()))
