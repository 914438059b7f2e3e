"""A host with one address at the end of one link: IPv4, ICMP echo and TCP, as passive code.

`receive` takes packets, `advance` lets time pass, `next_ns` is the instant of the next event, and `transmit` is called
with the packets to send, always within `receive` or `advance`.  After `connect`, and after a call of a connection
outside of its handlers, `next_ns` returns the present instant, and `advance` sends what follows from the call.

Data wait in their connections while `has_room` returns False; when it returns True again, `advance` sends them.

Sources: RFC 1122 and RFC 9293.  Left out: options, routing, UDP (refused by ICMP), and ICMP errors about our packets.
"""

import logging
from collections import Counter, deque
from collections.abc import Callable
from hashlib import blake2b
from ipaddress import IPv4Address
from typing import Final

from fieldrig.outside.limits import OVER_LIMIT, OnLimit
from fieldrig_devices.ip import icmp
from fieldrig_devices.ip.fragments import MOST_WAITING, Reassembly, fragments_of
from fieldrig_devices.ip.ipv4 import HEADER_BYTES, Packet, Protocol
from fieldrig_devices.ip.tcp import segment as tcp
from fieldrig_devices.ip.tcp.arrival import arrive, refusal
from fieldrig_devices.ip.tcp.connection import Connection, Ending, Key
from fieldrig_devices.ip.tcp.output import HasRoom, always, output
from fieldrig_devices.ip.tcp.segment import ACK, RST, SYN, Segment
from fieldrig_devices.ip.tcp.states import Event, TcpState
from fieldrig_devices.ip.tcp.timers import arm, expire, next_ns

log = logging.getLogger(__name__)

LEAST_MTU: Final = 68
"""The shortest packet that every link carries (RFC 791)."""
MOST_MTU: Final = 0xFFFF
MOST_CONNECTIONS: Final = 256
MOST_HALF_OPEN: Final = 64
"""Connections in SYN-RECEIVED; a further SYN takes the place of the oldest one of the peer that has most of them."""
FIRST_OWN_PORT: Final = 49_152
"""Ports of connections that the stack opens (RFC 6335, 6): from here to 65535."""
WINDOW: Final = 32_768
_TICK_NS: Final = 4_000

Accept = Callable[[Connection], None]


