"""Where the outside end of a serial line is: a pty, a real port, or a TCP connection that carries its bytes.

What stands there is a master, or, with `servers`, those units: then the line's master is in the rig.  A real port that
vanishes is opened again when it is back.
"""

import asyncio
import logging
import os
from collections.abc import Callable
from typing import Any, Protocol, Self, cast

from pydantic import Field, model_validator
from serial import serial_for_url
from serial.serialutil import SerialException

from fieldrig.bus import Hub, Port
from fieldrig.errors import BusError
from fieldrig.link import Link
from fieldrig.net import split_address
from fieldrig_bus.modbus.dialler import Dialler, Handlers, pause_s
from fieldrig_bus.modbus.kind import CharacterSettings
from fieldrig_bus.modbus.outside import ServerAddress, UnitId
from fieldrig_bus.modbus.routing import SERVER
from fieldrig_bus.modbus.sockets import Master, Masters
from fieldrig_bus.net import Address, HubSettings
from fieldrig_bus.pty import Pty

log = logging.getLogger(__name__)


class Session(Protocol):
    """What is done with the bytes of a line."""

    def on_bytes(self, data: bytes) -> None: ...

    def close(self) -> None: ...


MakeSession = Callable[[Hub, Link[Any], Callable[[bytes], None]], Session]


class ModbusLineSettings(HubSettings, CharacterSettings):
    pty: str | None = Field(
        default=None, description="name of a pty in the run folder: what a master opens as its port"
    )
    port: str | None = Field(default=None, description="a real port, such as /dev/ttyUSB0")
    listen: Address | None = Field(default=None, description="host:port where the line's bytes go over TCP")
    baud: int = Field(default=19200, ge=300, le=10_000_000)
    dial: ServerAddress | None = Field(
        default=None, description="host:port of a serial server that has the line; it is connected to"
    )
    max_connections: int = Field(default=8, ge=1, description="masters at `listen`")
    servers: list[UnitId] = Field(
        default_factory=list, description="units at the outside end that devices of the rig ask; without: a master"
    )
    response_timeout_ms: int = Field(
        default=1000, ge=1, le=600_000, description="how long the line waits for one of `servers` (V1.02, 2.4.1)"
    )
    turnaround_ms: int = Field(default=100, ge=0, le=10_000, description="silence after a broadcast to them")

    @model_validator(mode="after")
    def _check_one_way_in(self) -> Self:
        if sum(way is not None for way in (self.pty, self.port, self.listen, self.dial)) != 1:
            raise ValueError("exactly one of pty, port, listen and dial says where the line is")
        if self.servers and self.listen is not None:
            raise ValueError("listen is for masters: dial, port or pty would be right beside servers")
        if twice := sorted({unit for unit in self.servers if self.servers.count(unit) > 1}):
            raise ValueError(f"servers: {', '.join(map(str, twice))}: each unit once would be right")
        return self

    def member(self, name: str) -> str:
        """What the outside end is called on the bus."""
        return SERVER + name if self.servers else name


class PtyPort(Port):
    def __init__(self, settings: ModbusLineSettings, make_session: MakeSession) -> None:
        self._name, self._member, self._make_session = settings.pty or "", settings.member("pty"), make_session
        self._is_master = bool(settings.servers)
        self._hub: Hub | None = None
        self._pty: Pty | None = None
        self._session: Session | None = None

    async def open(self, hub: Hub) -> None:
        pty = Pty(hub.path(self._name))
        session = self._make_session(hub, hub.join(self._member), self._ask if self._is_master else pty.write)
        self._hub, self._pty, self._session = hub, pty, session
        pty.open(session.on_bytes)

    async def close(self) -> None:
        if self._hub is None or self._pty is None or self._session is None:
            return
        self._pty.close()
        self._session.close()
        self._hub.leave(self._member)
        self._hub = None

    def _ask(self, data: bytes) -> None:
        """A server that opens the pty later must not hear what was asked while nobody listened."""
        if self._pty is not None:
            self._pty.forget()
            self._pty.write(data)


