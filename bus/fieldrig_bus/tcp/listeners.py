"""The port of `tcp.server`: listeners, and the connections that they accept."""

import asyncio
import logging
import time
from collections.abc import Callable, Coroutine, Iterable, Mapping
from ipaddress import ip_address
from typing import Any, Final

from fieldrig.bus import Doors, Hub, Refusal
from fieldrig.errors import BusError
from fieldrig.link import Link
from fieldrig.outside.limits import Limits
from fieldrig.outside.portions import MOST_AT_ONCE
from fieldrig_bus.net import Connection, ServingPort, TcpServer
from fieldrig_bus.tcp.message import (
    MOST_DATA,
    WINDOW,
    Close,
    Connect,
    Connected,
    Data,
    Ended,
    Listen,
    Listening,
    Taken,
    TcpMessage,
    Unlisten,
    Unreached,
)
from fieldrig_bus.tcp.model import PORT

log = logging.getLogger(__name__)

MOST_OF_A_REQUEST: Final = 256
"""Bytes that are read from a client of a service at a time: a device may handle them later, and takes as long as it
takes."""
HTTP: Final = "http"
"""The service that browsers may reach."""
ENDS: Final[Mapping[str, bytes]] = {HTTP: b"\r\n\r\n", "ftp": b"\n"}
"""The end of a message of a client, where that is known: of the head of a request, or of a command."""
EXTRA_LIMITS: Final = Limits(connections=4, first_message_s=None)
"""An extra port is for one data connection of one client; it may only listen."""
CONNECT_S: Final = 30.0
"""Time for which a client may not answer when a device connects to it."""
LINGER_S: Final = 30.0
"""Time for which a closed connection waits for a client that does not read."""