class Stack:
    def __init__(
        self,
        address: IPv4Address,
        mtu: int,
        transmit: Callable[[bytes], None],
        *,
        window: int = WINDOW,
        secret: bytes = b"",
        has_room: HasRoom = always,
        on_limit: OnLimit = lambda _limit, _what: None,
    ) -> None:
        """`mtu` is the longest packet of the link, 68 to 65535 bytes; `window` the receive window, 1 to 65535 bytes.

        `has_room` returns whether the link takes a further packet with data.  `on_limit` hears of limits of peers.
        `secret`, of up to 64 bytes, makes the initial sequence numbers hard to guess (RFC 9293, 3.4.1).
        ValueError for numbers outside of these ranges.
        """
        if not LEAST_MTU <= mtu <= MOST_MTU:
            raise ValueError(f"an MTU of {mtu}, expected {LEAST_MTU} to {MOST_MTU}")
        if not 1 <= window <= 0xFFFF:
            raise ValueError(f"a window of {window}, expected 1 to 65535")
        self.address = address
        self.dropped = 0
        """Packets that were damaged, or not meant for this host."""
        self._mtu, self._transmit, self._window, self._secret = mtu, transmit, window, secret
        self._link_has_room = has_room
        self._now_ns = 0
        self._listeners: dict[int, Accept] = {}
        self._connections: dict[Key, Connection] = {}
        self._woken: dict[Connection, None] = {}
        self._held: dict[Connection, None] = {}
        """Connections that wait for room on the link, each behind those that have waited for longer."""
        self._arrived: deque[bytes] = deque()
        self._on_limit = on_limit
        self._reassembly = Reassembly(
            lambda: on_limit(
                "packets over the limit", f"{MOST_WAITING} packets wait for fragments; the oldest is dropped"
            )
        )
        self._is_running = False
        self._identification = self._last_own_port = 0

    @property
    def connections(self) -> list[Connection]:
        return list(self._connections.values())

    def has_connection(self, key: Key) -> bool:
        return key in self._connections

    def listen(self, port: int, accept: Accept) -> None:
        """Call `accept` with each connection to this port that is established, before its first data."""
        self._listeners[port] = accept

    def connect(self, address: IPv4Address, port: int) -> Connection:
        """Open a connection.  ConnectionError if all ports of this host are in use with this peer."""
        connection = self._connection(Key(self._own_port(address, port), address, port))
        connection.enter(Event.OPENED)
        self._wake(connection)
        return connection

    def receive(self, now_ns: int, packet: bytes) -> None:
        """Take a packet that arrived, whatever it contains."""
        self._arrived.append(packet)
        self._run(now_ns)

    def advance(self, now_ns: int) -> None:
        """Do everything that is due, and send what follows from the calls of users."""
        for first in self._reassembly.expire(now_ns):
            self._answer(first, icmp.not_in_time(first))
        for connection in self.connections:
            due_ns = next_ns(connection)
            if due_ns is not None and due_ns <= now_ns:
                expire(connection, now_ns)
                self._wake(connection)
        self._run(now_ns)

    def next_ns(self) -> int | None:
        """Return the instant at which `advance` has something to do; None as long as no packet and no call comes."""
        if self._woken:
            return self._now_ns
        due = [due_ns for connection in self._connections.values() if (due_ns := next_ns(connection)) is not None]
        if (late_ns := self._reassembly.next_ns()) is not None:
            due.append(late_ns)
        return min(due, default=None)

    def link_down(self, now_ns: int) -> None:
        """End all connections at once, because the link is gone."""
        for connection in self.connections:
            connection.finish(Ending.LINK_DOWN)
            connection.state = TcpState.CLOSED
        self._run(now_ns)

    # ---- running

    def _run(self, now_ns: int) -> None:
        """Handle packets and connections until nothing is left.  A call from within a handler leaves that to us."""
        self._now_ns = max(now_ns, self._now_ns)
        if self._is_running:
            return
        self._is_running = True
        try:
            while self._arrived or self._woken or (self._held and self._link_has_room()):
                if self._arrived:
                    self._on_packet(self._arrived.popleft())
                else:
                    ready = self._woken or self._held
                    connection = next(iter(ready))
                    del ready[connection]
                    self._serve(connection)
        finally:
            self._is_running = False

    def _serve(self, connection: Connection) -> None:
        connection.report()
        remote = connection.key.remote_address
        output(connection, self._now_ns, lambda segment: self._send_segment(remote, segment), self._link_has_room)
        arm(connection, self._now_ns)
        if connection.is_held:
            self._held.setdefault(connection)
        else:
            self._held.pop(connection, None)
        if connection.state is TcpState.CLOSED and self._connections.get(connection.key) is connection:
            del self._connections[connection.key]

    def _wake(self, connection: Connection) -> None:
        self._woken[connection] = None

    # ---- packets

    def _on_packet(self, data: bytes) -> None:
        try:
            packet = Packet.decode(data)
            if packet.destination != self.address:
                raise ValueError(f"a packet to {packet.destination}, expected one to {self.address}")
            if packet.source == self.address:  # RFC 1122, 3.2.1.3; a SYN of this kind was once called LAND
                raise ValueError("a packet from this host's own address")
            whole = self._reassembly.take(self._now_ns, packet)
            if whole is not None:
                self._on_whole(whole)
        except ValueError as cause:
            self.dropped += 1
            log.debug("a packet was dropped: %s", cause)

    def _on_whole(self, packet: Packet) -> None:
        match packet.protocol:
            case Protocol.TCP:
                self._on_segment(packet)
            case Protocol.ICMP:
                self._on_icmp(packet)
            case Protocol.UDP:
                self._answer(packet, icmp.unreachable(icmp.PORT_UNREACHABLE, packet))
            case _:
                self._answer(packet, icmp.unreachable(icmp.PROTOCOL_UNREACHABLE, packet))

    def _on_icmp(self, packet: Packet) -> None:
        reply = icmp.answer(packet.payload)
        if reply is not None and icmp.is_unicast(packet.source):
            self._send(packet.source, Protocol.ICMP, reply)

    def _answer(self, packet: Packet, message: bytes) -> None:
        """Send an error of ICMP about a packet, if one may be sent about it."""
        if icmp.is_refusable(packet):
            self._send(packet.source, Protocol.ICMP, message)

    def _on_segment(self, packet: Packet) -> None:
        if not icmp.is_unicast(packet.source):
            raise ValueError(f"a segment from {packet.source}, expected the address of a host")
        segment = Segment.decode(packet.payload, packet.source, packet.destination)
        connection = self._connections.get(Key(segment.destination_port, packet.source, segment.source_port))
        if connection is not None:
            answer = arrive(connection, self._now_ns, segment)
            self._wake(connection)
        elif segment.destination_port in self._listeners and not segment.flags & (ACK | RST):
            if segment.flags & SYN:
                self._on_syn(packet.source, segment)
            return  # RFC 9293, 3.10.7.2: a listener drops everything else
        else:
            answer = refusal(segment)
        if answer is not None:
            self._send_segment(packet.source, answer)

    def _on_syn(self, source: IPv4Address, segment: Segment) -> None:
        if not self._has_room():
            return  # the peer tries again
        port = segment.destination_port
        connection = self._connection(Key(port, source, segment.source_port))
        connection.is_passive = True
        connection.begin(segment.sequence, segment.mss)
        connection.outgoing.update_window(segment.sequence, 0, segment.window)
        connection.on_open = lambda: self._listeners[port](connection)
        connection.enter(Event.SYN)
        self._wake(connection)

    def _send_segment(self, remote: IPv4Address, segment: Segment) -> None:
        self._send(remote, Protocol.TCP, segment.encode(self.address, remote))

    def _send(self, remote: IPv4Address, protocol: Protocol, payload: bytes) -> None:
        self._identification = (self._identification + 1) & 0xFFFF
        for part in fragments_of(Packet(self.address, remote, protocol, payload, self._identification), self._mtu):
            self._transmit(part.encode())

    # ---- connections

    def _connection(self, key: Key) -> Connection:
        mss = self._mtu - HEADER_BYTES - tcp.HEADER_BYTES
        connection = Connection(key, self._first(key), mss, self._window, self._wake)
        self._connections[key] = connection
        return connection

    def _first(self, key: Key) -> int:
        """Return the initial sequence number: a clock of 4 us, and a secret number for each pair of ends."""
        parts = f"{self.address} {key.local_port} {key.remote_address} {key.remote_port}".encode()
        offset = blake2b(parts, digest_size=4, key=self._secret).digest()
        return (self._now_ns // _TICK_NS + int.from_bytes(offset, "big")) % (1 << 32)

    def _has_room(self) -> bool:
        """True if there may be a further connection of a peer.

        A half-open one is given up for it if there are too many, or else the oldest one in TIME-WAIT.
        """
        half_open = [key for key, old in self._connections.items() if old.state is TcpState.SYN_RECEIVED]
        if len(half_open) >= MOST_HALF_OPEN:
            (busiest, _), *_ = Counter(key.remote_address for key in half_open).most_common(1)
            del self._connections[next(key for key in half_open if key.remote_address == busiest)]
            self._on_limit(OVER_LIMIT, f"{MOST_HALF_OPEN} connections are half open; the oldest is given up")
        if len(self._connections) < MOST_CONNECTIONS:
            return True
        oldest = next((key for key, old in self._connections.items() if old.state is TcpState.TIME_WAIT), None)
        if oldest is None:
            self._on_limit(OVER_LIMIT, f"{MOST_CONNECTIONS} connections are open")
            return False
        del self._connections[oldest]
        return True

    def _own_port(self, address: IPv4Address, port: int) -> int:
        ports = 0x10000 - FIRST_OWN_PORT
        for step in range(1, ports + 1):
            own = FIRST_OWN_PORT + (self._last_own_port + step) % ports
            if Key(own, address, port) not in self._connections:
                self._last_own_port = own - FIRST_OWN_PORT
                return own
        raise ConnectionError(f"all {ports} ports of this host are connected to port {port} of {address}")
