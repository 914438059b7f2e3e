"""A PAM axes manager: power, basic cycle, panel, and the faces of its parts to the rig.

Source: PAM System V2.5 Reference Manual 006.8007.B (digests PAML and PAMS).  The application is compiled when the rig
starts, and runs from power-on.  Left out: the EEPROM with its compressed application, and the protocol of PAMDEBUGGER;
the debugger of fieldrig takes its place, and its serial line shows messages.
"""

import logging
from collections.abc import Collection, Mapping, Sequence
from datetime import datetime, timedelta
from functools import partial
from typing import Any, ClassVar, Final

from fieldrig.clock import MS, US, Alarm, Clock
from fieldrig.device import Device, Point, Tool, Value
from fieldrig.faults.faults import Fault, Faults
from fieldrig.faults.injected import InjectedFaults
from fieldrig.front import Front
from fieldrig.link import Link, words_behind
from fieldrig.loop.background import Background
from fieldrig.points.checks import truth_in
from fieldrig.text.source_text import decoded
from fieldrig_bus.dualport.message import Words
from fieldrig_bus.modbus.message import ModbusMessage
from fieldrig_bus.ring.pam.message import RingMessage
from fieldrig_bus.serial.message import SerialMessage
from fieldrig_bus.tcp.message import TcpMessage
from fieldrig_bus.wires import Signal
from fieldrig_devices.languages.debugging.service import DebugService
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.refusal import refused
from fieldrig_devices.modbus.tools import word_lines
from fieldrig_devices.pam.application_files import paths_beside, reader_beside, shapes_beside
from fieldrig_devices.pam.faults import MODELS, PowerOff
from fieldrig_devices.pam.front import front_of
from fieldrig_devices.pam.panel.catalogue import text_of
from fieldrig_devices.pam.panel.codes import Code, code_of
from fieldrig_devices.pam.panel.display import DIGITS, Display
from fieldrig_devices.pam.panel.info import panel_info
from fieldrig_devices.pam.panel.messages import Message, Messages
from fieldrig_devices.pam.panel.pam_display import PamDisplay
from fieldrig_devices.pam.ports import byte_order_of
from fieldrig_devices.pam.ports.access.faces import MemoryFaces
from fieldrig_devices.pam.ports.memory import WORDS, Memory
from fieldrig_devices.pam.power_cycle import PanelPart, PowerCycle, PowerState
from fieldrig_devices.pam.runtime.compiler import Compiled, compile_application
from fieldrig_devices.pam.runtime.machine_debuggee import MachineDebuggee
from fieldrig_devices.pam.runtime.runtime import Runtime
from fieldrig_devices.pam.settings import PamSettings
from fieldrig_devices.pam.variable_points import variable_points

log = logging.getLogger(__name__)

LONGEST_NAME: Final = 11
"""Characters of the name of an application that the display scrolls (manual line 846)."""
BLINKING: Final = (2, 3)
"""The origins of fatal errors after which the LED blinks."""


