"""Calls between the network and programs outside, over TCP and Telnet: the far end is a plain socket."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from patience import PATIENCE_S

from fieldrig.hub.hub import LocalHub
from fieldrig.loop.real_clock import RealClock
from fieldrig.testing import free_port
from fieldrig_bus.telephone.exchange import TelephoneExchange, TelephoneExchangeSettings
from fieldrig_bus.telephone.message import Ring
from fieldrig_bus.telephone.outside import OutsideModem
from fieldrig_bus.telephone.ports import IncomingPort

pytestmark = pytest.mark.system

EVERY_BYTE = bytes(range(256))
ESCAPED = EVERY_BYTE + b"\xff"  # RFC 854: IAC is sent twice


class Desk:
    """A network with a modem of number 100 that answers or calls, and the port of outside callers."""

    def __init__(self, hub: LocalHub, clock: RealClock) -> None:
        self.data, self.over, self.rings = bytearray(), 0, 0
        self.hub = hub
        link = hub.join("desk")
        self.modem = OutsideModem(link, clock, self.data.extend, self._on_over)
        self._is_answering = True
        link.on_receive(self._receive)

    @property
    def port(self) -> int:
        return next(port.server.port for port in self.hub._ports if isinstance(port, IncomingPort))

    def let_ring(self) -> None:
        self._is_answering = False

    def _on_over(self) -> None:
        self.over += 1

    def _receive(self, message: Any) -> None:
        if message == Ring(True):
            self.rings += 1
            if self._is_answering:
                self.modem.answer()
        self.modem.from_network(message)


@asynccontextmanager
async def desk(run: Path, **settings: Any) -> AsyncIterator[Desk]:
    clock = RealClock(asyncio.get_running_loop())
    given = {"numbers": {"desk": "100"}, "delay_ms": 1.0, "ring_off_ms": 100.0, "ring_on_ms": 100.0, **settings}
    hub = LocalHub(TelephoneExchange("net", TelephoneExchangeSettings.model_validate(given)), clock, run)
    try:
        at_work = Desk(hub, clock)
        await hub.open(serve=False)
        yield at_work
    finally:
        await hub.close()
        clock.close()


def incoming(telnet: bool = False) -> dict[str, Any]:
    return {"incoming": [{"listen": "127.0.0.1:0", "number": "100", "telnet": telnet}]}


async def until(is_so: Callable[[], bool]) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while not is_so():
            await asyncio.sleep(0.001)


def test_a_connection_is_a_call_with_data_both_ways(tmp_path: Path) -> None:
    async def scene() -> None:
        async with desk(tmp_path, **incoming()) as at:
            reader, writer = await asyncio.open_connection("127.0.0.1", at.port)
            writer.write(EVERY_BYTE)  # before the call is answered
            await until(lambda: at.data == EVERY_BYTE)
            at.modem.pump.send(EVERY_BYTE[::-1])
            assert await reader.readexactly(256) == EVERY_BYTE[::-1]
            writer.close()
            await until(lambda: at.over == 1)
            await until(lambda: list(at.hub._members) == ["desk"])

    asyncio.run(scene())


def test_what_a_program_sends_before_it_closes_arrives(tmp_path: Path) -> None:
    async def scene() -> None:
        async with desk(tmp_path, **incoming()) as at:
            _, writer = await asyncio.open_connection("127.0.0.1", at.port)
            await until(lambda: at.modem.pump.is_running)
            writer.write(EVERY_BYTE * 8)
            writer.close()
            await until(lambda: at.over == 1)
            assert at.data == EVERY_BYTE * 8

    asyncio.run(scene())


def test_hanging_up_closes_the_connection_after_the_data(tmp_path: Path) -> None:
    async def scene() -> None:
        async with desk(tmp_path, **incoming()) as at:
            reader, writer = await asyncio.open_connection("127.0.0.1", at.port)
            await until(lambda: at.modem.pump.is_running)
            at.modem.pump.send(EVERY_BYTE)
            at.modem.finish()
            assert await reader.read() == EVERY_BYTE
            writer.close()

    asyncio.run(scene())


def test_a_caller_that_gives_up_stops_the_ringing(tmp_path: Path) -> None:
    async def scene() -> None:
        async with desk(tmp_path, **incoming()) as at:
            at.let_ring()
            _, writer = await asyncio.open_connection("127.0.0.1", at.port)
            await until(lambda: at.rings == 2)
            writer.close()
            await until(lambda: list(at.hub._members) == ["desk"])

    asyncio.run(scene())


def test_a_second_caller_is_refused_while_the_line_is_in_use(tmp_path: Path) -> None:
    async def scene() -> None:
        async with desk(tmp_path, **incoming()) as at:
            _, first = await asyncio.open_connection("127.0.0.1", at.port)
            await until(lambda: at.modem.pump.is_running)
            reader, second = await asyncio.open_connection("127.0.0.1", at.port)
            assert await reader.read() == b""
            assert at.over == 0
            first.close()
            second.close()

    asyncio.run(scene())


def test_telnet_carries_every_byte_and_negotiates_binary(tmp_path: Path) -> None:
    async def scene() -> None:
        async with desk(tmp_path, **incoming(telnet=True)) as at:
            reader, writer = await asyncio.open_connection("127.0.0.1", at.port)
            greeting = await reader.readexactly(15)
            assert greeting == bytes.fromhex(
                "fffb01 fffb03 fffb00 fffd03 fffd00"
            )  # WILL ECHO, SGA, BINARY; DO SGA, BINARY
            writer.write(bytes.fromhex("fffd00") + ESCAPED)
            await until(lambda: at.data == EVERY_BYTE)
            at.modem.pump.send(EVERY_BYTE)
            assert await reader.readexactly(257) == ESCAPED
            writer.close()

    asyncio.run(scene())


@pytest.mark.parametrize("telnet", [False, True])
def test_a_number_of_the_phone_book_leads_to_a_program(tmp_path: Path, telnet: bool) -> None:
    async def scene() -> None:
        heard, closed = bytearray(), asyncio.Event()

        async def program(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            writer.write(ESCAPED if telnet else EVERY_BYTE)
            while data := await reader.read(1000):
                heard.extend(data)
            writer.close()
            closed.set()

        server = await asyncio.start_server(program, "127.0.0.1", 0)
        address = f"127.0.0.1:{server.sockets[0].getsockname()[1]}"
        async with desk(tmp_path, outgoing=[{"number": "300", "dial": address, "telnet": telnet}]) as at:
            at.modem.call("300")
            await until(lambda: at.data == EVERY_BYTE)
            at.modem.pump.send(EVERY_BYTE)
            await until(lambda: heard == (ESCAPED if telnet else EVERY_BYTE))
            at.modem.hang_up()
            await closed.wait()
            at.modem.call("300")  # the line is free again
            await until(lambda: at.data == EVERY_BYTE * 2)
        server.close()
        await server.wait_closed()

    asyncio.run(scene())


def test_a_number_whose_program_is_not_there_rings(tmp_path: Path) -> None:
    async def scene() -> None:
        address = f"127.0.0.1:{free_port()}"
        async with desk(tmp_path, outgoing=[{"number": "300", "dial": address}]) as at:
            rings: list[Any] = []
            at.hub.on_delivery(
                lambda delivery: rings.append(delivery) if delivery.message == Ring(True, "100") else None
            )
            at.modem.call("300")
            await until(lambda: len(rings) == 3)
            assert at.over == 0
            at.modem.hang_up()

    asyncio.run(scene())
