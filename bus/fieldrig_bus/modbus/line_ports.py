"""Where the outside end of a serial line is: a pty, a real port, or a TCP port that carries its bytes."""

import asyncio
import logging
import os
from collections.abc import Callable
from typing import Any, Self, cast

from pydantic import Field, model_validator
from serial import serial_for_url
from serial.serialutil import SerialException

from fieldrig.bus import Hub, Port
from fieldrig.errors import BusError
from fieldrig.link import Link
from fieldrig.net import split_address
from fieldrig_bus.modbus.kind import CharacterSettings
from fieldrig_bus.modbus.line_session import LineSession
from fieldrig_bus.modbus.sockets import Master, Masters
from fieldrig_bus.net import Address, HubSettings
from fieldrig_bus.pty import Pty

log = logging.getLogger(__name__)

MakeSession = Callable[[Hub, Link[Any], Callable[[bytes], None]], LineSession]


class ModbusLineSettings(HubSettings, CharacterSettings):
    pty: str | None = Field(
        default=None, description="name of a pty in the run folder: what a master opens as its port"
    )
    port: str | None = Field(default=None, description="a real port, such as /dev/ttyUSB0")
    listen: Address | None = Field(default=None, description="host:port where the line's bytes go over TCP")
    baud: int = Field(default=19200, ge=300, le=10_000_000)
    max_connections: int = Field(default=8, ge=1, description="masters at `listen`")

    @model_validator(mode="after")
    def _check_one_way_in(self) -> Self:
        if sum(way is not None for way in (self.pty, self.port, self.listen)) != 1:
            raise ValueError("exactly one of pty, port and listen says where the line is")
        return self


class PtyPort(Port):
    def __init__(self, name: str, make_session: MakeSession) -> None:
        self._name, self._make_session = name, make_session
        self._hub: Hub | None = None
        self._pty: Pty | None = None
        self._session: LineSession | None = None

    async def open(self, hub: Hub) -> None:
        pty = Pty(hub.path(self._name))
        session = self._make_session(hub, hub.join("pty"), pty.write)
        self._hub, self._pty, self._session = hub, pty, session
        pty.open(session.on_bytes)

    async def close(self) -> None:
        if self._hub is None or self._pty is None or self._session is None:
            return
        self._pty.close()
        self._session.close()
        self._hub.leave("pty")
        self._hub = None


class UartPort(Port):
    def __init__(self, bus: str, settings: ModbusLineSettings, make_session: MakeSession) -> None:
        self._bus, self._settings, self._make_session = bus, settings, make_session
        self._device = settings.port or ""
        self._hub: Hub | None = None
        self._serial: Any = None
        self._session: LineSession | None = None

    async def open(self, hub: Hub) -> None:
        settings, open_uart = self._settings, cast(Callable[..., Any], serial_for_url)
        try:
            uart = open_uart(
                self._device,
                settings.baud,
                settings.data_bits,
                settings.parity,
                settings.stop_bits,
                timeout=0,
                exclusive=True,
            )
        except (SerialException, ValueError) as cause:
            remedy = "plug it in, name another port, or join the group that may open it (dialout)"
            raise BusError(f"{self._bus}: can't open {self._device}: {cause}", remedy) from cause
        self._hub, self._serial = hub, uart
        self._session = self._make_session(hub, hub.join("port"), self._write)
        asyncio.get_running_loop().add_reader(uart.fileno(), self._on_readable)

    async def close(self) -> None:
        if self._serial is not None:
            self._unplug(self._serial)
        if self._hub is not None and self._session is not None:
            self._session.close()
            self._hub.leave("port")
        self._hub = None

    def _write(self, data: bytes) -> None:
        if self._serial is None:
            return
        try:
            written = os.write(self._serial.fileno(), data)
        except OSError as fault:
            written = 0
            log.debug("%s: %s", self._device, fault)
        if written < len(data):
            log.debug("%s takes no more: a response of %d bytes is lost", self._device, len(data))

    def _on_readable(self) -> None:
        if self._serial is None or self._session is None:
            return
        try:
            data = os.read(self._serial.fileno(), 4096)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if data:
            self._session.on_bytes(data)
        else:
            log.warning("%s: %s is gone", self._bus, self._device)
            self._unplug(self._serial)

    def _unplug(self, uart: Any) -> None:
        asyncio.get_running_loop().remove_reader(uart.fileno())
        uart.close()
        self._serial = None


class TcpLinePort(Port):
    """RTU or ASCII over TCP, as from a serial device server."""

    def __init__(self, settings: ModbusLineSettings, make_session: MakeSession) -> None:
        self._settings, self._make_session = settings, make_session
        self._masters: Masters | None = None

    @property
    def number(self) -> int:
        """The TCP port that is listened at."""
        return self._masters.port if self._masters is not None else split_address(self._settings.listen or "")[1]

    async def open(self, hub: Hub) -> None:
        def make(masters: Masters) -> Master:
            return _LineMaster(masters, hub, self._make_session)

        masters = Masters(self._settings.listen or "", make, self._settings.max_connections)
        await masters.open()
        self._masters = masters

    async def close(self) -> None:
        if self._masters is not None:
            await self._masters.close()


class _LineMaster(Master):
    def __init__(self, server: Masters, hub: Hub, make_session: MakeSession) -> None:
        super().__init__(server, hub)
        self._make_session = make_session
        self._session: LineSession | None = None

    def on_open(self, link: Link[Any]) -> None:
        self._session = self._make_session(self.hub, link, self.transport.write)

    def on_bytes(self, data: bytes) -> None:
        if self._session is not None:
            self._session.on_bytes(data)

    def on_close(self) -> None:
        if self._session is not None:
            self._session.close()
