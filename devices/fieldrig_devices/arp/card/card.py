"""The ASA-RT ARP two-axis card: its control loop, its scheduler and its ports.

Source: software manual 1.30; digest chapters 10 and 11.  Every @Par[1] ms the control loop processes inputs and outputs
and gives the program its slice; every @Par[16] ms the scheduler checks Enable and serves CAN and terminal.  Both
periods are read at power-on.  If a loop is late by whole periods, because the host is busy, they are skipped and
counted.
"""

from collections.abc import Collection, Mapping
from functools import cached_property
from typing import Any, ClassVar

from fieldrig.bus import Bus
from fieldrig.clock import MS, Clock
from fieldrig.device import Device, Point, Tool
from fieldrig.errors import RigError
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.loop.background import Background
from fieldrig.storage.store import Store
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.shared import SharedLink
from fieldrig_bus.serial.message import SerialMessage
from fieldrig_bus.wires import Signal
from fieldrig_devices.arp.can.bit_rate import take_bit_rate
from fieldrig_devices.arp.can.face import CanFace
from fieldrig_devices.arp.card import tools
from fieldrig_devices.arp.card.access import Access
from fieldrig_devices.arp.card.assembly import assemble
from fieldrig_devices.arp.card.faults import MODELS, ArpFaults
from fieldrig_devices.arp.card.front import front_of
from fieldrig_devices.arp.card.operation import Operation
from fieldrig_devices.arp.card.points import points
from fieldrig_devices.arp.card.settings import ArpSettings
from fieldrig_devices.arp.card_access import CardState
from fieldrig_devices.arp.card_errors import STOPPED_PROGRAM, CardErrors
from fieldrig_devices.arp.debug_sources import of_file
from fieldrig_devices.arp.debuggee import ArpDebuggee
from fieldrig_devices.arp.fixed import SCALE
from fieldrig_devices.arp.language.program_file import read_program
from fieldrig_devices.arp.parameters import GENERAL, Par
from fieldrig_devices.arp.runtime.program import ProgramState
from fieldrig_devices.arp.runtime.slices import Slices
from fieldrig_devices.arp.user_port.server import UserPort
from fieldrig_devices.languages.debugging.service import PROGRAM, DebugService