class Pam(Device):
    about: ClassVar[str] = (
        "a PAM axes manager: applications in its language, a ring of ST1 and Smart-IO nodes, PLC ports"
    )
    has_cycle = True
    trouble_keys: ClassVar[Collection[str]] = ("fault",)
    diagnosis_keys: ClassVar[Collection[str]] = ("errors",)
    log_keys: ClassVar[Collection[str]] = ("messages",)
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(
        self,
        clock: Clock,
        settings: PamSettings,
        background: Background,
        ring: Link[RingMessage],
        wires: Link[Signal] | None = None,
        debugger: Link[SerialMessage] | None = None,
        rs422: Link[SerialMessage] | None = None,
        modbus: list[Link[ModbusMessage]] | None = None,
        tcp: Link[TcpMessage] | None = None,
        dualport: Link[Words] | None = None,
    ) -> None:
        """ConfigError, with every mistake, for an application that cannot be compiled."""
        self._clock, self._settings, self._ring = clock, settings, ring
        self._wires, self._rs422 = wires, rs422
        self._compiled = _compiled(settings)
        self._memory = Memory(words_behind(dualport))
        self._faces = MemoryFaces(
            clock,
            self._memory,
            byte_order_of(self._compiled.program, settings.ports),
            settings.access,
            modbus or [],
            tcp,
        )
        self._display = Display()
        self._messages = Messages(lambda text: _send(debugger, text))
        self._panel = PanelPart({"PAMDISPLAY": [PamDisplay(self._show, self._monitor)]})
        self._volts = {0: 0.0, 1: 0.0}
        self._cycle: PowerCycle | None = None
        self._timer = Alarm(self._clock)
        self._begin_ns = self._cycles = 0
        self._debuggee = MachineDebuggee(
            background,
            lambda: self.application,
            self.reset,
            self._on_loaded,
            ignores_case=settings.programs.ignores_case,
        )
        self._debugging = DebugService(clock, self._debuggee)
        self.injected = self._faults = InjectedFaults[Fault[Any]](
            clock, MODELS, Faults(Fault), on_change=self._on_faults
        )
        self._points = self._make_points()
        if rs422 is not None:
            rs422.on_receive(self._on_rs422)

    # ---- power

    def start(self) -> None:
        self._faces.open()
        if self._faults.first(PowerOff) is None:
            self._power_on()

    def stop(self) -> None:
        self._debuggee.cancel()
        self._faces.close()
        self._power_off()

    def _on_faults(self) -> None:
        has_power = self._faults.first(PowerOff) is None
        if has_power and self._cycle is None:
            self._power_on()
        elif not has_power and self._cycle is not None:
            self._power_off()
            self._memory.write(0, [0] * WORDS)

    def _power_on(self) -> None:
        now_ns = self._clock.now_ns()
        name = self._compiled.application
        self._messages.clear()
        self._display.restart(f"{name.name[:LONGEST_NAME]} V{name.version}", now_ns)
        for address in self._volts:
            self._set_volts(address, 0.0)
        self._cycle = PowerCycle(
            self._clock,
            self._ring,
            self._compiled,
            self._settings,
            self._memory,
            self._panel,
            shapes=shapes_beside(self._settings.application),
            volts=self._set_volts,
            rs422=lambda data: _send(self._rs422, data),
            on_message=self._on_message,
        )
        self._begin_ns, self._cycles = now_ns, 0
        self._cycle.start()
        self._wait()

    def _power_off(self) -> None:
        self._cycle = None
        self._timer.stop()

    def reset(self) -> None:
        """Carry out a hardware reset: everything begins again, and the DualPort keeps its contents."""
        self._power_off()
        self._power_on()

    # ---- the basic cycle

    def _wait(self) -> None:
        self._cycles += 1
        passed_ns = self._cycles * self._compiled.thirds * MS // 3
        self._timer.at(self._begin_ns + passed_ns, self._on_cycle)

    def _on_cycle(self) -> None:
        cycle = self._cycle
        assert cycle is not None
        was_running = cycle.state is PowerState.RUNNING
        cycle.cycle()
        if cycle.state is PowerState.RUNNING and not was_running:
            self._debuggee.attach(cycle.runtime)
        if cycle.state is not PowerState.FATAL:
            self._wait()
        if self.end_of_cycle is not None:
            self.end_of_cycle()

    # ---- for the debugger

    @property
    def application(self) -> Runtime | None:
        """The application, once its programs have begun."""
        return self._cycle.application if self._cycle is not None else None

    def _on_loaded(self, compiled: Compiled) -> None:
        self._compiled = compiled
        self._points = self._make_points()
        if self._cycle is not None:
            self.reset()

    def further_point(self, key: str) -> Point | None:
        return self._debugging.point(key)

    def answer(self, question: str, message: Any) -> Any:
        """Answer `debug` questions (`languages/debugging/service.py`)."""
        if question != "debug":
            return super().answer(question, message)
        return self._debugging.answer(message)

    # ---- messages

    def _date(self) -> datetime:
        return self._settings.date + timedelta(microseconds=self._clock.now_ns() // US)

    def _on_message(self, text: str, details: Sequence[int], words: str) -> None:
        """Show a message of the system, and write the panel of the ports if it is fatal."""
        code = code_of(text)
        is_first = self._messages.fatal is None
        if code.is_fatal:
            log.info("the application stops: %s %s", code, words or text_of(code))
        self._show(code, words or text_of(code), tuple(details))
        if code.is_fatal and is_first and self._cycle is not None:
            self._cycle.ports.fail(code.origin, code.number, self._date(), *panel_info(code, details))

    def _show(self, code: Code, text: str, details: tuple[int | float, ...]) -> None:
        self._messages.add(Message(code, text, details, self._date()))
        self._display.show(code, self._clock.now_ns())

    def _monitor(self, value: float) -> None:
        self._display.monitor(value, self._clock.now_ns())

    def _on_rs422(self, message: SerialMessage) -> None:
        if isinstance(message, bytes) and self._cycle is not None:
            self._cycle.ports.receive(message)

    # ---- outputs of the front

    def _set_volts(self, address: int, volts: float) -> None:
        self._volts[address] = volts
        wires = self._settings.analog_wires
        if self._wires is not None and address < len(wires) and wires[address]:
            self._wires.send(Signal(wires[address], volts, "V"))

    def _led(self) -> str:
        """Return the state of the green LED: it blinks after errors of the kernel (tables 12-8 to 12-10)."""
        if self._cycle is None:
            return "off"
        fatal = self._messages.fatal
        return "blink" if fatal is not None and fatal.code.origin in BLINKING else "on"

    # ---- points

    @classmethod
    def tools(cls, name: str, settings: PamSettings, links: Mapping[str, Any]) -> list[Tool]:
        """Return a line for each Modbus bus that reads the first words of the DualPort."""
        return word_lines(settings.access.unit_id, links.get("modbus", ()))

    def front(self) -> Front:
        return front_of(self._volts)

    def points(self) -> Mapping[str, Point]:
        return self._points

    def _make_points(self) -> Mapping[str, Point]:
        return {
            **dict(variable_points(self._compiled, lambda: self.application)),
            "display": Point(self._shown, about="the eight characters on the display"),
            "display.blinks": Point(lambda: self._cycle is not None and self._display.blinks()),
            "led": Point(self._led, about="the green LED: off, on or blink"),
            "state": Point(self._state, about="off, ring, ports, running or fatal"),
            "ring": Point(lambda: self._cycle.ring.phase.name.lower() if self._cycle else "off"),
            "cycle": Point(lambda: self._cycles, about="basic cycles since power-on"),
            "messages": Point(lambda: "\n".join(self._messages.printed), about="what the debugger printed last"),
            "errors": Point(self._listed, about="the error list: the codes of errors, fatal errors and ends"),
            "fault": Point(self._fault, about="why the application has stopped, with its line"),
            "reset": Point(lambda: False, self._write_reset, about="write true for a hardware reset"),
            **{
                f"analog.{address}": Point(partial(self._volts.__getitem__, address), unit="V")
                for address in self._volts
            },
        }

    def _shown(self) -> str:
        return " " * DIGITS if self._cycle is None else self._display.text(self._clock.now_ns())

    def _state(self) -> str:
        return "off" if self._cycle is None else self._cycle.state.value

    def _listed(self) -> str:
        return "\n".join(str(entry.code) for entry in self._messages.listed)

    def _fault(self) -> str:
        """Return the fault of the program, or else the first fatal error."""
        fault, fatal = None if self._cycle is None else self._cycle.runtime.fault, self._messages.fatal
        return str(fault) if fault is not None else "" if fatal is None else f"{fatal.code} {fatal.text}"

    def _write_reset(self, value: Value) -> None:
        if truth_in(value) and self._cycle is not None:
            self.reset()


def _compiled(settings: PamSettings) -> Compiled:
    path = settings.application
    try:
        ignores_case = settings.programs.ignores_case
        text = decoded(path.read_bytes())
        compiled = compile_application(text, path.name, reader_beside(path), ignores_case=ignores_case)
        compiled.code.marked.locate(paths_beside(path))
        return compiled
    except CompileError as wrong:
        raise refused(wrong, {path.name: str(path)}) from wrong


def _send(line: Link[SerialMessage] | None, data: bytes) -> None:
    if line is not None:
        line.send(data)
