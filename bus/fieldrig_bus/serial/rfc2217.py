"""`serial.rfc2217`: a serial line with one end on a TCP port that also carries settings, control lines and breaks.

It follows RFC 2217, for `rfc2217://` clients and all programs that can use serial servers.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import ClassVar

from pydantic import Field

from fieldrig.bus import Hub, Port
from fieldrig.device import Tool, WayIn
from fieldrig.settings import Address
from fieldrig_bus.net import Connection, ServingPort, TcpServer, join_as_client
from fieldrig_bus.serial.bus import SerialBus, SerialHubSettings, TcpLineFaults
from fieldrig_bus.serial.com_port import ComPort
from fieldrig_bus.serial.end import LineEnd
from fieldrig_bus.serial.faults import TCP_MODELS
from fieldrig_bus.serial.message import ControlLines, SerialMessage
from fieldrig_bus.serial.outside import ClientPlace


class SerialRfc2217Settings(SerialHubSettings, TcpLineFaults):
    listen: Address = Field(description="host:port where a client connects")


class SerialRfc2217(SerialBus):
    about: ClassVar[str] = "a serial line with one end on a TCP port, with control lines (RFC 2217)"

    fault_models = TCP_MODELS

    def __init__(self, name: str, settings: SerialRfc2217Settings) -> None:
        super().__init__(name, settings)

    def ports(self) -> Sequence[Port]:
        return (Rfc2217Port(self.settings),)

    def ways_in(self, run: Path) -> list[WayIn]:
        return [WayIn("serial line by RFC 2217", self.settings.listen)]

    def tools(self, run: Path) -> list[Tool]:
        url, baud = f"rfc2217://{self.settings.listen}", self.settings.baud
        steps = f"import serial; p = serial.serial_for_url('{url}', {baud}); print(p.cd, p.dsr, p.cts, p.ri); p.close()"
        return [
            Tool("terminal", f"python -m serial.tools.miniterm {url} {baud}"),
            Tool("DCD, DSR, CTS, RI", f'python -c "{steps}"'),
        ]


class Rfc2217Port(ServingPort):
    def __init__(self, settings: SerialRfc2217Settings) -> None:
        self._settings = settings
        self.place = ClientPlace(settings.listen, self._client)
        self._hub: Hub | None = None
        self._end: LineEnd | None = None
        self._other_end = ControlLines()
        self._com_port: ComPort | None = None

    async def open(self, hub: Hub) -> None:
        self._hub = hub
        _, link = join_as_client(hub, "rfc2217")
        self._end = LineEnd(link, hub.clock, self._settings.format, self._settings.paced)
        self._end.on_room = self.place.read_on
        self._end.hang_up()
        link.on_receive(self._on_line, ("data", "lines", "break"))
        await self.place.open(hub.pace)
        hub.on_doors(self.meet)

    def servers(self) -> Iterable[TcpServer]:
        return (self.place.server,)

    async def close(self) -> None:
        await self.place.close()

    def _on_line(self, message: SerialMessage) -> None:
        if type(message) is ControlLines:
            self._other_end = message
        if self._com_port is not None:
            self._com_port.from_line(message)

    def _client(self, connection: Connection) -> "_TelnetClient":
        assert self._hub is not None
        assert self._end is not None
        com_port = ComPort(self._end, self._hub.clock, connection.write)
        return _TelnetClient(self, self._end, com_port)

    def begin(self, com_port: ComPort) -> None:
        self._com_port = com_port
        com_port.start(self._other_end)

    def end(self) -> None:
        self._com_port = None


class _TelnetClient:
    """Connects one client to the line."""

    def __init__(self, port: Rfc2217Port, end: LineEnd, com_port: ComPort) -> None:
        self._port, self._end, self._com_port = port, end, com_port
        self.received = com_port.from_client

    def started(self) -> None:
        self._end.plug_in()
        self._port.begin(self._com_port)

    def ended(self) -> None:
        self._com_port.stop()
        self._port.end()
        self._end.hang_up()
