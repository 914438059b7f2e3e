"""The stack as a host: RFC 1122, and the calls of its user."""

import struct
from ipaddress import IPv4Address

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ip_line import CALLER, CONTROLLER, PORT, Line, Peer, User

from fieldrig.clock import S
from fieldrig_devices.ip.checksum import checksum
from fieldrig_devices.ip.ipv4 import Packet, Protocol, pseudo_header
from fieldrig_devices.ip.stack import MOST_CONNECTIONS, MOST_HALF_OPEN, Stack
from fieldrig_devices.ip.tcp.connection import Connection
from fieldrig_devices.ip.tcp.segment import ACK, FIN, SYN, Flags, Segment

# An echo of Linux 6.1 in its packet, and what Linux answered but for the identification.
ECHO = bytes.fromhex("450000241beb40004001d893bec86465bec864640800b64435aa00010001020304050607")
# A datagram of Linux 6.1 to port 53.
UDP = bytes.fromhex("450000219a794000401159f8bec86465bec8646481ca0035000df3a768656c6c6f")
SYN_TO_ITSELF = Packet(
    CONTROLLER, CONTROLLER, 6, Segment(PORT, PORT, 1, 0, SYN, 1000).encode(CONTROLLER, CONTROLLER)
).encode()


def answers(packet: bytes, mtu: int = 1500) -> list[Packet]:
    sent: list[bytes] = []
    Stack(CONTROLLER, mtu, sent.append).receive(0, packet)
    return [Packet.decode(data) for data in sent]


def test_an_echo_is_answered() -> None:
    (answer,) = answers(ECHO)
    assert (answer.source, answer.destination, answer.protocol) == (CONTROLLER, CALLER, 1)
    assert answer.payload.hex() == "0000be4435aa00010001020304050607"


def test_a_datagram_is_refused() -> None:
    (answer,) = answers(UDP)
    assert answer.payload[:2].hex() == "0303"  # port unreachable
    assert answer.payload[8:] == UDP[:28]


def test_an_unknown_protocol_is_refused() -> None:
    (answer,) = answers(Packet(CALLER, CONTROLLER, 132, b"12345678").encode())
    assert answer.payload[:2].hex() == "0302"


@pytest.mark.parametrize(
    "packet",
    [
        Packet(CALLER, IPv4Address("190.200.100.99"), 17, b"").encode(),
        Packet(IPv4Address("224.0.0.1"), CONTROLLER, 1, ECHO[20:]).encode(),
        Packet(IPv4Address("0.0.0.0"), CONTROLLER, 6, bytes(20)).encode(),
        ECHO[:-1],
        b"",
        bytes(2000),
    ],
)
def test_everything_else_is_dropped(packet: bytes) -> None:
    assert answers(packet) == []


@pytest.mark.parametrize(("mtu", "window"), [(67, 1000), (65_536, 1000), (1500, 0), (1500, 65_536)])
def test_impossible_numbers_are_refused(mtu: int, window: int) -> None:
    with pytest.raises(ValueError, match="expected"):
        Stack(CONTROLLER, mtu, lambda packet: None, window=window)


@pytest.mark.parametrize("packet", [SYN_TO_ITSELF, Packet(CONTROLLER, CONTROLLER, 1, ECHO[20:]).encode()])
def test_a_packet_from_the_own_address_is_dropped(packet: bytes) -> None:
    """RFC 1122, 3.2.1.3; the host must not answer itself."""
    peer = Peer()
    peer.stack.receive(0, packet)
    assert (peer.take(), peer.others, peer.stack.connections, peer.stack.dropped) == ([], [], [], 1)


@pytest.mark.parametrize("flags", [0x00, 0x01, 0x08, 0x29, 0x3F & ~0x16])
def test_a_listener_drops_a_segment_without_syn_ack_and_rst(flags: int) -> None:
    """RFC 9293, 3.10.7.2: no answer tells a scanner whether the port is open."""
    peer = Peer()
    header = struct.pack("!HHIIBBHHH", 1000, PORT, 1, 0, 0x50, flags, 1000, 0, 0)
    covered = pseudo_header(CALLER, CONTROLLER, 6, len(header)) + header
    peer.packet(6, header[:16] + struct.pack("!HH", checksum(covered), 0))
    assert (peer.take(), peer.stack.connections, peer.stack.dropped) == ([], [], 0)


