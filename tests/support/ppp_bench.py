"""One end of a PPP link on the bench; frames are made and read as RFC 1662 says, not by the code under test."""

from collections.abc import Callable
from functools import partial
from ipaddress import IPv4Address
from itertools import count

from fieldrig.clock import S
from fieldrig_devices.ppp.link import LoginAttempt, PppLink
from fieldrig_devices.ppp.phases import Phase
from fieldrig_devices.ppp.settings import Login, PppSettings

CONTROLLER = IPv4Address("190.200.100.100")
CALLER = IPv4Address("190.200.100.101")
LOGIN = Login(b"lab", b"geheim")
CONTROLLER_END = PppSettings(demanded=LOGIN, local_address=CONTROLLER, peer_address=CALLER)
CALLER_END = PppSettings(own=LOGIN)
POLYNOMIAL = 0x8408


def check_sequence(content: bytes) -> bytes:
    """RFC 1662 C.1: x^16 + x^12 + x^5 + 1, least significant bit first."""
    register = 0xFFFF
    for byte in content:
        register ^= byte
        for _ in range(8):
            register = register >> 1 ^ (POLYNOMIAL if register & 1 else 0)
    return (register ^ 0xFFFF).to_bytes(2, "little")


def framed(text: str) -> bytes:
    """Return the frame of protocol and payload in hex, with every control character escaped."""
    content = bytes.fromhex("ff03" + text)
    line = b""
    for byte in content + check_sequence(content):
        line += bytes((0x7D, byte ^ 0x20)) if byte < 0x20 or byte in (0x7D, 0x7E) else bytes((byte,))
    return b"\x7e" + line + b"\x7e"


def content_of(frame: bytes) -> bytes:
    """Return protocol and payload of a frame between two flags."""
    assert frame[0] == frame[-1] == 0x7E, frame.hex()
    line, content = iter(frame[1:-1]), b""
    for byte in line:
        content += bytes((next(line) ^ 0x20 if byte == 0x7D else byte,))
    assert check_sequence(content[:-2]) == content[-2:], frame.hex()
    content = content[:-2].removeprefix(b"\xff\x03")
    return b"\x00" + content if content[0] & 1 else content


LCP_REQUEST = "0206 00000000 0304 c023 0506 22222222 0702 0802"
"""The controller's first options: asyncmap 0, PAP, a magic number, both compressions of the header."""
PAP_LOGIN = "c023 01 01 000f 03 6c6162 06 67656865696d"


def asked(options: str, identifier: int = 7) -> str:
    """Return a Configure-Request of the peer with these options in hex."""
    return f"c02101{identifier:02x}{4 + len(bytes.fromhex(options)):04x}" + options


def spaced(text: str) -> str:
    """Return hex with spaces as it is without."""
    return bytes.fromhex(text).hex()


class PppBench:
    """One link; the test is its peer.  Magic numbers are 11111111, 22222222 and so on."""

    def __init__(self, settings: PppSettings = CONTROLLER_END) -> None:
        self.now_ns = 0
        self.line: list[bytes] = []
        self.packets: list[bytes] = []
        self.phases: list[Phase] = []
        self.attempts: list[LoginAttempt] = []
        numbers = count(1)
        self.link = PppLink(
            settings,
            lambda: 0x11111111 * (next(numbers) % 15 + 1) & 0xFFFFFFFF,
            self.line.append,
            self.packets.append,
            self.phases.append,
            self.attempts.append,
        )

    def up(self) -> "PppBench":
        self.link.up(self.now_ns)
        return self

    def phase(self) -> Phase:
        return self.link.phase

    def take(self) -> list[str]:
        """Return what was sent since the last call, as protocol and payload in hex."""
        sent = [content_of(frame).hex() for frame in self.line]
        self.line.clear()
        return sent

    def hear(self, *texts: str) -> list[str]:
        """Deliver frames of the peer, protocol and payload in hex, and return what was sent since the last call."""
        for text in texts:
            self.link.receive(self.now_ns, framed(text))
        return self.take()

    def wait_s(self, seconds: float) -> list[str]:
        """Let time pass, and return what was sent since the last call."""
        until_ns = self.now_ns + round(seconds * S)
        while (due_ns := self.link.next_ns()) is not None and due_ns <= until_ns:
            self.now_ns = max(self.now_ns, due_ns)
            self.link.advance(self.now_ns)
        self.now_ns = until_ns
        return self.take()

    # Short ways to a phase, for the controller's end.

    def establish(self) -> "PppBench":
        """Until LCP is open: the peer acknowledges the first request, and asks for nothing but a magic number."""
        self.up()
        (request,) = self.take()
        assert self.hear("c02102" + request[6:], "c021 01 07 000a 0506 aabbccdd") == [
            spaced("c021 02 07 000a 0506 aabbccdd")
        ]
        return self

    def log_in(self) -> "PppBench":
        """Until the login is accepted, and the first IPCP request is out."""
        self.establish()
        request = "0206 002d0f01 0306 bec86464" if self.link.settings.compresses_headers else "0306 bec86464"
        length = 4 + len(bytes.fromhex(request))
        assert self.hear(PAP_LOGIN) == [spaced("c023 02 01 0005 00"), spaced(f"8021 01 01 {length:04x} {request}")]
        return self

    def run(self) -> "PppBench":
        """Until IP packets pass."""
        self.log_in()
        self.hear("8021 02 01 000a 0306 bec86464", "8021 01 01 000a 0306 bec86465")
        assert self.link.phase is Phase.RUNNING
        return self


class Line:
    """Two links, and the line between them, which delays every frame and may change it."""

    DELAY_NS = 20_000_000

    def __init__(
        self, controller: PppSettings, caller: PppSettings, spoil: Callable[[bytes], bytes] = lambda frame: frame
    ) -> None:
        self.now_ns = 0
        self.spoil = spoil
        self.packets: dict[int, list[bytes]] = {0: [], 1: []}
        self._under_way: list[tuple[int, int, bytes]] = []
        magic = count(0x1000)
        self.ends = [
            PppLink(
                settings,
                lambda: next(magic),
                partial(self._send, 1 - end),
                self.packets[end].append,
            )
            for end, settings in enumerate((controller, caller))
        ]

    def _send(self, to: int, frame: bytes) -> None:
        self._under_way.append((self.now_ns + self.DELAY_NS, to, frame))

    @property
    def phases(self) -> list[Phase]:
        return [end.phase for end in self.ends]

    def up(self) -> None:
        for end in self.ends:
            end.up(self.now_ns)

    def pass_s(self, seconds: float) -> None:
        until_ns = self.now_ns + round(seconds * S)
        while True:
            due = [ns for end in self.ends if (ns := end.next_ns()) is not None]
            due += [ns for ns, _, _ in self._under_way[:1]]
            if not due or min(due) > until_ns:
                break
            self.now_ns = max(self.now_ns, min(due))
            for end in self.ends:
                end.advance(self.now_ns)
            while self._under_way and self._under_way[0][0] <= self.now_ns:
                _, to, frame = self._under_way.pop(0)
                self.ends[to].receive(self.now_ns, self.spoil(frame))
        self.now_ns = until_ns
