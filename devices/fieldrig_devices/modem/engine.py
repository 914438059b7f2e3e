"""The modem between its plugs: its states, what the terminal sends in each, ringing, and the control lines.

It is a function of messages and timers.  `Interpreter` carries out commands by the methods of `Actions` here.
"""

from collections.abc import Callable
from enum import Enum
from typing import Final

from fieldrig.clock import MS, Alarm, Clock
from fieldrig.link import Link
from fieldrig_bus.serial.message import ControlLines, Format, SerialMessage
from fieldrig_bus.telephone.message import Carrier, Heard, Offer, Ready, Ring, TelephoneMessage
from fieldrig_bus.telephone.modulation import Agreed
from fieldrig_devices.modem import results
from fieldrig_devices.modem.call import Call, CallState, Events, Rules
from fieldrig_devices.modem.dial_string import steps_of
from fieldrig_devices.modem.interpreter import BUSY_WITH_IT, Interpreter
from fieldrig_devices.modem.line_watch import IdleWatch, Ringing
from fieldrig_devices.modem.plugs import SerialPlug
from fieldrig_devices.modem.profile import Memory
from fieldrig_devices.modem.reader import GUARD_UNIT_NS, CommandReader, Escape, Line
from fieldrig_devices.modem.results import Result
from fieldrig_devices.modem.rules import Build, fixed_form, rules_of
from fieldrig_devices.modem.speaker import Speaker
from fieldrig_devices.modem.terminal_side import MOST_WAITING, Flow, TerminalSide

DEAF_NS: Final = 125 * MS
"""How long characters after a command that dials or answers do not end it (V.250, 5.6.1)."""


class Mode(Enum):
    OFF = "off"
    COMMAND = "command"
    ONLINE = "online"
    ONLINE_COMMAND = "online command"


