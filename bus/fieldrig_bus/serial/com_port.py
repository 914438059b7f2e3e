"""The server side of the Telnet COM-PORT-OPTION (RFC 2217) as a function of bytes, between one client and one end of a
serial line.

A request that cannot be granted is answered with the value that stays in force (chapter 2).  This applies to 1.5 stop
bits, mark and space parity, inbound hardware flow control, and flow control by DCD, DTR or DSR: this line has none of
them.  Hardware flow control holds the client's data while CTS is off.  XON/XOFF holds it between the device's XOFF and
XON; inbound, it stops the device while the data of a suspended client fill the buffer.  A setting "(outbound/both)"
applies to both directions until an inbound one follows it.  A break is the only line state that is reported.

pyserial has `rfc2217.PortManager` for this, but bytes from outside raise exceptions in it (SE without SB, a short
SET-BAUDRATE, an unknown parity), it leaves requests for DTR, RTS and break unanswered, and it polls.
"""

import contextlib
from collections.abc import Callable
from dataclasses import replace

from fieldrig.clock import MS, Clock
from fieldrig_bus.serial.codec import format_of
from fieldrig_bus.serial.end import LineEnd
from fieldrig_bus.serial.message import Break, ControlLines, Format, ModemInputs, SerialMessage, inputs_from
from fieldrig_bus.serial.telnet import (
    BINARY,
    DO,
    ECHO,
    SUPPRESS_GO_AHEAD,
    WILL,
    Options,
    Subnegotiation,
    TelnetReader,
    escape,
    subnegotiation,
)
from fieldrig_bus.serial.xon_xoff import Obedience, Request

COM_PORT_OPTION = 44
# chapter 1: the client's codes; the server answers with the same plus 100
SIGNATURE, SET_BAUDRATE, SET_DATASIZE, SET_PARITY, SET_STOPSIZE, SET_CONTROL = range(6)
NOTIFY_LINESTATE, NOTIFY_MODEMSTATE, SUSPEND, RESUME, LINESTATE_MASK, MODEMSTATE_MASK, PURGE = range(6, 13)
ANSWER = 100

PARITY = {1: "N", 2: "O", 3: "E"}  # chapter 2, SET-PARITY
PARITY_CODE = {letter: code for code, letter in PARITY.items()}
PURGE_RECEIVED, PURGE_SENT, PURGE_BOTH = 1, 2, 3  # chapter 3, PURGE-DATA

# chapter 3, SET-CONTROL
FLOW_ASKED, FLOW_NONE, FLOW_XON_XOFF, FLOW_HARDWARE = range(4)
BREAK_ASKED, BREAK_ON, BREAK_OFF, DTR_ASKED, DTR_ON, DTR_OFF, RTS_ASKED, RTS_ON, RTS_OFF = range(4, 13)
INBOUND_FLOW_ASKED, INBOUND_FLOW_NONE, INBOUND_XON_XOFF, INBOUND_HARDWARE = range(13, 17)
FLOW_DCD, INBOUND_DTR, FLOW_DSR = 17, 18, 19

BREAK_DETECTED = 16  # chapter 4, NOTIFY-LINESTATE
DCD, RI, DSR, CTS, DELTA_DCD, RI_ENDED, DELTA_DSR, DELTA_CTS = (128 >> place for place in range(8))  # -MODEMSTATE

MOST_HELD = 64 * 1024
"""Bytes kept for a client that has suspended the server; the oldest stay, as in a receive buffer after an overrun."""
FASTEST_BAUD = 10_000_000

OUR_OPTIONS = frozenset({BINARY, ECHO, SUPPRESS_GO_AHEAD, COM_PORT_OPTION})
THEIR_OPTIONS = frozenset({BINARY, SUPPRESS_GO_AHEAD, COM_PORT_OPTION})


