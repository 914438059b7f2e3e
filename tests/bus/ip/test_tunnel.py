"""A client of a local port that is gone when its stream ends."""

import asyncio
from typing import Any

from in_loop import in_loop
from patience import PATIENCE_S

from fieldrig_bus.ip.channel import Channel
from fieldrig_bus.ip.message import Portion
from fieldrig_bus.ip.tunnel import Tunnelled
from fieldrig_bus.net import TcpServer


class ResetTransport:
    """A transport whose client has reset the connection, which the loop has not noticed yet."""

    def __init__(self) -> None:
        self.written = b""

    def write(self, data: bytes) -> None:
        self.written += data

    def write_eof(self) -> None:
        raise OSError(107, "Transport endpoint is not connected")

    def is_closing(self) -> bool:
        return False

    def set_write_buffer_limits(self, high: int) -> None:
        """Take any limit."""


@in_loop
async def test_a_greeting_that_came_before_the_client_reaches_it() -> None:
    channel = Channel("plc", 1, False, lambda _: None)
    channel.pause()
    channel.take(Portion("plc", 1, True, b"220 Service ready."))
    tunnelled = Tunnelled(TcpServer("relay", lambda _: tunnelled), lambda: channel, lambda: None)
    transport: Any = ResetTransport()
    tunnelled.connection_made(transport)
    assert transport.written == b"220 Service ready."


@in_loop
async def test_the_end_of_a_stream_finds_no_client() -> None:
    channel = Channel("plc", 1, False, lambda _: None)
    tunnelled = Tunnelled(TcpServer("relay", lambda _: tunnelled), lambda: channel, lambda: None)
    transport: Any = ResetTransport()
    tunnelled.connection_made(transport)
    channel.on_end()
    tunnelled.connection_lost(ConnectionResetError())
    async with asyncio.timeout(PATIENCE_S):
        await tunnelled.lost
    assert channel.is_over