class ArpCard(Device):
    about = "ASA-RT ARP two-axis card: BASIC program, axes, electronic cam, tension control, CAN, USER port"
    has_cycle = True
    trouble_keys: ClassVar[Collection[str]] = ("error", "warning")
    diagnosis_keys: ClassVar[Collection[str]] = ("axis*.error",)
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(
        self,
        clock: Clock,
        name: str,
        settings: ArpSettings,
        store: Store,
        background: Background,
        wires: Link[Signal] | None = None,
        can: Link[CanFrame] | None = None,
        user: Link[SerialMessage] | None = None,
    ) -> None:
        """Raises RigError for a program that cannot be used, and for settings that need CAN if the card has none."""
        if can is None and settings.needs_can:
            raise RigError(
                "terminal, io_nodes and exchange need a CAN bus, and the card has none", "add `can` to its links"
            )
        self._clock, self._settings, self._can = clock, settings, can
        program = read_program(settings.program, settings.number) if settings.program is not None else None
        shared = SharedLink(can) if can is not None else None
        has_io = any(node_id is not None for node_id in settings.io_nodes)
        self.parts = assemble(
            clock,
            name,
            settings,
            store,
            wires,
            shared.share() if shared is not None and has_io else None,
            shared.share() if shared is not None and settings.terminal else None,
            CardErrors(self._on_blocking),
        )
        self.injected = self._faults = ArpFaults(clock)
        self.parts.memory.answers = lambda: self._faults.has_memory
        source = of_file(settings.program)
        file = settings.program if source is not None else None
        self.operation = Operation(self.parts, settings.parameters, program, file, background)
        self.access = Access(self.parts, self.operation)
        self._face: CanFace | None = None
        if shared is not None:
            section = self.parts.memory.section("can", self.operation.on_memory_fault)
            self._face = CanFace(clock, name, shared.share(), self.access, section, settings.exchange)
        self._user_port = UserPort(clock, user, self.access, settings.user_port) if user is not None else None
        self._background = background
        self._first = (program, source) if program is not None and source is not None else None
        self._debuggee: ArpDebuggee | None = None
        self._due_ns = 0
        self._period_ns = self._scheduler_period_ns = MS
        self._slices = Slices(settings.costs, MS, MS)
        self.cycles = self.missed_cycles = 0

    def start(self) -> None:
        parts, clock = self.parts, self._clock
        self.operation.power_on()
        table = parts.parameters.ram[GENERAL]
        self._period_ns = table[Par.CONTROL_PERIOD_MS] // SCALE * MS
        self._scheduler_period_ns = table[Par.SCHEDULER_PERIOD_MS] // SCALE * MS
        self._slices = Slices(self._settings.costs, self._period_ns, self._scheduler_period_ns)
        if self._can is not None:
            take_bit_rate(self._can, parts.parameters)
        if parts.remote_io is not None:
            parts.remote_io.start()
        parts.terminal.start(table[Par.TERMINAL_NODE_ID] // SCALE if self._settings.terminal else None)
        if self._face is not None:
            self._face.start()
        if self._user_port is not None:
            self._user_port.start()
        parts.io.send_changes()
        self._due_ns = clock.now_ns() + self._period_ns
        clock.call_at(clock.now_ns() + self._scheduler_period_ns, self._on_scheduler)
        clock.call_at(self._due_ns, self._on_control)

    def front(self) -> Front:
        return front_of(self._settings.signals)

    def points(self) -> Mapping[str, Point]:
        return self._points

    @cached_property
    def _points(self) -> dict[str, Point]:
        return {
            **points(self.access, self.parts.io),
            "cycles": Point(lambda: self.cycles, about="control loops since power-on"),
            "missed_cycles": Point(
                lambda: self.missed_cycles, about="control loops that were skipped because the host was busy"
            ),
        }

    def further_point(self, key: str) -> Point | None:
        return self._debugging.point(key) if key.startswith(PROGRAM) else None  # it begins with the first question

    def answer(self, question: str, message: Any) -> Any:
        return self._debugging.answer(message) if question == "debug" else super().answer(question, message)

    @cached_property
    def _debugging(self) -> DebugService:
        """The debugging service, which takes part in the control loop from its first question on."""
        self._debuggee = ArpDebuggee(self.access, self._background, self._first)
        return DebugService(self._clock, self._debuggee)

    @classmethod
    def tools(cls, name: str, settings: ArpSettings, links: Mapping[str, Bus[Any]]) -> list[Tool]:
        return tools.lines(name, settings, links)

    def _on_blocking(self, code: int) -> None:
        self.operation.on_blocking(code)

    # ---- every @Par[16] ms

    def _on_scheduler(self) -> None:
        self._clock.call_at(self._clock.now_ns() + self._scheduler_period_ns, self._on_scheduler)
        parts = self.parts
        self.operation.look_at_enable(parts.io.is_enabled)
        if self._faults.stops_program and self.operation.state is CardState.RUN:
            parts.errors.fail(STOPPED_PROGRAM)
        if parts.remote_io is not None:
            parts.remote_io.refresh()
        parts.terminal.refresh()
        if self._face is not None:
            self._face.refresh()

    # ---- every @Par[1] ms

    def _on_control(self) -> None:
        now_ns = self._clock.now_ns()
        self._plan_next(now_ns)
        parts, operation, debuggee = self.parts, self.operation, self._debuggee
        io, state = parts.io, operation.state
        io.sample(now_ns)
        if debuggee is not None:
            debuggee.force_inputs()
        parts.analog_inputs.control(now_ns)
        parts.axes.control(now_ns, self._faults.counted(io.counts), io.latches)
        if state is CardState.RUN or state is CardState.STOPPED:
            parts.regulators.control(now_ns)
            parts.cam_switches.control()
            parts.analog_outputs.control(now_ns)
            if state is CardState.RUN:
                self._run_program()
        parts.permanent.keep()
        if debuggee is not None:
            debuggee.force_outputs()
            debuggee.tick()
        io.send_changes()
        if self._user_port is not None:
            self._user_port.tick()
        if self.end_of_cycle is not None:
            self.end_of_cycle()

    def _run_program(self) -> None:
        program = self.operation.program
        assert program is not None, "a card without a program does not run"
        program.tick()
        program.look = self.look
        self._slices.give(program.run)
        if program.state is ProgramState.ENDED:
            self.operation.look_at_program()

    def _plan_next(self, now_ns: int) -> None:
        """Schedule the next loop; loops that should have run by now are counted as missed."""
        period_ns = self._period_ns
        late_ns = now_ns - self._due_ns + self._clock.late_ns()
        missed = late_ns // period_ns if late_ns >= period_ns else 0
        self.cycles += 1
        self.missed_cycles += missed
        self._due_ns += (1 + missed) * period_ns
        self._clock.call_at(self._due_ns, self._on_control)