class ComPort:
    def __init__(self, end: LineEnd, clock: Clock, write: Callable[[bytes], None]) -> None:
        self._end, self._clock, self._write = end, clock, write
        self._reader = TelnetReader()
        self._options = Options(OUR_OPTIONS, THEIR_OPTIONS, write)
        self._other_end = ControlLines()
        self._modem_state = 0  # as reported last
        self._flow, self._inbound_flow = FLOW_NONE, INBOUND_FLOW_NONE
        self._obedience, self._request = Obedience(), Request(MOST_HELD)
        self._break_began_ns: int | None = None
        self._is_suspended = False
        self._held = bytearray()
        self._masks = {LINESTATE_MASK: 0, MODEMSTATE_MASK: 255}  # chapter 4: the value until a client sets it

    def start(self, other_end: ControlLines) -> None:
        """Begin with a client that has connected.  `other_end` is the present state of the lines of the other end."""
        self._other_end = other_end
        for agreement, option in (
            (DO, ECHO),
            (DO, SUPPRESS_GO_AHEAD),
            (DO, BINARY),
            (WILL, SUPPRESS_GO_AHEAD),
            (WILL, BINARY),
            (WILL, COM_PORT_OPTION),
        ):
            self._options.ask(agreement, option)

    def stop(self) -> None:
        """End with the client: a break that it left on ends, and a device that it stopped may continue."""
        if self._break_began_ns is not None:
            self._end_break()
        self._end.send_at_once(self._request.end())

    def from_client(self, data: bytes) -> None:
        for event in self._reader.feed(data):
            if type(event) is bytes:
                self._end.send(event)
            elif type(event) is Subnegotiation:
                self._on_subnegotiation(event)
            else:
                self._on_negotiation(*event)

    def from_line(self, message: SerialMessage) -> None:
        if type(message) is bytes:
            self._on_data(message)
        elif type(message) is ControlLines:
            self._other_end = message
            self._hold_or_send()
            self._notify_modem_state()
        elif type(message) is Break and self._masks[LINESTATE_MASK] & BREAK_DETECTED:
            self._answer(NOTIFY_LINESTATE, bytes((BREAK_DETECTED,)))

    def _on_data(self, data: bytes) -> None:
        if self._flow == FLOW_XON_XOFF:
            data = self._obedience.filter(data)
            self._hold_or_send()
        if self._is_suspended:
            self._held += data[: MOST_HELD - len(self._held)]
            self._ask_device()
        elif data:
            self._write(escape(data))

    def _on_negotiation(self, command: int, option: int) -> None:
        if self._options.negotiate(command, option) and option == COM_PORT_OPTION:
            self._notify_modem_state(is_asked=True)  # so that a client that asks nothing knows the state immediately

    def _on_subnegotiation(self, message: Subnegotiation) -> None:
        if message.option != COM_PORT_OPTION or not message.body:
            return
        code, value = message.body[0], message.body[1:]
        if code in _SETTINGS:
            self._on_setting(code, value)
        elif code == SIGNATURE:
            if not value:  # any other is a notification of the client, which expects no answer
                self._answer(SIGNATURE, b"fieldrig")
        elif code == SET_CONTROL:
            self._answer(SET_CONTROL, bytes((self._control(value[0] if value else FLOW_ASKED),)))
        elif code in self._masks:
            self._masks[code] = value[0] if value else self._masks[code]
            self._answer(code, bytes((self._masks[code],)))
        elif code == NOTIFY_MODEMSTATE:  # a poll, as pyserial's clients do
            self._notify_modem_state(is_asked=True)
        elif code == PURGE and value:
            self._purge(value[0])
        elif code in (SUSPEND, RESUME):
            self._suspend(code == SUSPEND)

    def _on_setting(self, code: int, value: bytes) -> None:
        width, changed, present = _SETTINGS[code]
        number = int.from_bytes(value[:width], "big")
        if number and len(value) >= width:  # 0 asks for the present value
            with contextlib.suppress(KeyError):  # no such format: the present one stays, and the answer says so
                self._end.set_format(changed(self._end.form, number))
        self._answer(code, present(self._end.form).to_bytes(width, "big"))

    def _control(self, value: int) -> int:
        """Execute SET-CONTROL (chapter 3).  Returns the value that is in force after it."""
        end = self._end
        if value in (FLOW_ASKED, FLOW_NONE, FLOW_XON_XOFF, FLOW_HARDWARE, FLOW_DCD, FLOW_DSR):
            if value in (FLOW_NONE, FLOW_XON_XOFF, FLOW_HARDWARE):
                self._set_flow(value)
            return self._flow
        if value in (BREAK_ON, BREAK_OFF, BREAK_ASKED):
            self._set_break(value)
            return BREAK_OFF if self._break_began_ns is None else BREAK_ON
        if value in (DTR_ON, DTR_OFF, DTR_ASKED):
            end.set_dtr(end.lines.dtr if value == DTR_ASKED else value == DTR_ON)
            return DTR_ON if end.lines.dtr else DTR_OFF
        if value in (RTS_ON, RTS_OFF, RTS_ASKED):
            end.set_rts(end.lines.rts if value == RTS_ASKED else value == RTS_ON)
            return RTS_ON if end.lines.rts else RTS_OFF
        if INBOUND_FLOW_ASKED <= value <= INBOUND_HARDWARE or value == INBOUND_DTR:
            if value in (INBOUND_FLOW_NONE, INBOUND_XON_XOFF):
                self._set_inbound_flow(value)
            return self._inbound_flow
        return self._flow  # a code that is not in chapter 3

    def _set_break(self, value: int) -> None:
        if value == BREAK_ON and self._break_began_ns is None:
            self._break_began_ns = self._clock.now_ns()
        elif value == BREAK_OFF and self._break_began_ns is not None:
            self._end_break()

    def _end_break(self) -> None:
        began_ns, self._break_began_ns = self._break_began_ns, None
        if began_ns is not None:
            self._end.send_break(max(1, round((self._clock.now_ns() - began_ns) / MS)))

    def _set_flow(self, value: int) -> None:
        self._flow, self._obedience = value, Obedience()
        self._hold_or_send()
        self._set_inbound_flow(INBOUND_XON_XOFF if value == FLOW_XON_XOFF else INBOUND_FLOW_NONE)

    def _set_inbound_flow(self, value: int) -> None:
        self._inbound_flow = value
        self._ask_device()

    def _hold_or_send(self) -> None:
        """Hold the client's data while the other end is not ready for it."""
        is_held = self._obedience.is_stopped
        if self._flow == FLOW_HARDWARE:
            is_held = not inputs_from(self._other_end).cts
        self._end.hold(is_held)

    def _ask_device(self) -> None:
        """Stop the other end while data held for a suspended client fill the buffer."""
        is_asking = self._inbound_flow == INBOUND_XON_XOFF
        self._end.send_at_once(self._request.at(len(self._held)) if is_asking else self._request.end())

    def _purge(self, value: int) -> None:
        if value in (PURGE_RECEIVED, PURGE_BOTH):
            self._held.clear()
            self._ask_device()
        if value in (PURGE_SENT, PURGE_BOTH):
            self._end.purge()
        self._answer(PURGE, bytes((value,)))

    def _suspend(self, is_suspended: bool) -> None:
        self._is_suspended = is_suspended
        if not is_suspended and self._held:
            self._write(escape(bytes(self._held)))
            self._held.clear()
            self._ask_device()

    def _notify_modem_state(self, is_asked: bool = False) -> None:
        """Report the state and its changes (chapter 4), within the client's mask, once the option is in force."""
        if not is_asked and not any(COM_PORT_OPTION in options for options in self._options.in_force.values()):
            return
        mask, before = self._masks[MODEMSTATE_MASK], self._modem_state
        state = self._modem_state = _modem_state(inputs_from(self._other_end))
        deltas = _deltas(before, state)
        if is_asked or (before ^ state | deltas) & mask:
            self._answer(NOTIFY_MODEMSTATE, bytes(((state | deltas) & mask,)))

    def _answer(self, code: int, value: bytes) -> None:
        self._write(subnegotiation(COM_PORT_OPTION, bytes((code + ANSWER,)) + value))


