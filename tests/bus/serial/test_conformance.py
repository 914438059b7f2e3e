"""Every kind of serial bus keeps the same promises, with a device at the near end and a device or a client at the far.

The far end of `serial.pty` is a program that opens a serial device, that of `serial.tcp` a plain socket, and that of
`serial.rfc2217` the client of pyserial.
"""

import asyncio
import os
import select
import socket
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any, ClassVar

import pytest
import serial
from patience import PATIENCE_S

from fieldrig.clock import MS, S
from fieldrig.hub.hub import LocalHub
from fieldrig.loop.real_clock import RealClock
from fieldrig_bus.serial.bus import SerialBus
from fieldrig_bus.serial.line import SerialLine, SerialLineSettings, SerialVirtual, SerialVirtualSettings
from fieldrig_bus.serial.message import Break, ControlLines, Format, SerialMessage, inputs_from
from fieldrig_bus.serial.pty import SerialPty, SerialPtySettings
from fieldrig_bus.serial.rfc2217 import Rfc2217Port, SerialRfc2217, SerialRfc2217Settings
from fieldrig_bus.serial.tcp import SerialTcp, SerialTcpSettings, TcpPort

EVERYTHING = ("data", "lines", "format", "break")
EVERY_BYTE = bytes(range(256))


class Bench(ABC):
    """A line with a device at its near end, `near`, and a far end that depends on the kind."""

    has_lines: ClassVar[bool] = True
    has_breaks: ClassVar[bool] = True

    def __init__(self, baud: int, run: Path) -> None:
        self.baud, self.run = baud, run
        self.near: list[SerialMessage] = []
        """Messages that the near end has received."""

    @abstractmethod
    async def open(self) -> None: ...
    @abstractmethod
    async def close(self) -> None: ...
    @abstractmethod
    def now_ns(self) -> int: ...
    @abstractmethod
    def near_send(self, message: SerialMessage) -> None: ...
    @abstractmethod
    async def far_send(self, data: bytes) -> None: ...
    @abstractmethod
    async def far_read(self, count: int) -> bytes: ...
    @abstractmethod
    async def until(self, is_so: Callable[[], bool]) -> None: ...

    async def far_set(self, lines: ControlLines) -> None:
        raise NotImplementedError

    async def far_sees(self, lines: ControlLines) -> None:
        """Return when the far end reads its inputs as `lines` of the near end make them."""
        raise NotImplementedError

    async def far_break(self) -> None:
        raise NotImplementedError

    def near_bytes(self) -> bytes:
        return b"".join(message for message in self.near if isinstance(message, bytes))


class FarDevice(Bench):
    """The far end is a device as well."""

    def __init__(self, baud: int, run: Path) -> None:
        super().__init__(baud, run)
        self.far: list[SerialMessage] = []

    @abstractmethod
    def far_submit(self, message: SerialMessage) -> None: ...

    async def far_send(self, data: bytes) -> None:
        self.far_submit(data)

    async def far_read(self, count: int) -> bytes:
        def heard() -> bytes:
            return b"".join(message for message in self.far if isinstance(message, bytes))

        await self.until(lambda: len(heard()) >= count)
        return heard()

    async def far_set(self, lines: ControlLines) -> None:
        self.far_submit(lines)

    async def far_sees(self, lines: ControlLines) -> None:
        await self.until(lambda: lines in self.far)

    async def far_break(self) -> None:
        self.far_submit(Break(30))


class Virtual(FarDevice):
    async def open(self) -> None:
        self._now_ns = 0
        self._model = SerialVirtual("com1", SerialVirtualSettings(baud=self.baud)).model()
        for member in ("near", "far"):
            self._model.join(member)
            self._model.listen(0, member, EVERYTHING)

    async def close(self) -> None:
        assert self._model.next_ns() is None

    def now_ns(self) -> int:
        return self._now_ns

    def near_send(self, message: SerialMessage) -> None:
        self._model.submit(self._now_ns, "near", message)

    def far_submit(self, message: SerialMessage) -> None:
        self._model.submit(self._now_ns, "far", message)

    async def until(self, is_so: Callable[[], bool]) -> None:
        heard = {"near": self.near, "far": self.far}
        while (next_ns := self._model.next_ns()) is not None:
            self._now_ns = next_ns
            for delivery in self._model.collect(next_ns):
                for receiver in delivery.receivers:
                    heard[receiver].append(delivery.message)
        assert is_so()


