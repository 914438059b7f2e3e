"""Modbus messages as TCP/IP packets (Modbus messaging on TCP/IP V1.0b), constructed for Wireshark.

The addresses are invented: 10.BUS.0.UNIT is the server of a unit, 10.BUS.CLIENT.1 a client.  Each client has one
connection to each unit, without a handshake; a SYN to 10.BUS.0.0 represents a client that connects.  A response goes to
the client whose request it answers: the one that it names, or of the same unit and number, or in a trace of an older
version the latest one of a client with the same function code.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple

from fieldrig.faults.note import FaultNote
from fieldrig_bus.modbus.message import ClientConnected, DamagedAnswer, ModbusRequest, ModbusResponse, OnModbus

PORT = 502
_IP = struct.Struct("!BBHHHBBH4s4s")  # RFC 791, 3.1
_TCP = struct.Struct("!HHIIHHHH")  # RFC 793, 3.1
_MBAP = struct.Struct("!HHHB")  # transaction, protocol 0, length of the rest, unit
_TCP_PROTOCOL = 6
_PUSH_ACK = 5 << 12 | 0x18  # a header of 5 words
_SYN = 5 << 12 | 0x02
_WINDOW = 0xFFFF


@dataclass(slots=True)
class _Connection:
    client: bytes
    server: bytes
    port: int
    client_sequence: int = 1
    server_sequence: int = 1


MOST_OPEN: Final = 4_096
"""Requests of a bus that wait for a response at the same time."""


class _Open(NamedTuple):
    """A request that has not been answered yet."""

    client: str
    unit: int
    function: int
    exchange: int


class PacketMaker:
    """The packets of one bus, in the order of its trace."""

    def __init__(self, bus_number: int) -> None:
        self._net = 10, bus_number & 0xFF
        self._clients: dict[str, int] = {}
        self._connections: dict[tuple[str, int], _Connection] = {}
        self._open: dict[tuple[int, int], list[_Open]] = {}
        """The open requests by unit and number, the oldest first."""
        self._packets = 0

    def make(self, sender: str, message: OnModbus) -> bytes:
        """The message as an IPv4 packet; an empty one for the note of a fault."""
        if isinstance(message, FaultNote):
            connection = self._connection(sender, 0)
            return self._packet(connection.client, connection.server, connection.port, PORT, 0, 0, b"")
        if isinstance(message, ClientConnected):
            connection = self._connection(sender, 0)
            return self._packet(connection.client, connection.server, connection.port, PORT, 0, 0, b"", _SYN)
        if isinstance(message, ModbusRequest):
            unit, exchange, client = message.unit, message.exchange, sender
            self._ask(_Open(client, unit, message.pdu[0], exchange))
        else:
            client, unit, _, exchange = self._asked_by(message)
        shown = message.unit if isinstance(message, ModbusRequest) or message.asked is None else unit
        adu = _MBAP.pack(exchange & 0xFFFF, 0, 1 + len(message.pdu), shown) + message.pdu
        if isinstance(message, DamagedAnswer):
            adu = b"".join(data for _, data in message.pieces)
        connection = self._connection(client, unit)
        if isinstance(message, ModbusRequest):
            sequence, acknowledged = connection.client_sequence, connection.server_sequence
            connection.client_sequence = sequence + len(adu) & 0xFFFF_FFFF
            return self._packet(
                connection.client, connection.server, connection.port, PORT, sequence, acknowledged, adu
            )
        sequence, acknowledged = connection.server_sequence, connection.client_sequence
        connection.server_sequence = sequence + len(adu) & 0xFFFF_FFFF
        return self._packet(connection.server, connection.client, PORT, connection.port, sequence, acknowledged, adu)

    def _ask(self, open_: _Open) -> None:
        self._open.setdefault((open_.unit, open_.exchange), []).append(open_)
        if len(self._open) > MOST_OPEN:
            del self._open[next(iter(self._open))]

    def _asked_by(self, response: ModbusResponse | DamagedAnswer) -> _Open:
        """Return the request that a response answers, which is open no longer."""
        key = response.request if response.request in self._open or response.asked else self._like(response)
        waiting = self._open.get(key)
        if waiting is None:
            return _Open("", response.request.unit, 0, response.exchange)
        oldest = waiting.pop(0)
        if not waiting:
            del self._open[key]
        return oldest

    def _like(self, response: ModbusResponse | DamagedAnswer) -> tuple[int, int]:
        """Return the latest request of a client with the same function, and for the same unit if there is one.

        A server identified by its address may answer as unit 0 or 255 (guide, chapter 4).
        """
        function = response.pdu[0] & 0x7F if response.pdu else 0
        waiting = ((key, one) for key, same in self._open.items() for one in same if one.function == function)
        latest = list({(one.client, one.unit): key for key, one in waiting}.values())
        of_unit = (key for key in latest if key[0] == response.unit)
        return next(of_unit, next(iter(latest), response.request))

    def _connection(self, client: str, unit: int) -> _Connection:
        connection = self._connections.get((client, unit))
        if connection is None:
            number = self._clients.setdefault(client, len(self._clients) + 1)
            connection = _Connection(
                client=bytes((*self._net, number & 0xFF or 0xFF, 1)),
                server=bytes((*self._net, 0, unit)),
                port=49152 + number % 16384,
            )
            self._connections[client, unit] = connection
        return connection

    def _packet(
        self,
        source: bytes,
        target: bytes,
        from_port: int,
        to_port: int,
        sequence: int,
        acknowledged: int,
        adu: bytes,
        flags: int = _PUSH_ACK,
    ) -> bytes:
        self._packets += 1
        length = _TCP.size + len(adu)
        head = from_port, to_port, sequence, acknowledged, flags, _WINDOW
        pseudo = source + target + struct.pack("!HH", _TCP_PROTOCOL, length)
        checksum = _checksum(pseudo + _TCP.pack(*head, 0, 0) + adu)
        ip = 0x45, 0, _IP.size + length, self._packets & 0xFFFF, 0, 64, _TCP_PROTOCOL
        ip_checksum = _checksum(_IP.pack(*ip, 0, source, target))
        return _IP.pack(*ip, ip_checksum, source, target) + _TCP.pack(*head, checksum, 0) + adu


def messages_in(packet: bytes) -> Iterator[tuple[str, ModbusRequest | ModbusResponse]]:
    """Sender, as address and port, and message of each complete ADU in an IPv4 packet; nothing if it has none."""
    if len(packet) < 20 or packet[0] >> 4 != 4 or packet[9] != _TCP_PROTOCOL:
        return
    start, end = (packet[0] & 0x0F) * 4, min(int.from_bytes(packet[2:4], "big"), len(packet))
    if start + _TCP.size > end:
        return
    from_port, to_port, *_ = _TCP.unpack_from(packet, start)
    if PORT not in (from_port, to_port):
        return
    sender = f"{'.'.join(map(str, packet[12:16]))}:{from_port}"
    at = start + (packet[start + 12] >> 4) * 4
    while at + _MBAP.size < end:
        transaction, protocol, length, unit = _MBAP.unpack_from(packet, at)
        pdu = packet[at + _MBAP.size : at + 6 + length]
        if protocol != 0 or not 2 <= length <= 254 or at + 6 + length > end:
            return
        yield sender, (ModbusRequest if to_port == PORT else ModbusResponse)(unit, pdu, transaction)
        at += 6 + length


def _checksum(data: bytes) -> int:
    """The Internet checksum (RFC 1071): the complement of the one's complement sum of all words."""
    if len(data) % 2:
        data += b"\0"
    total: int = sum(struct.unpack(f"!{len(data) // 2}H", data))
    while total >> 16:
        total = (total & 0xFFFF) + (total >> 16)
    return ~total & 0xFFFF