class TcpPort(ServingPort):
    """Listens at the addresses of the services, and at the extra ports."""

    def __init__(self, listen: Mapping[str, str], most: int, extra_ports: tuple[int, int] | None) -> None:
        """`most` is the number of connections of each service."""
        self._extra_ports, self._limits = extra_ports, Limits(most)
        self._servers = {
            service: TcpServer(address, self._accepting(service), self._limits, service, service == HTTP)
            for service, address in listen.items()
        }
        self._extra: dict[int, TcpServer] = {}
        self._connections: dict[int, _Client] = {}
        self._numbers = 0
        self._hub: Hub | None = None
        self._link: Link[TcpMessage] | None = None
        self._tasks: set[asyncio.Task[None]] = set()
        self._extending: dict[int, asyncio.Task[None]] = {}
        """The latest task of each connection that opens its extra port, or a connection to its client."""
        self._attempts: dict[int, asyncio.Task[None]] = {}

    def number(self, service: str) -> int:
        """The TCP port at which the service listens."""
        return self._servers[service].port

    async def open(self, hub: Hub) -> None:
        self._hub = hub
        self._link = hub.join(PORT)
        self._link.on_receive(self._on_message)
        for server in self._servers.values():
            await server.open(hub.pace)
        hub.on_doors(self.meet)

    async def close(self) -> None:
        for task in self._tasks:
            task.cancel()
        clients = list(self._connections.values())
        for client in clients:
            client.transport.abort()
        await asyncio.gather(*(client.lost for client in clients))
        for server in self.servers():
            await server.close()
        if self._hub is not None:
            self._hub.leave(PORT)
            self._hub = self._link = None

    # ---- for the connections

    def arrived(self, client: "_Client", service: str, origin: int) -> None:
        """Take a connection and give it its number."""
        origin_client = self._connections.get(origin)
        if origin and (origin_client is None or origin_client.peer != client.peer):
            return  # an extra port is for its client only
        self._attempts.pop(origin, None)  # it has succeeded, and what the device asks for next must not give it up
        self._numbers += 1
        client.number = self._numbers  # before the message, to which the device may answer at once
        self._connections[client.number] = client
        self.send(Connected(client.number, service, client.peer, client.local, origin))

    def servers(self) -> Iterable[TcpServer]:
        return (*self._servers.values(), *self._extra.values())

    def meet(self, doors: Doors) -> None:
        if isinstance(doors, Refusal):
            for service, server in self._servers.items():
                if doors.service in (None, service):
                    server.refuse(doors.is_on)

    def left(self, number: int) -> None:
        if self._connections.pop(number, None) is not None:
            self._give_up(number)
            self._close_extra(number)

    def send(self, message: TcpMessage) -> None:
        if self._link is not None:
            self._link.send(message)

    # ---- from the devices

    def _on_message(self, message: TcpMessage) -> None:
        client = self._connections.get(message.connection)
        if client is None:
            return
        match message:
            case Data(data=data):
                client.put(data)
            case Taken(count=count):
                client.handled(count)
            case Close(limit=limit):
                if limit:
                    client.server.door.reached.note(limit, f"a connection of {client.peer} is closed")
                client.finish()
            case Listen():
                self._extend(message.connection, self._listen(message.connection, client))
            case Connect(port=port):
                self._extend(message.connection, self._connect(message.connection, client, port))
            case Unlisten():
                self._extend(message.connection, self._unlisten(message.connection))

    def _close_extra(self, connection: int) -> None:
        server = self._extra.pop(connection, None)
        if server is not None:
            server.stop_listening()

    def _extend(self, connection: int, work: Coroutine[Any, Any, None]) -> None:
        """Do one thing after the other for a connection, so that the last one counts."""
        self._give_up(connection)
        before = self._extending.get(connection)
        task = self._extending[connection] = self._start(_after(before, work))
        task.add_done_callback(lambda _: self._extended(connection, task))

    def _give_up(self, connection: int) -> None:
        attempt = self._attempts.pop(connection, None)
        if attempt is not None:
            attempt.cancel()

    def _extended(self, connection: int, task: asyncio.Task[None]) -> None:
        if self._extending.get(connection) is task:
            del self._extending[connection]

    async def _unlisten(self, connection: int) -> None:
        self._close_extra(connection)

    async def _connect(self, connection: int, client: "_Client", port: int) -> None:
        """Connect to the client, from the address that it uses itself, until something else is asked for."""
        self._close_extra(connection)
        opened = _Client(client.server, self, "", connection)
        self._attempts[connection] = self._start(_connected(opened, client, port))
        await asyncio.wait([self._attempts[connection]])
        self._attempts.pop(connection, None)
        if not opened.number:
            self.send(Unreached(connection))

    async def _listen(self, connection: int, client: "_Client") -> None:
        self._close_extra(connection)
        first, last = self._extra_ports or (0, 0)
        host = f"[{client.local}]" if ":" in client.local else client.local
        for port in range(first, last + 1):
            server = TcpServer(f"{host}:{port}", self._accepting("", connection), EXTRA_LIMITS, "extra port", True)
            try:
                await server.open(self._hub.pace if self._hub is not None else None)
            except BusError:
                continue
            if connection not in self._connections:
                await server.close()
                return
            self._extra[connection] = server
            self.send(Listening(connection, server.port))
            return
        self.send(Listening(connection, 0))

    def _accepting(self, service: str, origin: int = 0) -> Callable[[TcpServer], Connection]:
        return lambda server: _Client(server, self, service, origin)

    def _start(self, coroutine: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        task = asyncio.get_running_loop().create_task(coroutine)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task


class _Client(Connection):
    """One connection."""

    def __init__(self, server: TcpServer, port: TcpPort, service: str, origin: int) -> None:
        super().__init__(server, MOST_AT_ONCE if origin else MOST_OF_A_REQUEST)
        self._port, self._service, self._origin = port, service, origin
        self.number = 0
        """The number of the connection; 0 before it has one, and if it was refused."""
        self.peer = self.local = "0.0.0.0"
        self._unhandled = 0
        self._most_unhandled = WINDOW if origin else 1  # a service has one message of each client at a time
        self._asked_ns = 0
        """The time at which the device received something that it has not answered yet; 0 if there is nothing."""
        self._told_ns = 0
        """The time at which the device heard that its data are taken, if it has sent nothing since; else 0."""
        self._untold = 0  # bytes written whose `Taken` waits until the client reads
        self._has_ended = self._has_spoken = self._is_heard = False
        self._linger: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        peer, local = transport.get_extra_info("peername"), transport.get_extra_info("sockname")
        if peer is not None and local is not None:  # None: the connection is closed already
            self.peer, self.local = _plain(peer[0]), _plain(local[0])
            self._port.arrived(self, self._service, self._origin)
        if not self.number:
            self.transport.abort()

    @property
    def is_pending(self) -> bool:
        """True while bytes of the client wait for their turn, or for the device."""
        return super().is_pending or self._unhandled > 0

    def end_of_first(self, data: bytes) -> int:
        end = ENDS.get(self._service)
        end_at = -1 if end is None else data.find(end)
        return len(data) if end is None or end_at < 0 else end_at + len(end)

    def data_received(self, data: bytes) -> None:
        self._has_spoken = True
        self._unhandled += len(data)
        self._asked_ns, self._told_ns = self._asked_ns or time.monotonic_ns(), 0
        if self._unhandled >= self._most_unhandled:
            self.read_on(False)
        for part in _parts(data):
            self._port.send(Data(self.number, part))

    def handled(self, count: int) -> None:
        """Read on when the device has handled what was read."""
        self._note_answer()
        self._unhandled = max(0, self._unhandled - count)
        self.read_on(self._unhandled < self._most_unhandled)

    def eof_received(self) -> bool:
        """The client has finished sending, as `nc -N` does; the device may still answer."""
        self._has_ended = True
        self._port.send(Ended(self.number))
        return True

    def connection_lost(self, exc: Exception | None) -> None:
        if self._linger is not None:
            self._linger.cancel()
        if self.number:
            if not self._has_ended:
                self._port.send(Ended(self.number, is_lost=True))
            self._port.left(self.number)
        super().connection_lost(exc)

    def put(self, data: bytes) -> None:
        """Send data of the device; it sends no more than a window ahead, so nothing is dropped."""
        if self.transport.is_closing():
            return
        if self._has_spoken and not self._is_heard:  # the device has answered, so it has understood a message
            self._is_heard = True
            self.heard()
        self._note_answer()
        self.transport.write(data)
        self._untold += len(data)
        if not self.is_full:
            self._tell()

    def resume_writing(self) -> None:
        super().resume_writing()
        self._tell()

    def finish(self) -> None:
        """Close when the client has read everything, or does not read for a while."""
        if not self.transport.is_closing():
            self._linger = asyncio.get_running_loop().call_later(LINGER_S, self.transport.abort)
            self.transport.close()

    def take_turn(self) -> None:
        super().take_turn()
        self._tell_now()

    def _tell(self) -> None:
        """Tell the device that its data are taken, when it is time for that: the next page would be the answer."""
        if self.pace is not None:
            self.pace.look()
            if not self.pace.is_free(self):
                return
        self._tell_now()

    def _tell_now(self) -> None:
        if self._untold and self.number and not self.is_full:
            self._told_ns = time.monotonic_ns()
            count, self._untold = self._untold, 0  # before the message, to which the device may answer with more
            self._port.send(Taken(self.number, count))

    def _note_answer(self) -> None:
        """Count the time since the device received something: it may have worked later, when it was its turn.

        From the news that its data are taken, the time counts only until the client sends again.
        """
        since_ns = self._asked_ns or self._told_ns
        if self.pace is not None and since_ns:
            self.pace.answered(since_ns, has_turnaround=False)
        self._asked_ns = self._told_ns = 0


async def _after(before: asyncio.Task[None] | None, work: Coroutine[Any, Any, None]) -> None:
    try:
        if before is not None:
            await asyncio.wait([before])
        await work
    finally:
        work.close()


async def _connected(opened: _Client, client: _Client, port: int) -> None:
    """Connect to a client from the address that it uses itself; the number of `opened` tells whether it is."""
    connecting = asyncio.get_running_loop().create_connection(
        lambda: opened, client.peer, port, local_addr=(client.local, 0)
    )
    try:
        async with asyncio.timeout(CONNECT_S):
            await connecting
    except (OSError, TimeoutError) as cause:
        log.debug("%s does not accept a connection to port %d: %s", client.peer, port, cause)


def _parts(data: bytes) -> Iterable[bytes]:
    return (data[at : at + MOST_DATA] for at in range(0, len(data), MOST_DATA))


def _plain(address: str) -> str:
    """The address without a zone."""
    return str(ip_address(address.partition("%")[0]))
