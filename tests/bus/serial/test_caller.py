"""The call of `fieldrig dial` in its event loop, at a port that a test plays."""

import asyncio
from collections.abc import Callable
from ipaddress import IPv4Address

import pytest
from in_loop import in_loop
from patience import PATIENCE_S

from fieldrig.errors import BusError
from fieldrig_bus.ip.stream import Opening
from fieldrig_bus.net import TcpServer
from fieldrig_bus.serial import caller


class FloodedPort:
    """A port at which 1000 pieces arrive before anything is read, and that is gone then."""

    def __init__(self, _url: str, _baud: int) -> None: ...

    def start(self, on_data: Callable[[bytes], None], on_gone: Callable[[str], None]) -> None:
        for _ in range(1000):
            on_data(b"ab")
        on_gone("unplugged")

    def send(self, data: bytes) -> None: ...

    def close(self) -> None: ...


class CountingSession:
    is_over = is_up = False
    peer_address = IPv4Address(0)

    def __init__(self) -> None:
        self.received: list[bytes] = []
        self.advances = 0

    def start(self, now_ns: int) -> None: ...

    def receive(self, now_ns: int, data: bytes) -> None:
        self.received.append(data)

    def next_ns(self) -> int | None:
        return None

    def advance(self, now_ns: int) -> None:
        self.advances += 1

    def open(self, port: int) -> Opening:
        raise ConnectionError

    def hang_up(self, now_ns: int) -> None: ...


def test_what_has_arrived_is_taken_at_once_also_when_the_port_is_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each piece by itself cost a look at the timers of all connections, and a busy call stood still."""
    monkeypatch.setattr(caller, "ThreadedPort", FloodedPort)
    session = CountingSession()
    with pytest.raises(BusError, match="unplugged"):
        caller.call("port", 9600, lambda transmit: session, [], lambda: None)
    assert (session.received, session.advances) == ([b"ab" * 1000], 1)


class OpenStream:
    """A stream that is open, and carries nothing."""

    room, is_complete, is_refused = 1_000, False, False

    def __getattr__(self, name: str) -> Callable[..., None]:
        return lambda *_: None


class OpenSession(CountingSession):
    peer_address = IPv4Address("10.0.0.1")

    def open(self, port: int) -> Opening:
        return OpenStream()


SOCKS_HELLO, SOCKS_CONNECT = bytes.fromhex("05 01 00"), bytes.fromhex("05 01 00 01 0a000001 0050")


@pytest.mark.system
@in_loop
async def test_a_connection_through_the_call_may_last_however_long_it_wants(monkeypatch: pytest.MonkeyPatch) -> None:
    """Once, each one was closed after 30 s, as no message of it was ever taken for complete."""
    monkeypatch.setattr(caller, "ThreadedPort", FloodedPort)
    forwards = [caller.Forward("127.0.0.1:0", 80), caller.Forward("127.0.0.1:0", None)]
    calling = caller._Call("port", 9600, lambda transmit: OpenSession(), forwards, lambda: None)
    forwarded, proxy = calling._servers
    assert not await _is_to_speak(forwarded)
    assert await _is_to_speak(proxy)
    assert await _is_to_speak(proxy, SOCKS_HELLO)
    assert not await _is_to_speak(proxy, SOCKS_HELLO, SOCKS_CONNECT)


async def _is_to_speak(server: TcpServer, *said: bytes) -> bool:
    """Return whether a client that has said this is closed unless it says more."""
    await server.open()
    reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
    try:
        for part in said:
            writer.write(part)
            if part == SOCKS_HELLO:
                await reader.readexactly(2)
        async with asyncio.timeout(PATIENCE_S):
            while not server.connections or (SOCKS_CONNECT in said and server.door.next_s() is not None):
                await asyncio.sleep(0.01)
        return server.door.next_s() is not None
    finally:
        writer.close()
        await server.close()
