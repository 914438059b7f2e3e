"""The MAx-4 PacController: boot, messages and diagnosis, memory, real-time process, and the master of the fibre ring.

Source: PacDrive system manual 17130061, edition 2003-10; digest sections 1.1 to 1.7, 1.10, 1.16, 1.17.  IEC programs
run in its PLC (`plc/`).
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from ipaddress import IPv6Address, ip_address
from typing import Any, ClassVar

from fieldrig.clock import Clock
from fieldrig.device import Device, Point, Tool, Value
from fieldrig.faults.faults import Fault, Faults
from fieldrig.faults.injected import InjectedFaults
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
from fieldrig_devices.max4.faults import MODELS, MemoryLost, Overrun, PowerOff
from fieldrig_devices.max4.field_buses import FieldBuses
from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.max4.messages.diagnosis import LZS, MAX4, Diagnosis, Sender
from fieldrig_devices.max4.messages.logger import Logger
from fieldrig_devices.max4.network import Network
from fieldrig_devices.max4.opcua import OpcUaNodes
from fieldrig_devices.max4.operations import Operations
from fieldrig_devices.max4.pages.site import default_pages
from fieldrig_devices.max4.plc.debuggee import PlcDebuggee
from fieldrig_devices.max4.plc.plc import Plc
from fieldrig_devices.max4.points import points
from fieldrig_devices.max4.project import Project
from fieldrig_devices.max4.reports import Reports
from fieldrig_devices.max4.ring.real_time_bus import RealTimeBus, State
from fieldrig_devices.max4.settings import Max4Settings
from fieldrig_devices.max4.storage.disk import FlashDisk
from fieldrig_devices.max4.storage.memory import Memory
from fieldrig_devices.max4.system import System
from fieldrig_devices.modbus.tools import identification_lines


class Max4(Device):
    """The controller, which connects its parts and implements its power, boot, programs and faults."""

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
        self._clock, self.name, self.settings = clock, name, settings
        self._ring, self._wires = ring, wires
        self.version = version_of(settings.version)
        self.disk = FlashDisk(store, settings.disk_bytes)
        self._memory = Memory(store, self.disk, settings.retain, has_battery=settings.retain_battery)
        self.ram, self.ups = self._memory.ram, self._memory.ups
        self.logger = Logger(self.ram.log, self.disk, lambda: self._boot.now_ms())
        self.logger.is_plain = self.version < TIME_STAMPS
        self.reports = Reports(self.logger, settings.language, settings.diagnosis_classes, self._on_diagnosis)
        self._boot = Boot(
            clock,
            settings.boot,
            on_started=lambda: self.report(Code.BOOT_STARTED, MAX4),
            on_program=self._on_autostart,
            on_finished=lambda: self.report(Code.BOOT_FINISHED, MAX4),
        )
        self.operations = Operations(clock, self)
        self.injected = self._faults = InjectedFaults[Fault[Any]](
            clock, self.fault_models, Faults(Fault), on_change=self._on_faults
        )
        self._actions: list[Callable[[], None]] = []
        self._boot_actions: list[Callable[[], None]] = []
        self._end_actions: list[Callable[[], None]] = []
        self.is_on = self._is_ticking = False
        self._was_lost = False
        self._off_days = 0.0
        self._err_shown = False
        self._network = Network(clock, random, self, self.disk, settings, com1, tcp, relay)
        self.system = System(clock, settings, settings.configuration, settings.parameters, wires, self)
        if self.system.unknown:
            raise ValueError("parameters: " + "; ".join(self.system.unknown))
        self.bus: RealTimeBus | None = None
        """The ring, or None if the controller has no ring or no drives."""
        self._acknowledgement = Acknowledgement(self.reports, lambda: self.bus)
        self.project = Project(settings, self.disk, default_pages() if self._network.has_pages else None)
        if self.project.install(self.system.stored_values()):
            self.ram.retained.clear()
        self.disk.on_write = self._on_file
        self._points: dict[str, Point] = {}
        self.can = None if can is None else SharedLink(can)
        """The CAN bus, which the CANopen master and the nodes of the controller share."""
        self._field_buses = FieldBuses(clock, self, settings, modbus or [], self.can)
        self.plc = Plc(clock, self, background)
        self._debugging = DebugService(clock, PlcDebuggee(self, background))
        self._field_buses.add_objects(self.tree)
        self.plc.check_settings()
        self.opcua = None if opcua is None else OpcUaNodes(self, opcua)
        """The nodes for OPC UA, or None without a link to such a bus."""

    # ---- power, boot, reset

    def start(self) -> None:
        if self._faults.first(PowerOff) is None:
            self._power_on(self.settings.off_days)

    def stop(self) -> None:
        if self.bus is not None:
            self.bus.stop()

    def _power_on(self, off_days: float) -> None:
        self.is_on = True
        is_lost = self._memory.power_on(off_days, is_lost=self._faults.first(MemoryLost) is not None)
        self._begin()
        if is_lost:
            self._report_loss()

    def _power_off(self) -> None:
        self.is_on = False
        self._memory.power_off()
        self._end()
        self.reports.diagnosis.reset()
        self.system.terminals.fall()

    def _begin(self) -> None:
        """Start a boot with the present files."""
        settings = self.settings
        self._memory.move_to_store()
        loaded = self.project.load()
        self.reports.diagnosis.reset()
        self._boot.begin()
        self.system = System(self._clock, settings, loaded.configuration, loaded.values, self._wires, self)
        self.system.process.actions = self._actions
        for axis in self.axes.values():
            axis.on_quit(self._acknowledgement.of_axis)
        self.logger.filter = int(self.tree.get("MAx-4.General.MsgFilter"))
        if self.tree.get("MAx-4.General.RetainInit"):
            self.ram.retained.clear()
        if not loaded.is_good:
            self._boot.when_heard(lambda: self.report(Code.CONFIGURATION, MAX4, self.project.configuration_file))
        for action in self._boot_actions:
            action()
        self._network.boot()
        self.plc.boot()
        if self.plc.problem:
            self._boot.when_heard(lambda: self.report(Code.PROGRAM, LZS, PROGRAM_FILE))
        self._boot.go(has_autostart=settings.autostart and self.plc.program is not None)
        self._points = points(self)
        self.system.start()
        self._tick_if_idle()
        self._begin_ring()

    def _begin_ring(self) -> None:
        if self._ring is None or not self.system.drives:
            self.bus = None
            self._boot.settle()
            return
        settings = self.settings
        self.bus = RealTimeBus(
            self._clock,
            self._ring,
            self,
            self.system.drives,
            self.system.drive_parameters,
            cycle_ns=self.cycle_ns,
            wait_ns=settings.boot.ring_wait_ms * 1_000_000,
            version=self.version,
            leave_out_missing=settings.missing_drive == "leave_out",
        )
        self.bus.bring_up()

    def _end(self) -> None:
        for action in self._end_actions:
            action()
        self._network.end()
        self.operations.cancel()
        self.plc.end()
        if self.bus is not None:
            self.bus.stop()
        for simulated in self.system.process.simulated:
            simulated.stop()
        self._boot.end()

    def reset(self) -> None:
        """Carry out a system reset (PD-045): report it and boot again."""
        self.report(Code.SYSTEM_RESET, MAX4)
        self._end()
        self._begin()

    # ---- files

    def _on_file(self, name: str) -> None:
        self.report(Code.FILE_WRITTEN, LZS, name)

    @property
    def is_reset_needed(self) -> bool:
        """True if the configuration on the disk differs from the one in use (PD-027)."""
        return self.project.load().configuration != self.system.configuration

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
        self._actions.append(action)

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

    @property
    def com1(self) -> Com1:
        return self._network.com1

    @property
    def com1_parameters(self) -> Com1Parameters:
        return self.system.com1

    def quit_all(self) -> None:
        self._acknowledgement.of_all(self.axes.values())

    # ---- for the ring (`real_time_bus.Host`)

    def report_ring(self, code: Code, ext: str = "") -> None:
        self._boot.when_heard(lambda: self.report(code, MAX4, ext))

    def report_axis(self, code: int, axis: Axis, ext: str = "", *, is_logged: bool = True) -> None:
        self._boot.when_heard(lambda: self.reports.report_axis(code, axis, ext, is_logged=is_logged))

    def on_ring_settled(self) -> None:
        self._boot.settle()

    def quit_axes(self) -> None:
        for axis in self.axes.values():
            if axis.is_operating:
                axis.quit_errors()

    def on_ring_cycle(self) -> None:
        process, bus = self.system.process, self.bus
        assert bus is not None
        if process.drives is not bus.present:
            process.lay_out(bus.present)
        process.run()

    def on_ring_lost(self) -> None:
        self.system.process.lay_out(())
        self._tick_if_idle()

    def _tick_if_idle(self) -> None:
        """Run the real-time process by the clock while there is no ring to drive it."""
        if not self._is_ticking:
            self._is_ticking = True
            self._clock.call_at(self._clock.now_ns() + self.cycle_ns, self._on_tick)

    def _on_tick(self) -> None:
        self._is_ticking = False
        is_ring_there = self.bus is not None and self.bus.state in (State.READING, State.UP)
        if self.is_on and not is_ring_there:
            self._tick_if_idle()
            self.system.process.run()

    # ---- for the parameters of the controller (`system.Owner`)

    def on_code(self, axis: Axis, code: int) -> None:
        """Report a code of a drive, unless it is pending here; a drive shows only its most severe code."""
        shown = self.reports.code_of(code)
        if all(pending.code != shown for pending in axis.diagnosis.pending):
            self.report_axis(code, axis)

    def on_overflow(self, reserve_us: int) -> None:
        self.report(Code.WRITE_OVERFLOW, MAX4, f"{reserve_us} us")

    def set_filter(self, mask: int) -> None:
        self.logger.filter = mask

    def at_errors(self, address: int) -> int:
        return self.bus.at_errors(address) if self.bus is not None else 0

    def own_value(self, name: str) -> Value:
        process = self.system.process
        match name:
            case "DiagCode":
                return self.diagnosis.code
            case "DiagExtCode":
                return self.diagnosis.ext
            case "DiagMsg":
                return self.diagnosis.msg
            case "MsgEntries":
                return len(self.logger)
            case "Timer1":
                return self._boot.now_ms() & 0xFFFF_FFFF
            case "Timer10":
                return self._boot.now_ms() // 10 & 0xFFFF_FFFF
            case "CycleLoad":
                measured = self.plc.load_percent
                return process.load_percent if measured is None else measured
            case "RTBReadRes":
                return process.read_reserve_us
            case "RTBWriteRes":
                return process.write_reserve_us
            case "Diskfree":
                return self.disk.free
        return self.settings.memory_free_bytes

    def task_value(self, number: int, name: str) -> Value:
        return self.plc.task_value(number, name)

    # ---- programs, LEDs

    @property
    def now_ms(self) -> Callable[[], int]:
        """Return Timer1, without its overflow."""
        return self._boot.now_ms

    @property
    def is_program_running(self) -> bool:
        return self.plc.is_running

    def _on_autostart(self) -> None:
        self.plc.start()
        self.report(Code.AUTOSTART, LZS)

    def _on_diagnosis(self) -> None:
        is_flashing = self.diagnosis.code != 0
        if is_flashing is not self._err_shown:
            self._err_shown = is_flashing
            self.system.terminals.drive(self.settings.err_wire, is_flashing)

    # ---- points and faults (`fieldrig.device.Device`)

    def points(self) -> Mapping[str, Point]:
        return self._points

    def troubles(self) -> Mapping[str, Value]:
        return {**super().troubles(), **{f"{symbol}.DiagCode": axis.diag_code for symbol, axis in self.axes.items()}}

    def answer(self, question: str, message: Any) -> Any:
        match question:
            case "debug":
                return self._debugging.answer(message)
            case "symbols":
                return {"xml": self.plc.symbol_list().decode()}
        return super().answer(question, message)

    @classmethod
    def without_program(cls) -> Sequence[str]:
        """Return changes of a rig file that leave out the program and the settings that refer to it."""
        return ["program=[]"]

    def compile_sources(self, files: Sequence[SourceFile]) -> Compiled:
        """See `iec.holder.ProgramHolder`."""
        return self.plc.compile_sources(files)

    def renew_points(self) -> None:
        """Make the points again, because another program has been loaded, and offer the new nodes."""
        self._points = points(self)
        if self.opcua is not None:
            self.opcua.changed()

    @classmethod
    def tools(cls, name: str, settings: Any, links: Mapping[str, Any]) -> list[Tool]:
        """Return a line for each Modbus bus on which it is a unit."""
        return identification_lines(settings.modbus.unit_id, links.get("modbus", ()))

    def _on_faults(self) -> None:
        overrun, off = self._faults.first(Overrun), self._faults.first(PowerOff)
        self.system.process.delay_us = overrun.us if overrun is not None else 0
        if off is not None:
            self._off_days = off.days
            if self.is_on:
                self._power_off()
        elif not self.is_on:
            self._power_on(self._off_days)
        is_lost = self._faults.first(MemoryLost) is not None
        if is_lost and not self._was_lost and self.is_on:
            self._memory.lose()
            self._report_loss()
        self._was_lost = is_lost

    def _report_loss(self) -> None:
        self._boot.when_heard(lambda: self.report(Code.RAM_LOST, MAX4))
