"""A link whose IP ends in a kernel: here a stack of ours plays the kernel at the other end of the relay."""

from collections.abc import Callable
from ipaddress import IPv4Address

import pytest
from ip_line import CALLER, CONTROLLER

from fieldrig_bus.ip.channel import Channel
from fieldrig_bus.ip.message import Closed, IpPacket, LinkDown, LinkUp, Opened, Portion, RelayMessage
from fieldrig_devices.ip.fragments import fragments_of
from fieldrig_devices.ip.ipv4 import Packet, Protocol
from fieldrig_devices.ip.kernel_end import MOST_WAITING, Accepted, KernelEnd
from fieldrig_devices.ip.stack import FIRST_OWN_PORT, Stack
from fieldrig_devices.ip.tcp.connection import Connection, Ending

STRANGER = IPv4Address("10.0.0.1")
ECHO_REQUEST = bytes.fromhex("0800 f7ff 0000 0000")


class Bench:
    """The end in the device, its caller, and everything that it sends to the relay."""

    def __init__(self) -> None:
        self.sent: list[RelayMessage] = []
        self.line: list[bytes] = []
        self.waiting = 0
        self.accepted: list[Accepted] = []
        self.caller = Stack(CALLER, 1500, lambda packet: self.end.receive(0, packet))
        own = Stack(CONTROLLER, 1500, self.to_caller)
        self.end = KernelEnd("plc", own, CALLER, 1500, self.sent.append, self.to_caller, lambda: self.waiting)
        self.end.listen(80, self.accepted.append)
        self.end.begin()

    def to_caller(self, packet: bytes) -> None:
        self.line.append(packet)
        self.caller.receive(0, packet)

    def connect(self, port: int) -> tuple[Connection, list[Ending]]:
        connection = self.caller.connect(CONTROLLER, port)
        endings: list[Ending] = []
        connection.on_close = endings.append
        self.caller.advance(0)
        return connection, endings

    def open(self, port: int = 80) -> Channel:
        """The kernel has accepted a connection, and tells the device."""
        kernel = Channel("ip:kernel", 1, False, self.end.take)
        self.sent.clear()
        self.end.take(Opened("ip:kernel", 1, port))
        return kernel

    def pass_on(self, kernel: Channel) -> None:
        for message in self.sent:
            kernel.take(message)  # type: ignore[arg-type]
        self.sent.clear()


def ping(source: IPv4Address = CALLER, destination: IPv4Address = CONTROLLER) -> bytes:
    return Packet(source, destination, Protocol.ICMP, ECHO_REQUEST, 1).encode()


def test_the_kernel_gets_the_link_with_its_ports_and_later_ones() -> None:
    bench = Bench()
    bench.end.listen(502, bench.accepted.append)
    links = [message for message in bench.sent if isinstance(message, LinkUp)]
    assert links == [LinkUp("plc", CONTROLLER, CALLER, 1500, (80,)), LinkUp("plc", CONTROLLER, CALLER, 1500, (80, 502))]


def test_pings_and_segments_to_a_service_go_to_the_kernel() -> None:
    bench = Bench()
    bench.end.receive(0, ping())
    bench.connect(80)
    packets = [message.data for message in bench.sent if isinstance(message, IpPacket)]
    assert [Packet.decode(packet).protocol for packet in packets] == [Protocol.ICMP, Protocol.TCP]
    assert bench.line == []


def test_fragments_go_to_the_kernel_which_puts_them_together() -> None:
    bench = Bench()
    parts = [part.encode() for part in fragments_of(Packet(CALLER, CONTROLLER, Protocol.ICMP, bytes(3000)), 1500)]
    for part in parts:
        bench.end.receive(0, part)
    assert [message.data for message in bench.sent if isinstance(message, IpPacket)] == parts


@pytest.mark.parametrize("own_port", [FIRST_OWN_PORT, 80])
def test_a_connection_that_the_device_opens_is_one_of_our_own_stack(
    own_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """FTP in active mode; its own port may even be one at which the kernel listens."""
    monkeypatch.setattr("fieldrig_devices.ip.stack.FIRST_OWN_PORT", own_port - 1)
    bench, arrived = Bench(), bytearray()
    bench.sent.clear()

    def accept(connection: Connection) -> None:
        connection.on_data = arrived.extend

    bench.caller.listen(5000, accept)
    connection = bench.end.connect(CALLER, 5000)
    assert connection.key.local_port == own_port
    connection.send(b"data")
    bench.end.advance(0)
    bench.caller.advance(0)
    assert (bytes(arrived), bench.sent) == (b"data", [])


@pytest.mark.parametrize(
    "packet",
    [
        ping(destination=STRANGER),
        ping(source=STRANGER),
        b"",
        b"\x45" * 20,
        b"\x60" + bytes(50),
    ],
    ids=["to another", "from another", "empty", "damaged", "IPv6"],
)
def test_nothing_else_reaches_the_kernel(packet: bytes) -> None:
    bench = Bench()
    bench.sent.clear()
    bench.end.receive(0, packet)
    assert bench.sent == []


def test_a_port_without_a_service_is_refused_by_our_own_stack() -> None:
    bench = Bench()
    _, endings = bench.connect(22)
    assert endings == [Ending.REFUSED]
    assert not any(isinstance(message, IpPacket) for message in bench.sent)


def test_a_service_talks_to_the_client_of_the_kernel() -> None:
    bench = Bench()
    kernel = bench.open()
    (connection,) = bench.accepted
    assert (connection.key.local_port, connection.key.remote_address, connection.is_open) == (80, CALLER, True)
    heard, arrived = bytearray(), bytearray()
    connection.on_data, kernel.on_data = heard.extend, arrived.extend
    kernel.send(b"GET")
    connection.send(b"page")
    connection.close()
    bench.pass_on(kernel)
    kernel.send(b"ignored")
    kernel.end()
    assert (bytes(heard), bytes(arrived), connection.is_open, connection.is_complete) == (b"GET", b"page", False, True)


def test_an_unknown_port_is_closed() -> None:
    bench = Bench()
    bench.open(81)
    assert [type(message) for message in bench.sent] == [Closed]


def test_packets_of_the_kernel_are_dropped_while_the_line_has_enough() -> None:
    bench = Bench()
    packet = ping(CONTROLLER, CALLER)
    for waiting in (0, MOST_WAITING):
        bench.waiting = waiting
        bench.end.take(IpPacket("plc", True, packet))
    assert bench.line[:1] == [packet]
    assert len(bench.line) == 1


def lost(bench: Bench, lose: Callable[[], None]) -> list[str]:
    bench.open()
    reasons: list[str] = []
    bench.accepted[0].on_close = reasons.append
    lose()
    return reasons


def test_a_lost_link_ends_the_connections() -> None:
    bench = Bench()
    assert lost(bench, lambda: bench.end.link_down(0)) == ["the link is gone"]
    assert LinkDown("plc", False, "the link is gone") in bench.sent
    bench.sent.clear()
    bench.end.receive(0, ping())
    bench.end.take(Portion("ip:kernel", 1, False, b"late"))
    assert bench.sent == []


def test_our_own_stack_goes_on_when_the_kernel_gives_up(caplog: pytest.LogCaptureFixture) -> None:
    bench = Bench()
    assert lost(bench, lambda: bench.end.take(LinkDown("plc", True, "Address already in use"))) == [
        "Address already in use"
    ]
    assert "own stack: Address already in use" in caplog.text
    _, endings = bench.connect(80)
    assert endings == []
    assert len(bench.accepted) == 2
    bench.end.receive(0, ping())
    assert len(bench.line) > 1