class Engine:
    def __init__(
        self,
        clock: Clock,
        build: Build,
        memory: Memory,
        save: Callable[[Memory], Result],
        serial: SerialPlug,
        telephone: Link[TelephoneMessage],
    ) -> None:
        self._clock, self._build, self.save, self._telephone = clock, build, save, telephone
        self.mode = Mode.OFF
        self.side = TerminalSide(clock, serial, Format(build.baud), build.is_paced)
        self.side.end.on_room = self._on_room_at_terminal
        self.call = Call(clock, telephone, Events(self._tell, self._on_connected, self._on_over))
        self.call.pump.on_room = lambda has_room: self.side.stop_terminal(not has_room)
        self._speaker = Speaker(self.side.send, lambda: self.interpreter.profile)
        self.interpreter = Interpreter(self, memory, self._speaker.write_text, build.is_rockwell)
        self._their_form: Format | None = None
        self._ringing = Ringing(clock, lambda: self.interpreter.profile)
        self._reader = CommandReader(self._speaker.echo, self._register)
        self._escape = Escape()
        self._idle = IdleWatch(clock, lambda: self._register(30), lambda: self.call.fail(results.NO_CARRIER))
        self._escape_timer = Alarm(self._clock)
        self._dtr_timer = Alarm(self._clock)
        self._deaf_until_ns = 0
        self._held = bytearray()
        """Data of the other end that arrived in the online command state."""

    # ---- power

    def power_on(self) -> None:
        self.mode = Mode.COMMAND
        self.interpreter.reset(self.interpreter.memory.first)
        self._follow()

    def power_off(self) -> None:
        self.call.hang_up()
        self._stop_timers()
        self.mode, self._ringing.is_on = Mode.OFF, False
        self._reader.reset()
        self._held.clear()
        self.side.power_off()

    # ---- what comes from the terminal

    def on_serial(self, message: SerialMessage) -> None:
        match message:
            case ControlLines():
                had_dtr = self.side.terminal.dtr
                self.side.on_lines(message)
                if had_dtr is not message.dtr:
                    self._on_dtr(message.dtr)
            case Format():
                self._their_form = message
                self._follow()
            case bytes() if self.mode is not Mode.OFF:
                self._on_bytes(self.side.taken(message))

    def _follow(self) -> None:
        """Take the format of the terminal in the command state, as a modem does when it reads AT."""
        if self._their_form is not None and self.mode is Mode.COMMAND:
            self.side.follow(fixed_form(self._their_form, self.interpreter.profile))

    def _on_bytes(self, data: bytes) -> None:
        if self.mode is Mode.ONLINE:
            self._send_data(data)
        elif self.call.is_establishing:
            if data and self._clock.now_ns() >= self._deaf_until_ns:
                self.call.fail(results.NO_CARRIER)
        else:
            for event in self._reader.feed(data):
                self._run(event)
                if not self._is_listening_to_commands():
                    break

    def _is_listening_to_commands(self) -> bool:
        return self.mode in (Mode.COMMAND, Mode.ONLINE_COMMAND) and not self.call.is_establishing

    def _run(self, event: object) -> None:
        if isinstance(event, Line):
            result = results.ERROR if event.is_too_long else self.interpreter.run(event.body)
        else:
            result = self.interpreter.repeat()
        if result is not BUSY_WITH_IT:
            self._tell(result)

    def _send_data(self, data: bytes) -> None:
        now_ns, guard_ns = self._clock.now_ns(), self._register(12) * GUARD_UNIT_NS
        self._idle.last_ns = now_ns
        self._escape_timer.stop()
        if self._escape.hear(now_ns, data, self._register(2), guard_ns):
            self._escape_timer.at(now_ns + guard_ns, self._on_escape)
        self.call.pump.send(data)

    def _on_escape(self) -> None:
        if self.mode is Mode.ONLINE:
            self.mode = Mode.ONLINE_COMMAND
            self._say_ready(False)
            self._tell(results.OK)

    def _on_dtr(self, is_on: bool) -> None:
        self._dtr_timer.stop()
        if not is_on and self.mode is not Mode.OFF:
            self._dtr_timer.after(self._register(25) * 10 * MS, self._on_dtr_lost)

    def _on_dtr_lost(self) -> None:
        reaction = self._setting("&D")
        if reaction == 1 and self.mode is Mode.ONLINE:
            self._on_escape()
        elif reaction >= 2:
            if self.call.state is not CallState.IDLE:
                self.call.fail(results.NO_CARRIER)
            if reaction == 3:
                self.interpreter.reset(self.interpreter.memory.first)

    # ---- what comes from the line

    def on_network(self, message: TelephoneMessage) -> None:
        if self.mode is Mode.OFF:
            return
        match message:
            case bytes():
                self._on_line_data(message)
            case Ring(is_on=is_on):
                self._on_ring(is_on)
            case Heard() | Offer() | Carrier() | Ready():
                self.call.hear(message)

    def _on_line_data(self, data: bytes) -> None:
        self._idle.last_ns = self._clock.now_ns()
        if self.mode is Mode.ONLINE:
            self.side.send(data)
        elif self.mode is Mode.ONLINE_COMMAND and len(self._held) + len(data) <= MOST_WAITING:
            self._held += data

    def _on_ring(self, is_on: bool) -> None:
        self._ringing.is_on = is_on
        if is_on and self.call.state is CallState.IDLE:
            self._ringing.begin()
            self._speaker.is_answering = True
            self._tell(results.RING)
        self._show_lines()
        is_willing = self.side.terminal.dtr or self._setting("&D") < 2
        if not is_on and self.call.state is CallState.IDLE and is_willing and self._ringing.is_enough():
            self.answer()

    def _on_connected(self, agreed: Agreed) -> None:
        self._ringing.forget()
        self.mode = Mode.ONLINE
        self._escape.restart(self._clock.now_ns())
        self._speaker.tell_connected(agreed, self.side.end.form.baud)
        self._show_lines()
        self._idle.start()
        if not self.side.end.has_room:
            self._say_ready(False)

    def _on_over(self) -> None:
        self._escape_timer.stop()
        self._idle.stop()
        self._held.clear()
        if self.mode is not Mode.OFF:
            self.mode = Mode.COMMAND
            self._reader.reset()
            self._follow()
            self._show_lines()

    # ---- Actions

    def answer(self) -> Result:
        if self.call.state is CallState.CONNECTED:
            return results.ERROR
        self._speaker.is_answering = True
        self._deaf_until_ns = self._clock.now_ns() + DEAF_NS
        self.call.answer(self._rules(is_answering=True))
        self._show_lines()
        return BUSY_WITH_IT

    def dial(self, string: str, stays: bool) -> Result:
        if self.call.state is CallState.CONNECTED:
            return results.ERROR
        self._speaker.is_answering = False
        self._deaf_until_ns = self._clock.now_ns() + DEAF_NS
        self.call.dial(self._rules(is_answering=False), steps_of(string, self.interpreter.is_pulse), stays)
        self._show_lines()
        return BUSY_WITH_IT

    def hang_up(self) -> Result:
        self.call.hang_up()
        return results.OK

    def seize(self) -> Result:
        self.call.seize()
        return results.OK

    def go_online(self) -> Result:
        agreed = self.call.agreed
        if self.mode is not Mode.ONLINE_COMMAND or agreed is None:
            return results.NO_CARRIER
        self._speaker.tell_rate(agreed, self.side.end.form.baud)
        self.mode = Mode.ONLINE
        self._escape.restart(self._clock.now_ns())
        held = bytes(self._held)
        self._held.clear()
        self.side.send(held)
        self._say_ready(self.side.end.has_room)
        return BUSY_WITH_IT

    def on_setting(self) -> None:
        profile = self.interpreter.profile
        of_modem, of_terminal = (Flow(int(value)) for value in profile.parameters["+IFC"])
        if profile.settings["&R"]:  # RTS is ignored, and CTS is always on
            of_modem, of_terminal = (Flow.NONE if flow is Flow.HARDWARE else flow for flow in (of_modem, of_terminal))
        self.side.set_flow(of_modem, of_terminal)
        self._show_lines()

    def _rules(self, *, is_answering: bool) -> Rules:
        return rules_of(self.interpreter.profile, self._build, self._register, is_answering=is_answering)

    def _register(self, number: int) -> int:
        return self.interpreter.profile.registers[number]

    def _setting(self, name: str) -> int:
        return self.interpreter.profile.settings[name]

    def _show_lines(self) -> None:
        if self.mode is Mode.OFF:
            return
        has_carrier = self.call.state is CallState.CONNECTED
        is_in_call = has_carrier or self.call.state is CallState.WAITING
        self.side.show(
            is_ready=is_in_call or not self._setting("&S"),
            has_carrier=has_carrier or not self._setting("&C"),
            rings=self._ringing.is_on,
        )

    def _on_room_at_terminal(self, has_room: bool) -> None:
        if self.mode is Mode.ONLINE:
            self._say_ready(has_room)

    def _say_ready(self, is_ready: bool) -> None:
        """Tell a modem that corrects errors whether we can take data; any other goes on sending."""
        if self.call.agreed is not None and self.call.agreed.is_corrected:
            self._telephone.send(Ready(is_ready))

    def _tell(self, result: Result) -> None:
        if self.mode is not Mode.OFF:
            self._speaker.tell(result)

    def _stop_timers(self) -> None:
        self._idle.stop()
        self._escape_timer.stop()
        self._dtr_timer.stop()
