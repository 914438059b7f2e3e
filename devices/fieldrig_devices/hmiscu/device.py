"""The HMISCU, a panel with a controller and fast outputs: its parts, connected.

Source: Schneider, Magelis SCU HMI Controller PTO/PWM Library Guide, 12/2016 (digest SCU-001 to SCU-100).  Faces, image
and panel are ours, as that guide describes the outputs only.  Left out: the graphical panels of the display.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar

from fieldrig.bus import Bus
from fieldrig.clock import Clock
from fieldrig.device import Device, Point, Tool, Value
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.loop.background import Background
from fieldrig.storage.store import Store
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.shared import SharedLink
from fieldrig_bus.modbus.message import ModbusEvent
from fieldrig_bus.wires import Signal
from fieldrig_devices.canopen.point_slave import PointSlave
from fieldrig_devices.hmiscu.direct import DirectBlocks
from fieldrig_devices.hmiscu.faces.masters import Masters
from fieldrig_devices.hmiscu.faces.modbus import BLOCKS
from fieldrig_devices.hmiscu.faces.objects import EDS, points_by_object
from fieldrig_devices.hmiscu.fast_outputs import FastOutputs
from fieldrig_devices.hmiscu.faults import MODELS, HmiscuFaults
from fieldrig_devices.hmiscu.front import front_of
from fieldrig_devices.hmiscu.io import Terminals
from fieldrig_devices.hmiscu.panel import Panel
from fieldrig_devices.hmiscu.plc.debuggee import PlcDebuggee
from fieldrig_devices.hmiscu.plc.plc import Plc, PlcState
from fieldrig_devices.hmiscu.settings import HmiscuSettings
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.controller.variable_points import Variables
from fieldrig_devices.languages.debugging.service import DebugService
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.modbus.point_server import PointServer
from fieldrig_devices.modbus.tools import lines_for
from fieldrig_devices.registers.table import load_table


class Hmiscu(Device):
    about: ClassVar[str] = "an HMISCU: panel and controller with pulse and PWM outputs"
    has_cycle = True
    trouble_keys: ClassVar[Collection[str]] = ("plc/problem", "can/emcy.code", "can/emcy.heard")
    diagnosis_keys: ClassVar[Collection[str]] = ("*.PTOError", "*.ErrID")
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(
        self,
        clock: Clock,
        name: str,
        settings: HmiscuSettings,
        store: Store,
        background: Background,
        wires: Link[Signal] | None = None,
        modbus: list[Link[ModbusEvent]] | None = None,
        can: Link[CanFrame] | None = None,
    ) -> None:
        """ConfigError for a program or a register table with mistakes, ValueError for a face without its bus."""
        self._clock, self._settings = clock, settings
        self._terminals = Terminals(clock, settings, wires)
        self._fast = FastOutputs(clock, settings, self._terminals, wires)
        self._terminals.on_input = self._fast.on_input
        self._panel = Panel(self._terminals.outputs)
        self._masters = Masters(self.find, self.is_driven)
        self._plc = Plc(
            clock,
            settings,
            self._terminals,
            self,
            self._fast.make,
            self._fast.instances,
            self._panel,
            [self._masters.library()],
            background,
        )
        self.injected = HmiscuFaults(clock, self._fast, self._plc).injected
        self._variables = Variables(lambda: self._plc.program)
        self._debugging = DebugService(clock, PlcDebuggee(self._plc, background))
        self._direct = None if settings.program else DirectBlocks(settings, self._fast.make)
        self._can: PointSlave | None = None
        self._points: dict[str, Point] = {}
        self.on_program()
        self._connect_modbus(modbus or [])
        self._connect_can(None if can is None else SharedLink(can), name, store)
        self.on_program()

    def _connect_modbus(self, links: Sequence[Link[ModbusEvent]]) -> None:
        client = self._settings.modbus_client
        if client is not None:
            if client.link > len(links):
                raise ValueError(f"modbus_client.link: expected 1 to {len(links)}, one of links.modbus")
            self._masters.add_client(self._clock, links[client.link - 1], client)
        PointServer(
            self._clock, links, self._settings.modbus, self.find, self._masters.hear, partial(load_table, BLOCKS)
        )

    def _connect_can(self, can: SharedLink | None, name: str, store: Store) -> None:
        settings = self._settings
        for key in ("can_slave", "can_master"):
            if can is None and getattr(settings, key) is not None:
                raise ValueError(f"{key}: expected links.can beside it")
        if can is None:
            return
        if settings.can_master is not None:
            self._masters.add_master(self._clock, can.share(), settings.can_master)
        if settings.can_slave is not None:
            end = can.share(hears_others=settings.can_master is not None)
            self._can = PointSlave(
                self._clock,
                name,
                end,
                settings.can_slave,
                store,
                self.find,
                EDS,
                points_by_object(),
                self.why_refused,
            )

    def start(self) -> None:
        self._terminals.start()
        self._fast.start()
        if self._can is not None:
            self._can.start()
        self._masters.start()
        if self._settings.autostart:
            self._plc.start()

    def stop(self) -> None:
        self._plc.end()
        self._masters.stop()

    # ---- points

    def front(self) -> Front:
        return front_of(self._settings, self._fast.axis, self._points)

    def points(self) -> Mapping[str, Point]:
        return self._points

    def troubles(self) -> Mapping[str, Value]:
        return {**super().troubles(), **self._masters.troubles()}

    def find(self, name: str) -> Point | None:
        """Return the point that faces call `name`: one of the points, a channel by its usual name, or a variable."""
        present = self._fast.present_name(name)
        point = self._points.get(present)
        if point is None and self._plc.program is not None:
            variable = self._variables.point(name)
            return None if variable is None else self._guarded(present, variable)
        return point

    def is_driven(self, name: str) -> bool:
        """Return whether the program drives a point, whatever the state of the controller."""
        return self._plc.driven.has(self._fast.present_name(name))

    def why_refused(self, name: str) -> str:
        """Return why tools and masters may not set a point at present; empty if they may."""
        what, _ = self._refusal(name)
        return what

    def _refusal(self, name: str) -> tuple[str, str]:
        """Return why a point may not be set at present, and what to do about it; both are empty if it may."""
        present = self._fast.present_name(name)
        if self._plc.driven.has(present):
            return f"the program drives {name}", "a program that leaves it alone; `fieldrig debug` forces it"
        is_running = self._plc.state is PlcState.RUN
        if is_running and self._panel.is_written(present):
            return f"the program writes {name}", "another line, or a program that leaves it alone"
        if not is_running and self._plc.driven.is_output(present):
            return f"{name} does not change while the controller is not in RUN", "plc/command = run before it"
        return "", ""

    def _guarded(self, name: str, point: Point) -> Point:
        """Return the point, which refuses values while the program drives it."""
        act = point.write
        if act is None:
            return point

        def write(value: Value) -> None:
            what, remedy = self._refusal(name)
            if what:
                raise ValueError(f"{what}\nexpected {remedy}")
            act(value)

        return replace(point, write=write)

    @property
    def plc(self) -> Plc:
        """The programs of the controller (`iec.controller.exchange.Programmed`)."""
        return self._plc

    def _own_points(self) -> Iterator[tuple[str, Point]]:
        yield from self._plc.points()
        yield from self._terminals.points()
        yield from self._panel.points()
        yield from self._fast.points()
        if self._direct is not None and self._plc.program is None:
            yield from self._direct.points()
        yield from self._variables.points(self._fast.instances)

    # ---- for the programs (`plc.Owner`)

    def on_begin(self) -> None:
        self._masters.take()

    def call_blocks(self) -> None:
        if self._direct is not None:
            self._direct.call(self._clock.now_ns())

    def on_cycle(self) -> None:
        self._masters.give()
        if self._can is not None:
            self._can.wires.sample()  # a write has its effect in the next cycle
        if self.end_of_cycle is not None:
            self.end_of_cycle()

    def on_state(self, state: PlcState) -> None:
        if state is not PlcState.RUN:
            self._fast.shut_down()

    def on_program(self) -> None:
        can = self._can
        faces = dict(self._masters.points()) | ({} if can is None else dict(can.points()))
        own = {name: self._guarded(name, point) for name, point in self._own_points()}
        self._points = own | faces

    def restart_channels(self) -> None:
        self._fast.restart()
        if self._direct is not None:
            self._direct.renew()

    # ---- tools

    def further_point(self, key: str) -> Point | None:
        """Return a variable or pin that `points` does not list, by the name that faces use, or by `program:`."""
        return self._debugging.point(key) or self.find(key)

    def answer(self, question: str, message: Any) -> Any:
        """Answer `debug` questions (`languages/debugging/service.py`)."""
        if question != "debug":
            return super().answer(question, message)
        return self._debugging.answer(message)

    @classmethod
    def without_program(cls) -> Sequence[str]:
        """Return changes of a rig file that leave out the program and the settings that refer to it."""
        return ["program=[]", "modbus={}", "can_slave=null", "modbus_client=null", "can_master=null"]

    def compile_sources(self, files: Sequence[SourceFile]) -> Compiled:
        """Compile a program for this controller without loading it.  CompileError with every mistake."""
        return self._plc.compiler.compiled(files)

    @classmethod
    def tools(cls, name: str, settings: HmiscuSettings, links: Mapping[str, Any]) -> list[Tool]:
        """Return lines for the registers of the table, if the settings name one."""
        if settings.modbus.table is None:
            return []
        buses: Sequence[Bus[Any]] = links.get("modbus", ())
        return lines_for(load_table(settings.modbus.table), settings.modbus.unit_id, buses)