def _modem_state(inputs: ModemInputs) -> int:
    return inputs.dcd * DCD | inputs.ri * RI | inputs.dsr * DSR | inputs.cts * CTS


def _deltas(before: int, now: int) -> int:
    """Bits 0 to 3 of NOTIFY-MODEMSTATE.  The bit for RI is set only at its end ("trailing edge")."""
    changed = (before ^ now) >> 4
    return changed & ~(RI_ENDED if now & RI else 0)


def _with_baud(form: Format, baud: int) -> Format:
    if baud > FASTEST_BAUD:
        raise KeyError(baud)
    return replace(form, baud=baud)


# Settings, row by row as in chapter 2: bytes of the value, the changed format, the present value.
_SETTINGS: dict[int, tuple[int, Callable[[Format, int], Format], Callable[[Format], int]]] = {
    SET_BAUDRATE: (4, _with_baud, lambda form: form.baud),
    SET_DATASIZE: (
        1,
        lambda form, bits: format_of(form.baud, bits, form.parity, form.stop_bits),
        lambda form: form.data_bits,
    ),
    SET_PARITY: (
        1,
        lambda form, code: format_of(form.baud, form.data_bits, PARITY[code], form.stop_bits),
        lambda form: PARITY_CODE[form.parity],
    ),
    SET_STOPSIZE: (
        1,
        lambda form, bits: format_of(form.baud, form.data_bits, form.parity, bits),
        lambda form: form.stop_bits,
    ),
}
