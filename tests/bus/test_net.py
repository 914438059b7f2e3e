import asyncio
import socket
from itertools import pairwise
from typing import Any

import pytest
from in_loop import in_loop
from patience import PATIENCE_S
from pydantic import ValidationError

from fieldrig.clock import VirtualClock
from fieldrig.errors import BusError
from fieldrig.outside.portions import MOST_AT_ONCE
from fieldrig.settings import Address, Settings
from fieldrig.testing import RecordedLink
from fieldrig_bus.can.hub import CanHubSettings
from fieldrig_bus.modbus.tcp import ModbusTcpSettings
from fieldrig_bus.net import Connection, TcpServer, join_as_client
from fieldrig_bus.serial.bus import SerialHubSettings
from fieldrig_bus.wires import WiresHubSettings

pytestmark = pytest.mark.system


class Keys(Settings):
    listen: Address


class Echo(Connection):
    def data_received(self, data: bytes) -> None:
        self.write(data)


@pytest.mark.parametrize("address", ["127.0.0.1:5020", "localhost:0", "[::1]:29536", "tcp://127.0.0.1:1"])
def test_addresses_that_are_some(address: str) -> None:
    assert Keys(listen=address).listen == address


@pytest.mark.parametrize(
    "address", ["", "5020", "127.0.0.1", "127.0.0.1:", ":x", "host:70000", "host:1/path", "udp://a:1"]
)
def test_addresses_that_are_none_are_refused_with_what_is_right(address: str) -> None:
    with pytest.raises(ValidationError, match=r"expected host:port, such as 127\.0\.0\.1:5020"):
        Keys(listen=address)


@pytest.mark.parametrize("settings", [CanHubSettings, ModbusTcpSettings, SerialHubSettings, WiresHubSettings])
@pytest.mark.parametrize("key", ["attach", "connect"])
def test_every_hub_wants_an_address_for_other_machines(settings: type[Settings], key: str) -> None:
    with pytest.raises(ValidationError, match=r"expected host:port, such as 127\.0\.0\.1:5020"):
        settings.model_validate({key: "the other machine"})


@in_loop
async def test_server_takes_its_connections_with_it() -> None:
    server = TcpServer("127.0.0.1:0", Echo)
    await server.open()
    loop = asyncio.get_running_loop()
    with socket.socket() as client:
        client.setblocking(False)
        await loop.sock_connect(client, ("127.0.0.1", server.port))
        await loop.sock_sendall(client, b"hi")
        assert await loop.sock_recv(client, 2) == b"hi"
        await server.close()
        assert await loop.sock_recv(client, 2) == b""
    assert server.connections == set()
    await server.close()


@in_loop
async def test_address_that_is_taken_is_named_with_the_remedy() -> None:
    first = TcpServer("127.0.0.1:0", Echo)
    await first.open()
    second = TcpServer(f"127.0.0.1:{first.port}", Echo)
    with pytest.raises(BusError, match=rf"127\.0\.0\.1:{first.port}") as caught:
        await second.open()
    assert "stop it, or choose another port" in caught.value.remedy
    await second.close()
    await first.close()


@in_loop
async def test_client_that_does_not_read_loses_what_it_can_not_take() -> None:
    server = TcpServer("127.0.0.1:0", Echo)
    await server.open()
    client = socket.create_connection(("127.0.0.1", server.port))
    async with asyncio.timeout(PATIENCE_S):
        while not server.connections:
            await asyncio.sleep(0.001)
    (connection,) = server.connections
    for _ in range(1000):
        connection.write(bytes(65536))
    assert connection.is_full
    assert connection.transport.get_write_buffer_size() < 1_000_000
    client.close()
    await server.close()


@in_loop
async def test_client_that_floods_leaves_others_their_turn() -> None:
    taken: list[int] = []

    class Noting(Connection):
        def data_received(self, data: bytes) -> None:
            taken.append(len(data))
            asyncio.get_running_loop().call_soon(taken.append, 0)  # the turn of another connection

    server = TcpServer("127.0.0.1:0", Noting)
    await server.open()
    _, writer = await asyncio.open_connection("127.0.0.1", server.port)
    writer.write(bytes(1_000_000))
    async with asyncio.timeout(PATIENCE_S):
        while sum(taken) < 1_000_000:
            await asyncio.sleep(0)
    assert max(taken) <= MOST_AT_ONCE
    assert all(0 in pair for pair in pairwise(taken))
    writer.close()
    await writer.wait_closed()
    await server.close()


@in_loop
async def test_client_that_has_to_wait_waits_after_a_flood_too() -> None:
    taken: list[int] = []

    class Full(Connection):
        def data_received(self, data: bytes) -> None:
            taken.append(len(data))
            self.read_on(False)

    server = TcpServer("127.0.0.1:0", Full)
    await server.open()
    _, writer = await asyncio.open_connection("127.0.0.1", server.port)
    writer.write(bytes(3 * MOST_AT_ONCE))
    async with asyncio.timeout(PATIENCE_S):
        while not taken:
            await asyncio.sleep(0)
    for _ in range(20):
        await asyncio.sleep(0)
    assert taken == [MOST_AT_ONCE]
    writer.close()
    await server.close()


@in_loop
async def test_what_is_lost_because_a_client_does_not_read_is_counted() -> None:
    class Talking(Connection):
        def data_received(self, data: bytes) -> None:
            while not self.is_full:
                self.write(bytes(1 << 16))
            self.write(b"lost")

    server = TcpServer("127.0.0.1:0", Talking)
    await server.open()
    _, writer = await asyncio.open_connection("127.0.0.1", server.port, limit=1)
    writer.write(b"x")
    async with asyncio.timeout(PATIENCE_S):
        while not server.door.reached.figures():
            await asyncio.sleep(0)
    assert server.door.reached.figures() == {"messages lost": 1.0}
    writer.close()
    await server.close()


class Members:
    """A hub that only keeps the names of its members."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.names: set[str] = set()
        self.pace = None

    def join(self, member: str) -> RecordedLink[Any]:
        if member in self.names:
            raise ValueError(member)
        self.names.add(member)
        return RecordedLink()

    def leave(self, member: str) -> None:
        self.names.discard(member)

    def waiting(self, member: str) -> int:
        return 0

    def on_doors(self, call: Any) -> None:
        raise NotImplementedError

    def path(self, name: str) -> Any:
        raise NotImplementedError


def test_outside_clients_get_the_lowest_free_number() -> None:
    hub = Members()
    assert [join_as_client(hub, "socketcand")[0] for _ in range(2)] == ["socketcand:1", "socketcand:2"]
    hub.leave("socketcand:1")
    assert join_as_client(hub, "socketcand")[0] == "socketcand:1"
