"""`modbus.tcp`: devices that any Modbus TCP client reaches.

Source: Modbus messaging on TCP/IP implementation guide V1.0b.  Each connection is a member of the bus; transactions may
be pipelined and are answered as their answers come.  Unit 0 and 255 mean the device itself as long as it is the only
unit (or `direct_unit` says which); for a unit that is not there the bus is a gateway to serial devices, and answers
exception 0x0B (gateway target device failed to respond: "usually means that the device is not present on the network",
application protocol V1.1b3, chapter 7), or nothing.

`servers` are units outside, which devices of the rig ask (see `outside`); masters at `listen` don't get to them.  Left
out: TLS (Modbus security), access control by address.

A request costs one pass from `data_received` to `transport.write` without a task, a queue or a turn of the loop.
"""

import logging
import shlex
from collections.abc import Hashable, Sequence
from pathlib import Path
from typing import Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from fieldrig.bus import Hub, Port, Time
from fieldrig.device import Tool, python_line
from fieldrig.link import Link
from fieldrig.net import split_address
from fieldrig_bus.modbus.framing_mbap import HEADER, MbapFramer
from fieldrig_bus.modbus.kind import ModbusBus
from fieldrig_bus.modbus.message import ClientConnected, ModbusRequest, ModbusResponse
from fieldrig_bus.modbus.model import ModbusModel
from fieldrig_bus.modbus.outside import Servers, by_address, listens_at, ports_of
from fieldrig_bus.modbus.sockets import Master, Masters
from fieldrig_bus.net import Address, HubSettings

log = logging.getLogger(__name__)

_pack = HEADER.pack


class ModbusTcpSettings(HubSettings):
    listen: Address = Field(default="127.0.0.1:5020", description="host:port for clients")
    unknown_unit: Literal["exception", "silence"] = Field(
        default="exception", description="what a request for a unit that is not there gets: exception 0x0B, or nothing"
    )
    direct_unit: int | None = Field(
        default=None, ge=1, le=247, description="the unit that answers to 0 and 255; null: the only one there is"
    )
    idle_timeout_s: float | None = Field(default=None, gt=0, description="a silent connection is closed after it")
    max_connections: int = Field(
        default=64, ge=1, le=10_000, description="one more closes the one that was silent longest (guide, 4.2)"
    )
    servers: Servers = Field(
        default_factory=dict, description="units outside that devices of the rig ask: 7: host:port"
    )
    response_timeout_ms: int = Field(default=1000, ge=1, le=600_000, description="how long they are waited for")

    def leads_to(self, what: str, value: Hashable) -> bool:
        return value in self.servers

    @model_validator(mode="after")
    def _servers_are_elsewhere(self) -> Self:
        for address in by_address(self.servers):
            if listens_at(self.listen, address):
                raise ValueError(f"servers: {address} is this bus itself: the address of another server would be right")
        return self


class ModbusTcp(ModbusBus):
    about: ClassVar[str] = "Modbus TCP: any client reaches the devices of this bus"
    times: ClassVar[frozenset[Time]] = frozenset({"real"})

    def __init__(self, name: str, settings: ModbusTcpSettings) -> None:
        super().__init__(name, settings)

    def model(self) -> ModbusModel:
        settings: ModbusTcpSettings = self.settings
        return ModbusModel(
            direct_unit=settings.direct_unit, answers_for_unknown_units=settings.unknown_unit == "exception"
        )

    def ports(self) -> Sequence[Port]:
        settings: ModbusTcpSettings = self.settings
        return (TcpPort(settings), *ports_of(self.name, settings.servers, settings.response_timeout_ms))

    def tools(self, run: Path) -> list[Tool]:
        host, port = split_address(self.settings.listen)
        client = f"c = ModbusTcpClient({host!r}, port={port}); c.connect()"
        code = f"from pymodbus.client import ModbusTcpClient; {client}; print(c.read_coils(0, count=1)); c.close()"
        return [
            self.mbpoll_line("mbpoll", ["-a", "1", "-0", "-r", "0", "-c", "1", "-1"]),
            Tool("pymodbus", python_line(code)),
        ]

    def mbpoll_line(self, label: str, options: Sequence[str], *values: str) -> Tool:
        """A line for what the options of mbpoll say; `values` are written."""
        host, port = split_address(self.settings.listen)
        return Tool(label, shlex.join(["mbpoll", "-m", "tcp", "-p", str(port), *options, host, *values]))


class TcpPort(Port):
    def __init__(self, settings: ModbusTcpSettings) -> None:
        self._settings = settings
        self._masters: Masters | None = None

    @property
    def number(self) -> int:
        """The TCP port that is listened at."""
        return self._masters.port if self._masters is not None else split_address(self._settings.listen)[1]

    async def open(self, hub: Hub) -> None:
        settings = self._settings
        masters = Masters(
            settings.listen, lambda masters: TcpMaster(masters, hub), settings.max_connections, settings.idle_timeout_s
        )
        await masters.open()
        self._masters = masters

    async def close(self) -> None:
        if self._masters is not None:
            await self._masters.close()


class TcpMaster(Master):
    """The exchange number carries what the response has to repeat: unit and transaction."""

    def on_open(self, link: Link[Any]) -> None:
        self._framer = MbapFramer()
        self._send, self._write = link.send, self.transport.write
        link.on_receive(self._on_response, ())
        peer = self.transport.get_extra_info("peername")
        if peer is not None:  # None: it is gone already
            link.send(ClientConnected(peer[0]))

    def on_bytes(self, data: bytes) -> None:
        for transaction, unit, pdu in self._framer.feed(data):
            self._send(ModbusRequest(unit, pdu, transaction | unit << 16))
        if self._framer.is_lost:
            log.debug("%s: not MBAP, closed", self.member)
            self.transport.close()

    def _on_response(self, response: ModbusResponse) -> None:
        pdu, exchange = response.pdu, response.exchange
        self._write(_pack(exchange & 0xFFFF, 0, len(pdu) + 1, exchange >> 16) + pdu)
