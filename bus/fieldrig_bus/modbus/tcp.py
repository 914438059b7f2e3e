"""`modbus.tcp`: devices that any Modbus TCP client can reach.

Source: Modbus messaging on TCP/IP implementation guide V1.0b.  Each connection is a member of the bus.  Transactions
may be pipelined, and each is answered as soon as its answer is there.  Units 0 and 255 mean the device itself if it is
the only unit (or `direct_unit`).  For a unit that does not exist, the bus acts as a gateway to serial devices: it
answers with exception 0x0B (gateway target device failed to respond: "usually means that the device is not present on
the network", application protocol V1.1b3, chapter 7), or not at all.

`servers` are outside units that devices of the rig use (see `outside`); masters at `listen` cannot reach them.
Left out: TLS (Modbus security), access control by address.

A request is handled in one pass from `data_received` to `transport.write`, without a task or another iteration of the
event loop.  A connection has at most `MOST_TRANSACTIONS` requests without an answer; while it has more, nothing is read
from it (guide, 4.4.2), and those that were read already wait for their turn (`turns`).
"""

import logging
from collections import deque
from collections.abc import Hashable, Sequence
from pathlib import Path
from typing import Any, ClassVar, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.bus import Port, Time
from fieldrig.clock import Alarm, S
from fieldrig.device import WayIn
from fieldrig.link import Link
from fieldrig.outside.addresses import split_address
from fieldrig.settings import Address
from fieldrig_bus.modbus.faults import TCP_MODELS, TcpFault
from fieldrig_bus.modbus.framing_mbap import HEADER, MbapFramer
from fieldrig_bus.modbus.kind import FAULTS, ModbusBus
from fieldrig_bus.modbus.message import ClientConnected, DamagedAnswer, ModbusRequest, ModbusResponse
from fieldrig_bus.modbus.model import ModbusModel
from fieldrig_bus.modbus.outside import Servers, by_address, listens_at, ports_of
from fieldrig_bus.modbus.sockets import Master, MastersPort
from fieldrig_bus.net import HubSettings

log = logging.getLogger(__name__)

_pack = HEADER.pack

MOST_TRANSACTIONS: Final = 16
"""Requests of a connection without an answer (guide, 4.4.2: NumberMaxOfServerTransaction, 1 to 16)."""
PATIENCE_NS: Final = 5 * S
"""Time after which a request without an answer, such as one to a unit that is not there, makes room for others."""


class ModbusTcpSettings(HubSettings):
    listen: Address = Field(default="127.0.0.1:5020", description="host:port for clients")
    unknown_unit: Literal["exception", "silence"] = Field(
        default="exception", description="response to a request for a unit that does not exist: exception 0x0B, or none"
    )
    direct_unit: int | None = Field(
        default=None, ge=1, le=247, description="the unit that answers to 0 and 255; null: the only unit"
    )
    idle_timeout_s: float | None = Field(
        default=None, gt=0, description="a connection is closed after this time without requests"
    )
    max_connections: int = Field(
        default=64,
        ge=1,
        le=10_000,
        description="connections; one more closes the connection that was idle longest (guide, 4.2)",
    )
    servers: Servers = Field(
        default_factory=dict, description="outside units that devices of the rig use: 7: host:port"
    )
    response_timeout_ms: int = Field(default=1000, ge=1, le=600_000, description="response timeout for `servers`")
    faults: list[TcpFault] = Field(default_factory=list, description=FAULTS)

    def leads_to(self, what: str, value: Hashable) -> bool:
        return value in self.servers

    @model_validator(mode="after")
    def _servers_are_elsewhere(self) -> Self:
        for address in by_address(self.servers):
            if listens_at(self.listen, address):
                raise ValueError(f"servers: {address} is this bus itself: expected the address of another server")
        return self


class ModbusTcp(ModbusBus):
    about: ClassVar[str] = "Modbus TCP: any client can reach the devices of this bus"
    times: ClassVar[frozenset[Time]] = frozenset({"real", "virtual"})
    fault_models = TCP_MODELS
    serves_outsiders: ClassVar[bool] = True

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

    def ways_in(self, run: Path) -> list[WayIn]:
        return [WayIn("Modbus TCP", self.settings.listen)]

    def mbpoll(self) -> tuple[Sequence[str], str]:
        host, port = split_address(self.settings.listen)
        return ("-m", "tcp", "-p", str(port)), host

    def pymodbus(self) -> str:
        host, port = split_address(self.settings.listen)
        return f"from pymodbus.client import ModbusTcpClient; c = ModbusTcpClient({host!r}, port={port}); c.connect()"


