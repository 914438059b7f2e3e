"""The Lawicel ASCII protocol: a CAN bus as a CAN232 adapter on a pty or over TCP.

Source: Lawicel CAN232 manual, version 3.0.  Each command ends with CR and is answered by CR, or by BELL where the
manual says so: if it is unknown, malformed, or not active in the present state of the channel.  `slcand` and the
`slcan` interface of python-can join in this way.

Deviations.  Auto Poll (X) is stored in the EEPROM; this adapter starts with it switched on, because neither slcand nor
python-can ever switches it on.  The bit rate is that of the bus: S and s accept any bit rate and change nothing, O, L,
W, M and m don't need one before them, and neither does U.  FD frames follow the CANable firmware: d and D, or b and B
with a switched bit rate; Y sets the data bit rate.
Left out: Q (opening the channel at power up).
"""

import asyncio
import logging
from binascii import unhexlify
from collections import deque
from collections.abc import Callable, Iterable
from enum import Flag, auto
from typing import Final, NamedTuple

from fieldrig.bus import Hub
from fieldrig.clock import MS, Clock
from fieldrig.link import Link
from fieldrig_bus.backlog import Backlog, backlog_of
from fieldrig_bus.can.acceptance import ERRORS, EVERYTHING, STATE
from fieldrig_bus.can.frame import FD_LENGTHS, CanFrame
from fieldrig_bus.can.notices import BusState, CanControl, CanError, CanState, ErrorKind, Notice
from fieldrig_bus.can.sja1000 import AcceptanceFilter
from fieldrig_bus.net import Connection, ServingPort, TcpServer, join_as_client
from fieldrig_bus.terminal import Terminal, terminal

log = logging.getLogger(__name__)

CR: Final = b"\r"
BELL: Final = b"\a"

VERSION: Final = b"V1325\r"  # hardware 1.3, software 2.5: the version that has X, W and Z
SERIAL_NUMBER: Final = b"NF001\r"
LONGEST_COMMAND: Final = 1 + 8 + 1 + 2 * 64
MOST_WAITING: Final = 32
"""Number of frames kept for P and A while Auto Poll is off."""
TIMESTAMPS_END_MS: Final = 60_000  # manual, Z: 0x0000 to 0xEA5F

RECEIVE_FIFO_FULL: Final = 0x01
ERROR_WARNING: Final = 0x04
DATA_OVERRUN: Final = 0x08
ERROR_PASSIVE: Final = 0x20
ARBITRATION_LOST: Final = 0x40
BUS_ERROR: Final = 0x80
STATES: Final = {CanState.WARNING: ERROR_WARNING, CanState.PASSIVE: ERROR_PASSIVE, CanState.BUS_OFF: BUS_ERROR}


class Form(NamedTuple):
    is_extended: bool = False
    is_remote: bool = False
    is_fd: bool = False
    is_bit_rate_switched: bool = False


FORMS: Final = {
    "t": Form(),
    "T": Form(is_extended=True),
    "r": Form(is_remote=True),
    "R": Form(is_extended=True, is_remote=True),
    "d": Form(is_fd=True),
    "D": Form(is_extended=True, is_fd=True),
    "b": Form(is_fd=True, is_bit_rate_switched=True),
    "B": Form(is_extended=True, is_fd=True, is_bit_rate_switched=True),
}
LETTERS: Final = {form: letter for letter, form in FORMS.items()}


def encode(frame: CanFrame) -> bytes:
    """A frame as a command without its CR: `tiiildd..`, `Tiiiiiiiildd..`, `riiil`, `Riiiiiiiil`."""
    identifier = f"{frame.identifier:08X}" if frame.is_extended else f"{frame.identifier:03X}"
    length = frame.remote_length if frame.is_remote else FD_LENGTHS.index(len(frame.data))
    letter = LETTERS[Form(frame.is_extended, frame.is_remote, frame.is_fd, frame.is_bit_rate_switched)]
    return f"{letter}{identifier}{length:X}{frame.data.hex().upper()}".encode()


def decode(command: bytes) -> CanFrame:
    """The inverse of `encode`.  ValueError for anything else."""
    form = FORMS.get(command[:1].decode("latin-1"))
    if form is None:
        raise ValueError("not a command with a frame")
    digits = 8 if form.is_extended else 3
    identifier = int.from_bytes(unhexlify(command[1 : 1 + digits].rjust(8, b"0")), "big")
    length, data = command[1 + digits : 2 + digits], unhexlify(command[2 + digits :])
    size = FD_LENGTHS[unhexlify(b"0" + length)[0]]
    if len(data) != (0 if form.is_remote else size):
        raise ValueError("the length is not the length of the data")
    return CanFrame(identifier, data, form.is_extended, form.is_remote, size * form.is_remote, *form[2:])


class When(Flag):
    """States of the channel, and the sets of states in which a command is active."""

    CLOSED = auto()
    OPEN = auto()
    LISTENING = auto()
    OPENED = OPEN | LISTENING
    ALWAYS = CLOSED | OPENED


