"""A controller with a modem at COM1 in virtual time: this bench is the modem, and the caller at the other telephone.

The caller's PPP and TCP/IP are ours.  Foreign ones call in tests/real.
"""

from ipaddress import IPv4Address
from typing import Any, Self

from max4_rig import Max4Rig

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig
from fieldrig_bus.serial.message import ControlLines, SerialMessage
from fieldrig_devices.ip.stack import Stack
from fieldrig_devices.ip.tcp.connection import Connection
from fieldrig_devices.ppp.framing import Deframer, FrameFormat, framed, unpacked
from fieldrig_devices.ppp.link import PppLink
from fieldrig_devices.ppp.packets import Code, Packet
from fieldrig_devices.ppp.protocols import ProtocolNumber
from fieldrig_devices.ppp.settings import Login, PppSettings

CONTROLLER = IPv4Address("190.200.100.100")
LOGIN = Login(b"service", b"pacdrive")
MODEM = {"Phone.UserName": "service", "Phone.Password": "pacdrive", "MAx-4.Com1User": 1}


class DialInBench(Max4Rig):
    """The controller has booted and has initialised its modem.  Keywords are settings of the controller."""

    def __init__(self, parameters: dict[str, Any] | None = None, **settings: Any) -> None:
        device = {
            "kind": "max4",
            "links": {"com1": "line", "tcp": "lan"},
            "com1": {"modem": "Phone"},
            "parameters": MODEM | (parameters or {}),
            "drives": {"belt": {"ring_address": 1, "simulated": True}},
            **settings,
        }
        line = {"kind": "serial.virtual", "baud": 38_400}
        buses = {"line": line, "lan": {"kind": "tcp.server"}}
        self.rig = Rig(from_dict({"time": "virtual", "seed": 7, "buses": buses, "devices": {"max4": device}}))
        self.line = self.rig.attach("modem").link("line")
        self.line.on_receive(self._on_line, ("data", "lines"))
        self.commands = b""
        self.dtr = False
        self.is_online = False
        self.link: PppLink | None = None
        self.stack: Stack | None = None
        self.line.send(ControlLines(dcd=False))
        self.run(5000)

    def call(self, settings: PppSettings | None = None) -> Self:
        """Dial in; the modems connect at once."""
        self.is_online = True
        self.line.send(ControlLines(dcd=True))
        self.line.send(b"\r\nCONNECT 38400\r\n")
        self.link = PppLink(settings or PppSettings(own=LOGIN), lambda: 0x12345678, self.line.send, self._on_ip)
        self.run(100)
        if self.is_online:
            self.link.up(self.rig.now_ns)
        return self.go(3000)

    def drop(self) -> Self:
        """The line is lost."""
        self.is_online = False
        self.line.send(ControlLines(dcd=False))
        return self.run(10)

    def go(self, ms: float) -> Self:
        """Let the caller and the controller go on for this time."""
        end_ns = self.rig.now_ns + round(ms * MS)
        while self.rig.now_ns < end_ns:
            self._advance()
            self.run(1)
        return self

    def connect(self, port: int) -> tuple[Connection, bytearray]:
        """Open a TCP connection; return it, and where its bytes arrive."""
        assert self.link is not None
        if self.stack is None:
            self.stack = Stack(self.link.local_address, self.link.mtu, self._send_ip)
        connection = self.stack.connect(CONTROLLER, port)
        arrived = bytearray()
        connection.on_data = arrived.extend
        self.go(500)
        return connection, arrived

    def ask(self, connection: Connection, arrived: bytearray, text: str) -> str:
        """Send a line, and return the answer."""
        arrived.clear()
        connection.send(f"{text}\r\n".encode())
        self.go(500)
        return arrived.decode()

    def page(self, path: str, ms: float = 3000) -> bytes:
        """Fetch a page by HTTP."""
        connection, arrived = self.connect(80)
        connection.send(f"GET {path} HTTP/1.1\r\nHost: 190.200.100.100\r\nConnection: close\r\n\r\n".encode())
        self.go(ms)
        return bytes(arrived)

    def echo_ms(self, limit_ms: int = 30_000) -> int:
        """Send an Echo-Request of LCP, and return the time until its answer, in steps of 10 ms."""
        deframer, request = Deframer(), Packet(Code.ECHO_REQUEST, 77, bytes(4))
        begin_ns, self.answered = self.rig.now_ns, False

        def look(message: SerialMessage) -> None:
            if isinstance(message, bytes):
                for protocol, payload in map(unpacked, deframer.feed(message)):
                    self.answered |= protocol == ProtocolNumber.LCP and payload[:2] == bytes((Code.ECHO_REPLY, 77))
            self._on_line(message)

        self.line.on_receive(look, ("data", "lines"))
        self.line.send(framed(ProtocolNumber.LCP, request.encode(), FrameFormat()))
        while not self.answered and self.rig.now_ns - begin_ns < limit_ms * MS:
            self.go(10)
        self.line.on_receive(self._on_line, ("data", "lines"))
        return (self.rig.now_ns - begin_ns) // MS

    def _advance(self) -> None:
        now_ns = self.rig.now_ns
        if self.stack is not None:
            self.stack.advance(now_ns)
        if self.link is not None:
            self.link.advance(now_ns)

    def _send_ip(self, packet: bytes) -> None:
        assert self.link is not None
        self.link.send_ip(self.rig.now_ns, packet)

    def _on_ip(self, packet: bytes) -> None:
        if self.stack is not None:
            self.stack.receive(self.rig.now_ns, packet)

    def _on_line(self, message: SerialMessage) -> None:
        if isinstance(message, ControlLines):
            self._on_dtr(message.dtr)
        elif isinstance(message, bytes) and self.is_online:
            assert self.link is not None
            self.link.receive(self.rig.now_ns, message)
        elif isinstance(message, bytes):
            self.commands += message
            if message.endswith(b"\r"):
                self.line.send(b"\r\nOK\r\n")

    def _on_dtr(self, is_on: bool) -> None:
        self.dtr = is_on
        if not is_on and self.is_online:  # &D2: the modem hangs up
            self.is_online = False
            self.line.send(ControlLines(dcd=False))
            if self.link is not None:
                self.link.down(self.rig.now_ns)