class TcpPort(MastersPort):
    def __init__(self, settings: ModbusTcpSettings) -> None:
        super().__init__(settings.listen, TcpMaster, settings.max_connections, settings.idle_timeout_s)


class TcpMaster(Master):
    """The exchange number contains what the response has to repeat: unit and transaction."""

    def on_open(self, link: Link[Any]) -> None:
        self._framer = MbapFramer()
        self._waiting: deque[ModbusRequest] = deque()  # one, as what was read waits for its turn (`portions`)
        self._asked: deque[tuple[int, int]] = deque()  # instant and unit of what has no answer yet
        self._timer = Alarm(self.hub.clock)
        self._is_going_on = self._is_stopped = False
        self._send, self._write = link.send, self.transport.write
        link.on_receive(self._on_response, ())
        peer = self.transport.get_extra_info("peername")
        if peer is not None:  # None: the connection is closed already
            link.send(ClientConnected(peer[0]))

    def end_of_first(self, data: bytes) -> int:
        return self._framer.end_of_first(data)

    def on_bytes(self, data: bytes) -> None:
        requests = self._framer.feed(data)
        if requests:
            self.heard()
        for transaction, unit, pdu in requests:
            self._waiting.append(ModbusRequest(unit, pdu, transaction | unit << 16))
        self.go_on()
        if self._framer.is_lost:
            log.debug("%s: not MBAP; closed", self.member)
            self.transport.close()

    def on_close(self) -> None:
        self._waiting.clear()
        self._timer.stop()
        self.server.turns.leave(self)
        while self._asked:
            self.server.turns.end(self._asked.popleft()[1])

    def go_on(self) -> None:
        """Send the requests that wait, as far as the limits allow it."""
        if self._is_going_on:  # an answer came while its request was being sent
            return
        self._is_going_on = True
        waiting, turns = self._waiting, self.server.turns
        self._give_up()
        while waiting and len(self._asked) < MOST_TRANSACTIONS and turns.begin(unit := waiting[0].unit, self):
            self._asked.append((self.hub.clock.now_ns(), unit))
            self._send(waiting.popleft())
        self._is_going_on = False
        if self._asked and not self._timer.is_set:
            self._timer.at(self._asked[0][0] + PATIENCE_NS, self.go_on)
        self._stop_or_read()

    def _give_up(self) -> None:
        """Leave the places of requests without an answer to others: a silent unit has a few of them for all clients."""
        asked, now_ns = self._asked, self.hub.clock.now_ns()
        while asked and asked[0][0] + PATIENCE_NS <= now_ns:
            self.server.turns.end(asked.popleft()[1])

    def _stop_or_read(self) -> None:
        """Read nothing while requests wait, or while the client does not read its answers."""
        is_stopped = bool(self._waiting)
        if is_stopped and not self._is_stopped:
            self.server.door.reached.note(
                "clients that had to wait", f"{self.member} sends requests faster than they are answered"
            )
        self._is_stopped = is_stopped
        self.read_on(not (is_stopped or self.is_full))

    def _on_response(self, response: ModbusResponse | DamagedAnswer) -> None:
        pdu, exchange = response.pdu, response.exchange
        if type(response) is DamagedAnswer:
            self._write_damaged(response)
        else:
            self._write(_pack(exchange & 0xFFFF, 0, len(pdu) + 1, exchange >> 16) + pdu)
        unit = exchange >> 16
        for index, (asked_ns, asked) in enumerate(self._asked):
            if asked == unit:  # there is none if it was given up
                del self._asked[index]
                if self.pace is not None and not self._is_going_on:  # otherwise what goes on measures it
                    self.pace.answered(asked_ns)
                self.server.turns.end(unit)
                break
        if self._waiting:
            self.go_on()

    def resume_writing(self) -> None:
        super().resume_writing()
        self._stop_or_read()