def open_connections(peer: Peer, count: int) -> None:
    for port in range(2000, 2000 + count):
        peer.give(Segment(port, PORT, 1, 0, SYN, 1000))
        (answer,) = peer.take()
        peer.give(Segment(port, PORT, 2, answer.sequence + 1, ACK, 1000))


def test_the_number_of_connections_is_limited() -> None:
    peer = Peer()
    open_connections(peer, MOST_CONNECTIONS)
    peer.give(Segment(1999, PORT, 1, 0, SYN, 1000))
    assert (peer.take(), len(peer.stack.connections)) == ([], MOST_CONNECTIONS)
    assert peer.limits == ["connections over the limit: 256 connections are open"]


def test_half_open_connections_of_one_peer_lock_no_other_out() -> None:
    peer = Peer()
    other = IPv4Address("190.200.100.7")
    syn = Segment(1000, PORT, 1, 0, SYN, 1000)
    peer.stack.receive(0, Packet(other, CONTROLLER, 6, syn.encode(other, CONTROLLER)).encode())
    theirs = peer.take()[0].sequence
    for port in range(2000, 2000 + 2 * MOST_CONNECTIONS):
        peer.give(Segment(port, PORT, 1, 0, SYN, 1000))
    assert len(peer.stack.connections) == MOST_HALF_OPEN
    assert set(peer.limits) == {"connections over the limit: 64 connections are half open; the oldest is given up"}
    ack = Segment(1000, PORT, 2, theirs + 1, ACK, 1000)
    peer.stack.receive(0, Packet(other, CONTROLLER, 6, ack.encode(other, CONTROLLER)).encode())
    assert [user.connection.key.remote_address for user in peer.users] == [other]
    peer.take()
    assert peer.connect() is peer.users[-1], "the peer itself gets a further connection as well"


def test_an_old_connection_in_time_wait_makes_room() -> None:
    peer = Peer()
    user = peer.connect()
    user.connection.end()
    peer.act()
    peer.send(ACK | FIN, 101, peer.theirs + 2)
    peer.take()
    open_connections(peer, MOST_CONNECTIONS)
    assert len(peer.stack.connections) == MOST_CONNECTIONS
    assert user.connection not in peer.stack.connections


def test_initial_numbers_differ_by_ends_secret_and_time() -> None:
    numbers = set()
    for now_ns, secret, port in [(0, b"", 1), (4_000, b"", 1), (0, b"x", 1), (0, b"", 2)]:
        sent: list[bytes] = []
        stack = Stack(CALLER, 1500, sent.append, secret=secret)
        stack.advance(now_ns)
        stack.connect(CONTROLLER, port)
        stack.advance(now_ns)
        numbers.add(sent[0][24:28])
    assert len(numbers) == 4


def test_a_call_outside_of_a_handler_is_due_at_once() -> None:
    line = Line()
    caller, _ = line.connected()
    line.run_for(10)
    assert line.caller.next_ns() is None
    caller.connection.send(b"x")
    due_ns = line.caller.next_ns()
    assert due_ns is not None
    assert due_ns <= line.now_ns


def test_a_transmit_that_delivers_at_once_is_no_recursion() -> None:
    """Two stacks may be connected directly: packets wait until the present one is handled."""
    here: Stack
    there: Stack
    here = Stack(CALLER, 1500, lambda packet: there.receive(0, packet))
    there = Stack(CONTROLLER, 1500, lambda packet: here.receive(0, packet))
    accepted: list[User] = []
    there.listen(PORT, lambda connection: accepted.append(User(connection)))
    user = User(here.connect(CONTROLLER, PORT))
    user.connection.send(bytes(100_000))
    here.advance(0)
    there.advance(1_000_000_000)
    assert len(accepted[0].received) == 100_000


@settings(deadline=None)
@given(st.lists(st.one_of(st.binary(max_size=80), st.binary(max_size=60).map(
    lambda data: Packet(CALLER, CONTROLLER, 6, data).encode())), max_size=20))  # fmt: skip