class Real(Bench):
    """A hub in this process runs the line, with the port of the kind."""

    @abstractmethod
    def bus(self) -> SerialBus: ...

    async def open(self) -> None:
        self.clock = RealClock(asyncio.get_running_loop())
        bus = self.bus()
        self.hub = LocalHub(bus, self.clock, self.run)
        self._near = self.hub.join("near")
        self._near.on_receive(self.near.append, EVERYTHING)
        await self.hub.open(serve=False)

    async def close(self) -> None:
        await self.hub.close()
        self.clock.close()

    def now_ns(self) -> int:
        return self.clock.now_ns()

    def near_send(self, message: SerialMessage) -> None:
        self._near.send(message)

    async def until(self, is_so: Callable[[], bool]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not is_so():
                await asyncio.sleep(0.001)


class Line(Real, FarDevice):
    def bus(self) -> SerialBus:
        return SerialLine("com1", SerialLineSettings(baud=self.baud))

    async def open(self) -> None:
        await super().open()
        self._far = self.hub.join("far")
        self._far.on_receive(self.far.append, EVERYTHING)

    def far_submit(self, message: SerialMessage) -> None:
        self._far.send(message)


class APty(Real):
    has_lines = has_breaks = False

    def bus(self) -> SerialBus:
        return SerialPty("com1", SerialPtySettings(baud=self.baud))

    async def open(self) -> None:
        await super().open()
        self._client = os.open(self.run / "serial/com1", os.O_RDWR | os.O_NOCTTY)

    async def close(self) -> None:
        os.close(self._client)
        await super().close()

    async def far_send(self, data: bytes) -> None:
        await asyncio.to_thread(os.write, self._client, data)

    async def far_read(self, count: int) -> bytes:
        return await asyncio.to_thread(self._read, count)

    def _read(self, count: int) -> bytes:
        data = b""
        while len(data) < count and select.select([self._client], [], [], PATIENCE_S)[0]:
            data += os.read(self._client, count)
        return data


class Tcp(Real):
    has_lines = has_breaks = False

    def bus(self) -> SerialBus:
        bus = SerialTcp("com1", SerialTcpSettings(baud=self.baud, listen="127.0.0.1:0"))
        self.port = port = TcpPort(bus.settings)
        bus.ports = lambda: (port,)  # type: ignore[method-assign]  # to learn which port was free
        return bus

    async def open(self) -> None:
        await super().open()
        self._client = socket.create_connection(("127.0.0.1", self.port.place.port), PATIENCE_S)
        await self.until(lambda: ControlLines() in self.near)

    async def close(self) -> None:
        self._client.close()
        await super().close()

    async def far_send(self, data: bytes) -> None:
        await asyncio.to_thread(self._client.sendall, data)

    async def far_read(self, count: int) -> bytes:
        return await asyncio.to_thread(self._read, count)

    def _read(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            data += self._client.recv(count)
        return data


class Rfc2217(Real):
    def bus(self) -> SerialBus:
        bus = SerialRfc2217("com1", SerialRfc2217Settings(baud=self.baud, listen="127.0.0.1:0"))
        self.port = port = Rfc2217Port(bus.settings)
        bus.ports = lambda: (port,)  # type: ignore[method-assign]  # to learn which port was free
        return bus

    async def open(self) -> None:
        await super().open()
        url = f"rfc2217://127.0.0.1:{self.port.place.port}"
        self._client: Any = await asyncio.to_thread(serial.serial_for_url, url, self.baud, timeout=PATIENCE_S)

    async def close(self) -> None:
        await asyncio.to_thread(self._client.close)
        await super().close()

    async def far_send(self, data: bytes) -> None:
        await asyncio.to_thread(self._client.write, data)

    async def far_read(self, count: int) -> bytes:
        data: bytes = await asyncio.to_thread(self._client.read, count)
        return data

    async def far_set(self, lines: ControlLines) -> None:
        await asyncio.to_thread(setattr, self._client, "dtr", lines.dtr)
        await asyncio.to_thread(setattr, self._client, "rts", lines.rts)

    async def far_sees(self, lines: ControlLines) -> None:
        client, inputs = self._client, inputs_from(lines)
        await self.until(lambda: (client.cts, client.dsr, client.cd, client.ri) == inputs)

    async def far_break(self) -> None:
        await asyncio.to_thread(self._client.send_break, 0.03)


KINDS = [
    Virtual,
    pytest.param(Line, marks=pytest.mark.system),
    pytest.param(
        APty, marks=[pytest.mark.system, pytest.mark.skipif(sys.platform == "win32", reason="no ptys on Windows")]
    ),
    pytest.param(Tcp, marks=pytest.mark.system),
    pytest.param(
        Rfc2217,
        marks=[
            pytest.mark.system,
            pytest.mark.filterwarnings("ignore:set(Daemon|Name):DeprecationWarning"),
        ],  # in pyserial
    ),
]


def on_every_kind(baud: int = 115200) -> Callable[[Callable[[Any], Coroutine[Any, Any, None]]], Any]:
    def decorate(test: Callable[[Any], Coroutine[Any, Any, None]]) -> Any:
        @pytest.mark.parametrize("kind", KINDS)
        def run(kind: Callable[[int, Path], Bench], tmp_path: Path) -> None:
            async def opened() -> None:
                bench = kind(baud, tmp_path)
                await bench.open()
                try:
                    await test(bench)
                finally:
                    await bench.close()

            asyncio.run(opened())

        run.__name__, run.__doc__ = test.__name__, test.__doc__
        return run

    return decorate


@on_every_kind()
async def test_near_end_is_heard_at_the_far_end_byte_by_byte(bench: Bench) -> None:
    bench.near_send(EVERY_BYTE)
    assert await bench.far_read(256) == EVERY_BYTE


@on_every_kind()
async def test_far_end_is_heard_at_the_near_end_byte_by_byte(bench: Bench) -> None:
    await bench.far_send(EVERY_BYTE)
    await bench.until(lambda: len(bench.near_bytes()) >= 256)
    assert bench.near_bytes() == EVERY_BYTE


@on_every_kind()
async def test_both_ends_talk_at_once(bench: Bench) -> None:
    there, back = EVERY_BYTE * 8, EVERY_BYTE[::-1] * 8
    bench.near_send(there)
    await bench.far_send(back)
    assert await bench.far_read(len(there)) == there
    await bench.until(lambda: len(bench.near_bytes()) >= len(back))
    assert bench.near_bytes() == back


@on_every_kind()
async def test_many_small_messages_keep_their_order(bench: Bench) -> None:
    for value in range(200):
        bench.near_send(bytes((value,)))
    assert await bench.far_read(200) == bytes(range(200))


@on_every_kind(baud=1_000_000)
async def test_nothing_is_lost_of_a_long_transfer(bench: Bench) -> None:
    long = os.urandom(20_000)
    await bench.far_send(long[:10_000])
    await bench.far_send(long[10_000:])
    await bench.until(lambda: len(bench.near_bytes()) >= len(long))
    assert bench.near_bytes() == long


@on_every_kind(baud=9600)
async def test_bytes_take_their_time(bench: Bench) -> None:
    start_ns = bench.now_ns()
    await bench.far_send(bytes(48))
    await bench.until(lambda: len(bench.near_bytes()) == 48)
    assert bench.now_ns() - start_ns >= 48 * 10 * S // 9600 - MS


@on_every_kind()
async def test_lines_of_the_far_end_are_heard(bench: Bench) -> None:
    if not bench.has_lines:
        return
    await bench.far_set(ControlLines(dtr=False, rts=True))
    await bench.until(lambda: ControlLines(dtr=False) in bench.near)
    await bench.far_set(ControlLines(dtr=False, rts=False))
    await bench.until(lambda: bench.near[-1] == ControlLines(dtr=False, rts=False))


@on_every_kind()
async def test_lines_of_the_near_end_are_seen(bench: Bench) -> None:
    if not bench.has_lines:
        return
    for lines in (
        ControlLines(dtr=False),
        ControlLines(rts=False),
        ControlLines(ri=True),
        ControlLines(dcd=False),
        ControlLines(),
    ):
        bench.near_send(lines)
        await bench.far_sees(lines)


@on_every_kind()
async def test_break_of_the_far_end_is_heard(bench: Bench) -> None:
    if not bench.has_breaks:
        return
    await bench.far_break()
    await bench.until(lambda: any(isinstance(message, Break) for message in bench.near))
    (duration_ms,) = [message.duration_ms for message in bench.near if isinstance(message, Break)]
    assert duration_ms >= 30


@on_every_kind()
async def test_format_of_the_near_end_paces_what_it_sends(bench: Bench) -> None:
    bench.near_send(Format(9600, 8, "E", 2))
    start_ns = bench.now_ns()
    bench.near_send(bytes(24))
    assert await bench.far_read(24) == bytes(24)
    assert bench.now_ns() - start_ns >= 24 * 12 * S // 9600 - MS