class Adapter:
    """One adapter: it executes the commands of one client with an end of the bus."""

    def __init__(
        self, clock: Clock, link: Link[CanFrame | Notice], write: Callable[[bytes], None], bus_name: str = ""
    ) -> None:
        self._clock, self._link, self._write, self._bus_name = clock, link, write, bus_name
        self._state = When.CLOSED
        self._rest = b""
        self._filter = AcceptanceFilter()
        self._is_auto_polling = True
        self._has_timestamps = False
        self._waiting: deque[bytes] = deque()
        self._flags = 0
        self._is_listen_only = False
        self.is_used = False
        """True when the client has sent a command that the adapter knows."""

    def receive(self, data: bytes) -> None:
        *lines, rest = (self._rest + data).split(CR)
        self._rest = rest[: LONGEST_COMMAND + 1]  # a command that is too long remains so until its CR
        for line in lines:
            self._write(self._answer(line))

    def _answer(self, line: bytes) -> bytes:
        if not line:
            return CR  # a session begins with two or three CR that flush earlier input
        command = COMMANDS.get(line[:1])
        if command is None or self._state not in command.when or len(line) > LONGEST_COMMAND:
            return BELL
        if command.parameters is not None and len(line) != 1 + command.parameters:
            return BELL
        self.is_used = True
        try:
            return command.handler(self, line)
        except (ValueError, IndexError) as fault:
            log.debug("%s: %r: %s", self._bus_name, line, fault)
            return BELL

    # the channel

    def _on_bit_rate(self, line: bytes) -> bytes:
        _choice(line, 9)
        return CR

    def _on_bit_timing(self, line: bytes) -> bytes:
        unhexlify(line[1:])
        return CR

    def _on_open(self, line: bytes) -> bytes:
        self._listen(False)
        return self._become(When.OPEN)

    def _on_listen(self, line: bytes) -> bytes:
        self._listen(True)
        return self._become(When.LISTENING)

    def _listen(self, is_listen_only: bool) -> None:
        self._link.on_receive(self._on_message, [EVERYTHING, ERRORS, STATE])
        if is_listen_only is not self._is_listen_only:
            self._is_listen_only = is_listen_only
            self._link.send(CanControl(is_listen_only=is_listen_only))

    def _on_close(self, line: bytes) -> bytes:
        self._link.on_receive(self._on_message, [])
        self._waiting.clear()
        self._flags = 0
        return self._become(When.CLOSED)

    def _become(self, state: When) -> bytes:
        self._state = state
        return CR

    # frames

    def _on_transmit(self, line: bytes) -> bytes:
        self._link.send(decode(line))
        if not self._is_auto_polling:
            return CR
        return b"z\r" if line[:1].islower() else b"Z\r"

    def _on_message(self, message: CanFrame | Notice) -> None:
        if isinstance(message, CanFrame):
            self._on_frame(message)
        elif isinstance(message, CanError):
            self._flags |= ARBITRATION_LOST if message.kind is ErrorKind.ARBITRATION_LOST else BUS_ERROR
        elif isinstance(message, BusState):
            self._flags |= STATES.get(message.state, 0)

    def _on_frame(self, frame: CanFrame) -> None:
        if not self._filter.passes(frame):
            return
        text = encode(frame)
        if self._has_timestamps:
            text += b"%04X" % (self._clock.now_ns() // MS % TIMESTAMPS_END_MS)
        if self._is_auto_polling:
            self._write(text + CR)
        elif len(self._waiting) < MOST_WAITING:
            self._waiting.append(text + CR)
        else:
            self._flags |= RECEIVE_FIFO_FULL | DATA_OVERRUN

    def _on_poll(self, line: bytes) -> bytes:
        if self._is_auto_polling:
            return BELL
        return self._waiting.popleft() if self._waiting else CR

    def _on_poll_all(self, line: bytes) -> bytes:
        if self._is_auto_polling:
            return BELL
        frames = b"".join(self._waiting)
        self._waiting.clear()
        return frames + b"A\r"

    # settings

    def _on_auto_poll(self, line: bytes) -> bytes:
        self._is_auto_polling = _choice(line, 2) == 1
        return CR

    def _on_timestamps(self, line: bytes) -> bytes:
        self._has_timestamps = _choice(line, 2) == 1
        return CR

    def _on_filter_mode(self, line: bytes) -> bytes:
        self._filter.is_single = _choice(line, 2) == 1
        return CR

    def _on_acceptance_code(self, line: bytes) -> bytes:
        self._filter.code = int.from_bytes(unhexlify(line[1:]), "big")
        return CR

    def _on_acceptance_mask(self, line: bytes) -> bytes:
        self._filter.mask = int.from_bytes(unhexlify(line[1:]), "big")
        return CR

    def _on_uart_rate(self, line: bytes) -> bytes:
        _choice(line, 7)
        return CR

    # reports

    def _on_flags(self, line: bytes) -> bytes:
        flags, self._flags = self._flags, 0
        return b"F%02X\r" % flags

    def _on_version(self, line: bytes) -> bytes:
        return VERSION

    def _on_serial_number(self, line: bytes) -> bytes:
        return SERIAL_NUMBER


class Command(NamedTuple):
    when: When
    parameters: int | None  # number of characters, or None if the handler checks it
    handler: Callable[[Adapter, bytes], bytes]


# Manual, chapter "Available CAN232 ASCII commands", in its order.
COMMANDS: Final = {
    b"S": Command(When.CLOSED, 1, Adapter._on_bit_rate),
    b"s": Command(When.CLOSED, 4, Adapter._on_bit_timing),
    b"O": Command(When.CLOSED, 0, Adapter._on_open),
    b"L": Command(When.CLOSED, 0, Adapter._on_listen),
    b"C": Command(When.OPENED, 0, Adapter._on_close),
    **{letter.encode(): Command(When.OPEN, None, Adapter._on_transmit) for letter in FORMS},
    b"P": Command(When.OPENED, 0, Adapter._on_poll),
    b"A": Command(When.OPENED, 0, Adapter._on_poll_all),
    b"F": Command(When.OPENED, 0, Adapter._on_flags),
    b"X": Command(When.CLOSED, 1, Adapter._on_auto_poll),
    b"W": Command(When.CLOSED, 1, Adapter._on_filter_mode),
    b"M": Command(When.CLOSED, 8, Adapter._on_acceptance_code),
    b"m": Command(When.CLOSED, 8, Adapter._on_acceptance_mask),
    b"U": Command(When.CLOSED, 1, Adapter._on_uart_rate),
    b"V": Command(When.ALWAYS, 0, Adapter._on_version),
    b"N": Command(When.ALWAYS, 0, Adapter._on_serial_number),
    b"Z": Command(When.CLOSED, 1, Adapter._on_timestamps),
    b"Y": Command(When.CLOSED, 1, Adapter._on_bit_rate),
}


def _choice(line: bytes, count: int) -> int:
    """The digit after the command's letter, 0 to `count - 1`."""
    choice = line[1] - ord("0")
    if not 0 <= choice < count:
        raise ValueError(f"expected 0 to {count - 1}")
    return choice


class _Client(Connection):
    def __init__(self, server: TcpServer, hub: Hub, bus_name: str) -> None:
        super().__init__(server)
        self._hub, self._bus_name = hub, bus_name

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self._member, link = join_as_client(self._hub, "lawicel")
        self._adapter = Adapter(self._hub.clock, link, self.write, self._bus_name)
        self._backlog = backlog_of(self, self._hub, self._member)

    def end_of_first(self, data: bytes) -> int:
        return data.find(CR) + 1 or len(data)

    def data_received(self, data: bytes) -> None:
        self._adapter.receive(data)
        if self._adapter.is_used:
            self.heard()
        self._backlog.look()

    def connection_lost(self, exc: Exception | None) -> None:
        self._backlog.close()
        self._hub.leave(self._member)
        super().connection_lost(exc)


class LawicelPort(ServingPort):
    """One adapter on a pty at `path` in the run folder, and one for each TCP client at `listen`."""

    def __init__(self, bus_name: str, path: str | None = None, listen: str | None = None) -> None:
        self._bus_name, self._path, self._listen = bus_name, path, listen
        self._server: TcpServer | None = None
        self._pty: Terminal | None = None
        self._leave: Callable[[], None] | None = None

    @property
    def port(self) -> int:
        """The TCP port on which it listens, once it is open."""
        assert self._server is not None
        return self._server.port

    async def open(self, hub: Hub) -> None:
        if self._path is not None:
            self._open_pty(hub, terminal(hub, self._path))
        if self._listen is not None:
            self._server = TcpServer(
                self._listen, lambda server: _Client(server, hub, self._bus_name), service="Lawicel"
            )
            await self._server.open(hub.pace)

    def servers(self) -> Iterable[TcpServer]:
        return () if self._server is None else (self._server,)

    def _open_pty(self, hub: Hub, pty: Terminal) -> None:
        member, link = join_as_client(hub, "lawicel")
        adapter = Adapter(hub.clock, link, pty.write, self._bus_name)
        backlog = Backlog(hub, member, pty.read_on, lambda: log.debug("%s: the pty's client waits", self._bus_name))

        def receive(data: bytes) -> None:
            adapter.receive(data)
            backlog.look()

        def leave() -> None:
            backlog.close()
            hub.leave(member)

        self._pty, self._leave = pty, leave
        pty.open(receive)

    async def close(self) -> None:
        if self._server is not None:
            await self._server.close()
        if self._leave is not None:
            self._leave()
        if self._pty is not None:
            self._pty.close()