def test_arbitrary_packets_do_not_raise(packets: list[bytes]) -> None:
    peer = Peer()
    peer.connect()
    for packet in packets:
        peer.stack.receive(peer.now_ns, packet)
        peer.wait(1)


@pytest.mark.long
@settings(deadline=None, max_examples=200)
@given(
    st.lists(
        st.tuples(
            st.sampled_from([1000, 1001]),
            st.integers(-3, 3) | st.integers(0, 2**32 - 1),
            st.integers(-3, 3) | st.integers(0, 2**32 - 1),
            st.integers(0, 31),
            st.sampled_from([0, 1, 8192, 65535]),
            st.binary(max_size=3),
            st.sampled_from(["", "send", "end", "close", "pause", "resume", "abort"]),
        ),
        max_size=30,
    )
)
def test_arbitrary_segments_in_any_state_do_not_raise(
    steps: list[tuple[int, int, int, int, int, bytes, str]],
) -> None:
    peer = Peer()
    user = peer.connect()
    for port, sequence, acknowledgment, flags, window, data, action in steps:
        if action == "send":
            user.connection.send(b"12345")
        elif action:
            getattr(user.connection, action)()
        numbers = (101 + sequence) % 2**32, (peer.theirs + 1 + acknowledgment) % 2**32
        peer.give(Segment(port, PORT, *numbers, Flags(flags), window, data))
        peer.wait(0.3)
    peer.wait(2000)
    assert peer.stack.next_ns() is None or peer.stack.connections


class SlowLink:
    """A link that takes a packet whenever it is empty, and is emptied by hand."""

    def __init__(self) -> None:
        self.is_empty = True
        self.packets: list[Packet] = []
        self.stack = Stack(CONTROLLER, 1040, self._take, has_room=lambda: self.is_empty)
        self.connections: dict[int, Connection] = {}
        self.stack.listen(PORT, self._accept)

    def _take(self, data: bytes) -> None:
        self.packets.append(Packet.decode(data))
        self.is_empty &= len(data) <= 44  # SYN and ACK have room

    def _accept(self, connection: Connection) -> None:
        self.connections[connection.key.remote_port] = connection

    def give(self, now_ns: int, segment: Segment) -> None:
        packet = Packet(CALLER, CONTROLLER, Protocol.TCP, segment.encode(CALLER, CONTROLLER)).encode()
        self.stack.receive(now_ns, packet)

    def open(self, port: int) -> None:
        self.give(0, Segment(port, PORT, 1, 0, SYN, 60_000, b"", 1000))
        self.give(0, Segment(port, PORT, 2, self.segments()[-1].sequence + 1, ACK, 60_000))

    def segments(self) -> list[Segment]:
        packets, self.packets = self.packets, []
        return [Segment.decode(packet.payload, packet.source, packet.destination) for packet in packets]

    def empty(self, now_ns: int) -> list[int]:
        """Let the link transmit what it has, and return the ports of the segments that follow."""
        self.is_empty = True
        self.stack.advance(now_ns)
        return [segment.destination_port for segment in self.segments()]


def test_data_wait_for_room_on_the_link_and_connections_take_turns() -> None:
    link = SlowLink()
    for port in (1000, 1001, 1002):
        link.open(port)
    for connection in link.connections.values():
        connection.send(bytes(3000))
    assert link.empty(0) == [1000]
    assert [link.empty(0) for _ in range(6)] == [[1000], [1001], [1002], [1000], [1001], [1002]]


def test_data_that_wait_for_room_are_neither_repeated_nor_probed_for() -> None:
    link = SlowLink()
    link.open(1000)
    link.is_empty = False
    link.connections[1000].send(bytes(3000))
    link.stack.advance(0)
    for second in range(1, 100):
        link.stack.advance(second * S)
    assert link.segments() == []
    assert link.stack.next_ns() is None
    assert link.empty(100 * S) == [1000]


def test_a_lost_segment_is_repeated_when_the_link_has_room() -> None:
    link = SlowLink()
    link.open(1000)
    link.connections[1000].send(bytes(1000))
    assert link.empty(0) == [1000]
    link.stack.advance(1 * S)  # the link is still busy
    assert link.segments() == []
    assert link.empty(1 * S) == [1000]
