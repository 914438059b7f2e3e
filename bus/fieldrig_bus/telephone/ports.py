"""Calls between the telephone network and programs outside the rig, over TCP: raw bytes, or Telnet in binary.

This is the form that other emulators of modems use: a connection is a call, and closing it hangs up.  A program that
connects to an incoming port calls its number.  A call to an outgoing number makes a connection, and is answered when
that is there; while nothing listens at the address, it rings.
"""

import asyncio
import logging
from collections.abc import Callable, Iterable

from fieldrig.bus import Hub, Port
from fieldrig.outside.addresses import split_address
from fieldrig.outside.limits import Limits
from fieldrig_bus.net import Connection, ServingPort, TcpServer, cancel, join_as_client
from fieldrig_bus.serial.telnet import BINARY, DO, ECHO, SUPPRESS_GO_AHEAD, WILL, Negotiation, Options, TelnetReader
from fieldrig_bus.serial.telnet import escape as escaped
from fieldrig_bus.telephone.message import Ring, TelephoneMessage
from fieldrig_bus.telephone.outside import OutsideModem

log = logging.getLogger(__name__)

LIMITS = Limits(connections=16, first_message_s=None)
"""Calls at a time; a line that is busy says so itself.  A caller may only listen, and every byte is valid.  How long a
call may take to connect is limited by the modem (`outside.PATIENCE_NS`)."""


class IncomingPort(ServingPort):
    """Listens at `address`; each connection calls `number`."""

    def __init__(self, address: str, number: str, is_telnet: bool) -> None:
        self.number, self.is_telnet = number, is_telnet
        self.server = TcpServer(address, self._connection, LIMITS, f"calls to {number}")
        self._hub: Hub | None = None

    async def open(self, hub: Hub) -> None:
        self._hub = hub
        await self.server.open(hub.pace)

    def servers(self) -> Iterable[TcpServer]:
        return (self.server,)

    async def close(self) -> None:
        await self.server.close()

    def _connection(self, server: TcpServer) -> Connection:
        assert self._hub is not None
        hub = self._hub
        member, link = join_as_client(hub, "outside")
        talk = Talk(server, self.is_telnet, is_server=True)
        modem = OutsideModem(link, hub.clock, talk.send, talk.end)
        link.on_receive(modem.from_network)

        def leave() -> None:
            modem.hang_up()
            hub.leave(member)

        talk.begin_with(modem, lambda: modem.call(self.number), leave)
        return talk


class OutgoingPort(Port):
    """Has a line of the exchange; a call to it makes a connection to `address`."""

    def __init__(self, member: str, address: str, is_telnet: bool) -> None:
        self._member, self._address, self._is_telnet = member, address, is_telnet
        self._place = TcpServer(address, lambda server: Talk(server, is_telnet, is_server=False))  # never opened
        self._connecting: asyncio.Task[None] | None = None
        self._talk: Talk | None = None
        self._modem: OutsideModem | None = None

    async def open(self, hub: Hub) -> None:
        link = hub.join(self._member)
        self._modem = OutsideModem(link, hub.clock, self._on_data, self._on_over)
        link.on_receive(self._on_message)

    async def close(self) -> None:
        if self._connecting is not None:
            await cancel(self._connecting)
            self._connecting = None
        if self._talk is not None:
            self._talk.transport.abort()
            await self._talk.lost

    def _on_message(self, message: TelephoneMessage) -> None:
        assert self._modem is not None
        if not isinstance(message, Ring):
            self._modem.from_network(message)
        elif not message.is_on:
            return
        elif self._connecting is None and self._talk is None:
            self._connecting = asyncio.get_running_loop().create_task(self._connect())

    async def _connect(self) -> None:
        host, port = split_address(self._address)
        loop = asyncio.get_running_loop()
        try:
            _, talk = await loop.create_connection(
                lambda: Talk(self._place, self._is_telnet, is_server=False), host, port
            )
        except OSError as fault:
            log.info("%s does not answer: %s", self._address, fault)
        else:
            self._answer(talk)
        finally:
            self._connecting = None

    def _answer(self, talk: "Talk") -> None:
        modem = self._modem
        assert modem is not None
        self._talk = talk
        talk.begin_with(modem, modem.answer, self._on_closed)

    def _on_closed(self) -> None:
        self._talk = None
        if self._modem is not None:
            self._modem.hang_up()

    def _on_data(self, data: bytes) -> None:
        if self._talk is not None:
            self._talk.send(data)

    def _on_over(self) -> None:
        if self._talk is not None:
            self._talk.end()


class Talk(Connection):
    """One connection, which is one call."""

    def __init__(self, server: TcpServer, is_telnet: bool, is_server: bool) -> None:
        super().__init__(server)
        self._is_server = is_server
        self._reader = TelnetReader() if is_telnet else None
        self._options = Options(_OURS, _THEIRS, self.write)
        self._modem: OutsideModem | None = None
        self._on_made: Callable[[], None] = lambda: None
        self._on_lost: Callable[[], None] = lambda: None
        self._is_made = False

    def begin_with(self, modem: OutsideModem, on_made: Callable[[], None], on_lost: Callable[[], None]) -> None:
        """Connect the modem: `on_made` begins the call when the connection is there, `on_lost` is called at its end."""
        self._modem, self._on_made, self._on_lost = modem, on_made, on_lost
        modem.pump.on_room = self.read_on
        if self._is_made:
            on_made()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self._is_made = True
        if self._reader is not None and self._is_server:
            for agreement, option in _ASKED:
                self._options.ask(agreement, option)
        self._on_made()

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        self._on_lost()

    def eof_received(self) -> bool:
        """Let what the program has sent reach the other end before the call ends; the transport stays open for that."""
        if self._modem is None:
            return False
        self._modem.finish()
        return True

    def data_received(self, data: bytes) -> None:
        if self._modem is None:
            return
        if self._reader is None:
            self._modem.pump.send(data)
            return
        for event in self._reader.feed(data):
            if isinstance(event, bytes):
                self._modem.pump.send(event)
            elif isinstance(event, Negotiation):
                self._options.negotiate(*event)

    def pause_writing(self) -> None:
        super().pause_writing()
        if self._modem is not None:
            self._modem.set_ready(False)

    def resume_writing(self) -> None:
        super().resume_writing()
        if self._modem is not None:
            self._modem.set_ready(True)

    def send(self, data: bytes) -> None:
        self.write(data if self._reader is None else escaped(data))

    def end(self) -> None:
        """Close the connection when the call is over."""
        if self._is_made:
            self.transport.close()


_OURS = frozenset({BINARY, ECHO, SUPPRESS_GO_AHEAD})
_THEIRS = frozenset({BINARY, ECHO, SUPPRESS_GO_AHEAD})
_ASKED = ((DO, ECHO), (DO, SUPPRESS_GO_AHEAD), (DO, BINARY), (WILL, SUPPRESS_GO_AHEAD), (WILL, BINARY))