class UartPort(Port):
    def __init__(self, bus: str, settings: ModbusLineSettings, make_session: MakeSession) -> None:
        self._bus, self._settings, self._make_session = bus, settings, make_session
        self._device, self._member = settings.port or "", settings.member("port")
        self._hub: Hub | None = None
        self._serial: Any = None
        self._session: Session | None = None
        self._failures = 0
        self._again: asyncio.TimerHandle | None = None

    async def open(self, hub: Hub) -> None:
        try:
            self._plug_in()
        except (SerialException, ValueError) as cause:
            remedy = "plug it in, name another port, or join the group that may open it (dialout)"
            raise BusError(f"{self._bus}: can't open {self._device}: {cause}", remedy) from cause
        self._hub = hub
        self._session = self._make_session(hub, hub.join(self._member), self._write)

    async def close(self) -> None:
        if self._again is not None:
            self._again.cancel()
        if self._serial is not None:
            self._unplug(self._serial)
        if self._hub is not None and self._session is not None:
            self._session.close()
            self._hub.leave(self._member)
        self._hub = None

    def _plug_in(self) -> None:
        """SerialException or ValueError if that can't be done."""
        settings, open_uart = self._settings, cast(Callable[..., Any], serial_for_url)
        self._serial = open_uart(
            self._device,
            settings.baud,
            settings.data_bits,
            settings.parity,
            settings.stop_bits,
            timeout=0,
            exclusive=True,
        )
        asyncio.get_running_loop().add_reader(self._serial.fileno(), self._on_readable)

    def _plug_in_again(self) -> None:
        try:
            self._plug_in()
        except (SerialException, ValueError) as fault:
            log.debug("%s: %s", self._bus, fault)
            self._wait()
        else:
            self._failures = 0
            log.info("%s: %s is back", self._bus, self._device)

    def _wait(self) -> None:
        self._failures += 1
        self._again = asyncio.get_running_loop().call_later(pause_s(self._failures), self._plug_in_again)

    def _write(self, data: bytes) -> None:
        if self._serial is None:
            return
        try:
            written = os.write(self._serial.fileno(), data)
        except OSError as fault:
            written = 0
            log.debug("%s: %s", self._device, fault)
        if written < len(data):
            log.debug("%s takes no more: a frame of %d bytes is lost", self._device, len(data))

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
            self._wait()

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
        self._session: Session | None = None

    def on_open(self, link: Link[Any]) -> None:
        self._session = self._make_session(self.hub, link, self.transport.write)

    def on_bytes(self, data: bytes) -> None:
        if self._session is not None:
            self._session.on_bytes(data)

    def on_close(self) -> None:
        if self._session is not None:
            self._session.close()


class DiallingPort(Port):
    """RTU or ASCII over TCP, to a serial device server."""

    def __init__(self, bus: str, settings: ModbusLineSettings, make_session: MakeSession) -> None:
        self._address, self._member, self._make_session = settings.dial or "", settings.member("dial"), make_session
        self._dialler = Dialler(bus, self._address, Handlers(_pass, self._on_bytes, _pass, lambda: True))
        self._hub: Hub | None = None
        self._session: Session | None = None

    async def open(self, hub: Hub) -> None:
        """Who is dialled may come later."""
        self._hub = hub
        self._session = self._make_session(hub, hub.join(self._member), self._dialler.write)
        self._dialler.want()

    async def close(self) -> None:
        await self._dialler.close()
        if self._hub is not None and self._session is not None:
            self._session.close()
            self._hub.leave(self._member)
        self._hub = None

    def _on_bytes(self, data: bytes) -> None:
        self._dialler.worked()
        if self._session is not None:
            self._session.on_bytes(data)


def _pass() -> None:
    """A line hears nothing of its connection."""
