"""`serial.tcp`: a serial line with one end on a TCP port, raw bytes both ways, for `socket://` clients and netcat.

It listens, or dials: then it connects to a serial server elsewhere, and reconnects whenever that has closed.  While a
client is connected, the other end sees DTR and RTS on.
Left out, because raw TCP cannot carry them: control lines, formats and breaks.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import ClassVar, Self

from pydantic import Field, model_validator

from fieldrig.bus import Hub, Port
from fieldrig.device import Tool, WayIn
from fieldrig.settings import Address
from fieldrig_bus.net import Connection, ServingPort, TcpServer, join_as_client
from fieldrig_bus.serial.bus import SerialBus, SerialHubSettings, TcpLineFaults
from fieldrig_bus.serial.end import LineEnd
from fieldrig_bus.serial.faults import TCP_MODELS
from fieldrig_bus.serial.outside import ClientPlace


class SerialTcpSettings(SerialHubSettings, TcpLineFaults):
    listen: Address | None = Field(default=None, description="host:port where a client connects")
    dial: Address | None = Field(
        default=None, description="host:port of a serial server to connect to, instead of listening"
    )

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if (self.listen is None) == (self.dial is None):
            raise ValueError("expected either listen: host:port or dial: host:port")
        return self


class SerialTcp(SerialBus):
    about: ClassVar[str] = "a serial line with one end on a TCP port (raw)"

    fault_models = TCP_MODELS

    def __init__(self, name: str, settings: SerialTcpSettings) -> None:
        super().__init__(name, settings)

    def ports(self) -> Sequence[Port]:
        return (TcpPort(self.settings),)

    def ways_in(self, run: Path) -> list[WayIn]:
        address = self.settings.listen
        return [] if address is None else [WayIn("serial line by TCP", address)]

    def tools(self, run: Path) -> list[Tool]:
        address, baud = self.settings.listen, self.settings.baud
        if address is None:
            return []
        return [
            Tool("terminal", f"python -m serial.tools.miniterm socket://{address} {baud}"),
            Tool("as a local port", f"socat pty,rawer,link=./{self.name} TCP:{address}"),
        ]


class TcpPort(ServingPort):
    def __init__(self, settings: SerialTcpSettings) -> None:
        self._settings = settings
        self.place = ClientPlace(settings.listen or settings.dial or "", self._client, settings.listen is None)
        self._end: LineEnd | None = None

    async def open(self, hub: Hub) -> None:
        _, link = join_as_client(hub, "tcp")
        self._end = LineEnd(link, hub.clock, self._settings.format, self._settings.paced)
        self._end.on_room = self.place.read_on
        self._end.hang_up()
        link.on_receive(self.place.write)
        await self.place.open(hub.pace)
        hub.on_doors(self.meet)

    def servers(self) -> Iterable[TcpServer]:
        return (self.place.server,)

    async def close(self) -> None:
        await self.place.close()

    def _client(self, connection: Connection) -> "_RawClient":
        assert self._end is not None
        return _RawClient(self._end)


class _RawClient:
    def __init__(self, end: LineEnd) -> None:
        self.started, self.received, self.ended = end.plug_in, end.send, end.hang_up
