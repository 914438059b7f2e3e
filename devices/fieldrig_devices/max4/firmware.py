"""The firmware of the MAx-4: memory, messages, boot, programs and cycles, on which every face of the controller stands.

Source: PacDrive system manual 17130061, edition 2003-10; digest sections 1.1 to 1.7, 1.10, 1.16, 1.17.  IEC programs
run in its PLC (`plc/`).
"""

from collections.abc import Callable, Mapping
from ipaddress import IPv6Address, ip_address

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig.loop.background import Background
from fieldrig.storage.store import Store
from fieldrig_bus.ring.sercos.message import RingMessage
from fieldrig_bus.wires import Signal
from fieldrig_devices.max4.acknowledgement import Acknowledgement
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.boot import Boot
from fieldrig_devices.max4.com1.parameters import Com1Parameters, Port
from fieldrig_devices.max4.configuration.program_file import PROGRAM_FILE
from fieldrig_devices.max4.configuration.tree import ObjectTree
from fieldrig_devices.max4.configuration.version import TIME_STAMPS, version_of
from fieldrig_devices.max4.cycles import Cycles
from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.max4.messages.diagnosis import LZS, MAX4, Diagnosis, Sender
from fieldrig_devices.max4.messages.logger import Logger
from fieldrig_devices.max4.plc.plc import Plc
from fieldrig_devices.max4.power import Power
from fieldrig_devices.max4.project import Project
from fieldrig_devices.max4.reports import Language, Reports
from fieldrig_devices.max4.settings import Max4Settings
from fieldrig_devices.max4.storage.disk import FlashDisk
from fieldrig_devices.max4.storage.memory import Memory
from fieldrig_devices.max4.system import System


class Firmware:
    """The firmware of one controller, which implements `core.Controller` for the faces."""

    def __init__(
        self,
        clock: Clock,
        settings: Max4Settings,
        store: Store,
        background: Background,
        ring: Link[RingMessage] | None,
        wires: Link[Signal] | None,
        com1: Callable[[], Port],
    ) -> None:
        """Build it off.  `install` has to follow, when `com1` returns the port."""
        self._clock, self._settings, self._wires, self._com1 = clock, settings, wires, com1
        self._boot_actions: list[Callable[[], None]] = []
        self._end_actions: list[Callable[[], None]] = []
        self.on_system: Callable[[], None] = lambda: None
        """Called in each boot, when system and program are new."""
        self.on_program: Callable[[], None] = lambda: None
        """Called when another program has been loaded, or refused."""
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
        self.logger.is_plain = version_of(settings.version) < TIME_STAMPS
        self.reports = Reports(self.logger, settings.language, settings.diagnosis_classes, self._on_diagnosis)
        self._err_shown = False
        self.cycles = Cycles(clock, ring, settings, self._boot, self.reports)
        self._acknowledgement = Acknowledgement(self.reports, lambda: self.cycles.bus)
        self.power = Power(clock, self.memory, self, self._set_delay)
        self.project = Project(settings, self.disk)
        self.plc = Plc(clock, self, settings, self.project, self.disk, self.memory.ram, self.reports, background)

    def install(self, pages: Mapping[str, bytes]) -> None:
        """Install the project of the rig file if it has changed, with these pages.

        ValueError for settings that do not fit each other, such as start values that no parameter can have.
        """
        settings = self._settings
        self.system = System(self._clock, settings, settings.configuration, settings.parameters, self._wires, self)
        if self.system.unknown:
            raise ValueError("parameters: " + "; ".join(self.system.unknown))
        if self.project.install(self.system.stored_values(), pages):
            self.memory.ram.retained.clear()
        self.disk.on_write = lambda name: self.report(Code.FILE_WRITTEN, LZS, name)

    # ---- power, boot, reset

    @property
    def is_on(self) -> bool:
        return self.power.is_on

    def power_on(self) -> None:
        """Start a boot with the present files."""
        self.memory.move_to_store()
        loaded = self.project.load()
        self.reports.diagnosis.reset()
        self._boot.begin()
        self.system = System(self._clock, self._settings, loaded.configuration, loaded.values, self._wires, self)
        self._set_delay(self.power.delay_us)
        for axis in self.axes.values():
            axis.on_quit(self._acknowledgement.of_axis)
        # The logger outlasts the tree, and a parameter that no start value sets calls no watcher.
        self.logger.filter = int(self.tree.get("MAx-4.General.MsgFilter"))
        if self.tree.get("MAx-4.General.RetainInit"):
            self.memory.ram.retained.clear()
        if not loaded.is_good:
            self._when_heard(Code.CONFIGURATION, MAX4, self.project.configuration_file)
        # The faces before the program: they add the objects of their modules to the tree, which the program may name.
        for action in self._boot_actions:
            action()
        self.plc.boot()
        if self.plc.problem:
            self._when_heard(Code.PROGRAM, LZS, PROGRAM_FILE)
        self._boot.go(has_autostart=self._settings.autostart and self.plc.program is not None)
        self.on_system()
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
    def language(self) -> Language:
        return self.reports.language

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

    # ---- for the parts of it (`plc.Owner`, `operations.Owner`, `own_object.Owner`, `network.Host`)

    def now_ms(self) -> int:
        return self._boot.now_ms()

    @property
    def com1(self) -> Port:
        return self._com1()

    @property
    def com1_parameters(self) -> Com1Parameters:
        return self.system.com1

    def renew_points(self) -> None:
        self.on_program()

    @property
    def is_reset_needed(self) -> bool:
        """True if the configuration on the disk differs from the one in use (PD-027)."""
        return self.project.load().configuration != self.system.configuration

    def _on_diagnosis(self) -> None:
        is_flashing = self.diagnosis.code != 0
        if is_flashing is not self._err_shown:
            self._err_shown = is_flashing
            self.system.terminals.drive(self._settings.err_wire, is_flashing)
