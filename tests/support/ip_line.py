"""A line between two hosts in virtual time: packets are late, lost, doubled, reordered and damaged."""

import heapq
from collections.abc import Callable
from dataclasses import dataclass
from ipaddress import IPv4Address
from random import Random

from fieldrig.clock import MS, S
from fieldrig_devices.ip.ipv4 import Packet, Protocol
from fieldrig_devices.ip.stack import Stack
from fieldrig_devices.ip.tcp.connection import Connection, Ending
from fieldrig_devices.ip.tcp.segment import ACK, SYN, Flags, Segment

CALLER = IPv4Address("190.200.100.101")
CONTROLLER = IPv4Address("190.200.100.100")
PORT = 80


@dataclass(frozen=True)
class Quality:
    """The treatment of packets: shares from 0 to 1, and times in nanoseconds."""

    lost: float = 0.0
    doubled: float = 0.0
    damaged: float = 0.0
    delay_ns: int = 5 * MS
    jitter_ns: int = 0
    """Packets overtake each other within this time."""
    bytes_per_s: int = 0
    """Speed of the line in each direction, with an unlimited queue before it; 0 takes no time."""


class Line:
    """Two stacks and the packets between them."""

    def __init__(self, quality: Quality = Quality(), *, seed: int = 0, mtu: int = 576, window: int = 8192) -> None:
        self.now_ns = 0
        self.quality = quality
        self.packets: list[tuple[int, IPv4Address, bytes]] = []
        """Every packet that was sent: instant, sender and bytes."""
        self.lose: Callable[[bytes], bool] = lambda packet: False
        """Called with each packet; it is lost if this returns True."""
        self._random = Random(seed)
        self._flying: list[tuple[int, int, Stack, bytes]] = []
        self._free_ns = {CALLER: 0, CONTROLLER: 0}
        self.caller = self._host(CALLER, mtu, window)
        self.controller = self._host(CONTROLLER, mtu, window)

    def _host(self, address: IPv4Address, mtu: int, window: int) -> Stack:
        return Stack(address, mtu, lambda packet: self._send(address, packet), window=window)

    def _send(self, sender: IPv4Address, packet: bytes) -> None:
        self.packets.append((self.now_ns, sender, packet))
        random, quality = self._random, self.quality
        if self.lose(packet) or random.random() < quality.lost:
            return
        if random.random() < quality.damaged:
            place = random.randrange(len(packet))
            packet = packet[:place] + bytes([packet[place] ^ random.randrange(1, 256)]) + packet[place + 1 :]
        begin_ns = max(self._free_ns[sender], self.now_ns)
        end_ns = begin_ns + (len(packet) * S // quality.bytes_per_s if quality.bytes_per_s else 0)
        self._free_ns[sender] = end_ns
        receiver = self.controller if sender == CALLER else self.caller
        for _ in range(1 + (random.random() < quality.doubled)):
            late_ns = quality.delay_ns + random.randint(0, quality.jitter_ns)
            heapq.heappush(self._flying, (end_ns + late_ns, len(self.packets), receiver, packet))

    def next_ns(self) -> int | None:
        due = [self.caller.next_ns(), self.controller.next_ns(), self._flying[0][0] if self._flying else None]
        return min((when_ns for when_ns in due if when_ns is not None), default=None)

    def run(self, until_ns: int | None = None) -> None:
        """Let time pass until this instant, or until nothing more would happen by itself."""
        while (when_ns := self.next_ns()) is not None and (until_ns is None or when_ns <= until_ns):
            self.now_ns = max(when_ns, self.now_ns)
            while self._flying and self._flying[0][0] <= self.now_ns:
                _, _, receiver, packet = heapq.heappop(self._flying)
                receiver.receive(self.now_ns, packet)
            for stack in (self.caller, self.controller):
                due_ns = stack.next_ns()
                if due_ns is not None and due_ns <= self.now_ns:
                    stack.advance(self.now_ns)
        if until_ns is not None:
            self.now_ns = until_ns

    def run_for(self, seconds: float) -> None:
        self.run(self.now_ns + round(seconds * S))

    def connected(self) -> "tuple[User, User]":
        """Return the two ends of an established connection to port 80 of the controller."""
        accepted: list[User] = []
        self.controller.listen(PORT, lambda connection: accepted.append(User(connection)))
        caller = User(self.caller.connect(CONTROLLER, PORT))
        while not accepted:
            self.run_for(0.1)
        return caller, accepted[0]


class User:
    """A user of a connection that keeps what it is given."""

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self.received = bytearray()
        self.has_end = False
        self.endings: list[Ending] = []
        connection.on_data = self.received.extend
        connection.on_end = self._on_end
        connection.on_close = self.endings.append

    def _on_end(self) -> None:
        self.has_end = True


class Peer:
    """A peer by hand: it sends segments to a stack and sees those that the stack sends."""

    def __init__(self, mtu: int = 1500, window: int = 8192) -> None:
        self.now_ns = 0
        self.sent: list[Segment] = []
        self.others: list[Packet] = []
        """The packets of the stack that are no segments."""
        self.limits: list[str] = []
        """The limits that the stack says are reached, with what has happened."""
        self.stack = Stack(CONTROLLER, mtu, self._on_packet, window=window, on_limit=self._on_limit)
        self.users: list[User] = []
        self.stack.listen(PORT, lambda connection: self.users.append(User(connection)))
        self.theirs = 0
        """The stack's initial sequence number."""

    def _on_limit(self, limit: str, what: str) -> None:
        self.limits.append(f"{limit}: {what}")

    def _on_packet(self, data: bytes) -> None:
        packet = Packet.decode(data)
        if packet.protocol == Protocol.TCP:
            self.sent.append(Segment.decode(packet.payload, packet.source, packet.destination))
        else:
            self.others.append(packet)

    def send(self, flags: Flags, sequence: int, acknowledgment: int = 0, data: bytes = b"", window: int = 8192) -> None:
        """Send a segment from port 1000 to port 80."""
        self.give(Segment(1000, PORT, sequence % 2**32, acknowledgment % 2**32, flags, window, data))

    def give(self, segment: Segment) -> None:
        self.packet(Protocol.TCP, segment.encode(CALLER, CONTROLLER))

    def packet(self, protocol: int, payload: bytes) -> None:
        self.stack.receive(self.now_ns, Packet(CALLER, CONTROLLER, protocol, payload).encode())

    def take(self) -> list[Segment]:
        """Return the segments since the last call."""
        sent, self.sent = self.sent, []
        return sent

    def wait(self, seconds: float) -> None:
        """Let time pass, with everything that is due within it."""
        until_ns = self.now_ns + round(seconds * S)
        while (due_ns := self.stack.next_ns()) is not None and due_ns <= until_ns:
            self.now_ns = max(due_ns, self.now_ns)
            self.stack.advance(self.now_ns)
        self.now_ns = until_ns

    def act(self) -> list[Segment]:
        """Let the stack send what follows from the calls of its user, and return it."""
        self.wait(0)
        return self.take()

    def connect(self, sequence: int = 100, mss: int | None = 1000, window: int = 8192) -> User:
        """Establish a connection; the stack's first byte is number `theirs` + 1."""
        self.give(Segment(1000, PORT, sequence, 0, SYN, window, b"", mss))
        (answer,) = self.take()
        self.theirs = answer.sequence
        self.send(ACK, sequence + 1, answer.sequence + 1, window=window)
        return self.users[-1]
