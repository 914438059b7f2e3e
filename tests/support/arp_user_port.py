"""An ARP card with a tester at its USER port: frames by hand, or the client, in virtual time.

The frames are built here independently of the code, from RFC 1662 and docs/devices/arp/arp-user-port.md.
"""

import struct
import zlib
from collections.abc import Callable
from typing import Any

from arp_bench import CardBench, Groups, whole

from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.arp.language.files import encode as encoded_object
from fieldrig_devices.arp.user_port.client import ArpPort
from fieldrig_devices.arp.user_port.line import CardLine


def fcs(data: bytes) -> bytes:
    """CRC-16 of ITU-T X.25 bit by bit, as RFC 1662 sends it."""
    register = 0xFFFF
    for octet in data:
        for place in range(8):
            is_one = (register ^ octet >> place) & 1
            register = register >> 1 ^ (0x8408 if is_one else 0)
    return struct.pack("<H", register ^ 0xFFFF)


def frame(body: bytes) -> bytes:
    stuffed = bytearray()
    for octet in body + fcs(body):
        stuffed += bytes((0x7D, octet ^ 0x20)) if octet in (0x7D, 0x7E) else bytes((octet,))
    return b"~" + bytes(stuffed) + b"~"


def bodies(wire: bytes) -> list[bytes]:
    """Bodies of frames that must all be valid."""
    found = []
    for part in wire.split(b"~"):
        if part:
            octets, rest = bytearray(), iter(part)
            for octet in rest:
                octets.append(next(rest) ^ 0x20 if octet == 0x7D else octet)
            assert fcs(bytes(octets[:-2])) == octets[-2:], part.hex(" ")
            found.append(bytes(octets[:-2]))
    return found


def an_object(source: str, number: int = 1, name: str = "TEST") -> bytes:
    """`source` is a whole program, or the instructions of a main program alone."""
    return encoded_object(compile_text(whole(source)), name, number)


class PortBench(CardBench):
    """Card 01 with a control loop of 1 ms and a recorded USER port, half a second after power-on."""

    def __init__(
        self, program: str = "", *, is_enabled: bool = False, parameters: Groups | None = None, **settings: Any
    ) -> None:
        super().__init__(program, parameters, is_enabled=is_enabled, with_can=False, **settings)
        self.sequence = 0
        self.run_for(500)
        self.user.take()

    def enable(self, is_closed: bool = True) -> "PortBench":
        self.drive("I108", is_closed)
        self.run_for(25)
        return self

    def heard(self) -> list[bytes]:
        """The bodies that the card has sent since the last call."""
        return bodies(b"".join(sent for sent in self.user.take() if isinstance(sent, bytes)))

    def send(self, command: int, data: bytes = b"", number: int = 1, sequence: int | None = None) -> list[bytes]:
        """Send a request, and return the bodies that the card sends at once."""
        if sequence is None:
            sequence = self.sequence = self.sequence % 255 + 1
        self.user.deliver(frame(bytes((1, number, sequence, command)) + data))
        return self.heard()

    def ask(self, command: int, data: bytes = b"") -> tuple[int, bytes]:
        """Status and data of a single answer."""
        [answer] = self.send(command, data)
        assert answer[:4] == bytes((1, 1, self.sequence, command | 0x80)), answer.hex(" ")
        return answer[4], answer[5:]

    def ok(self, command: int, data: bytes = b"") -> bytes:
        status, answered = self.ask(command, data)
        assert status == 0, (status, answered)
        return answered

    def condition(self) -> tuple[int, ...]:
        """State, program, error, its axis, warning, line, and number of breakpoints."""
        return struct.unpack("<BBHBHIB", self.ok(0x02))

    def downloaded(self, data: bytes) -> tuple[int, bytes]:
        """Status and text of the last answer."""
        self.ok(0x30, struct.pack("<II", len(data), zlib.crc32(data)))
        for offset in range(0, len(data), 240):
            self.ok(0x31, struct.pack("<I", offset) + data[offset : offset + 240])
        return self.commit()

    def commit(self, data: bytes = b"") -> tuple[int, bytes]:
        """Status and text of the answer to COMMIT, which the card gives when it has compiled the program."""
        answers = self.send(0x32, data)
        while not (found := [body for body in answers if body[3] == 0xB2]):
            self.run_for(1)
            answers = self.heard()
        [answer] = found
        assert answer[:3] == bytes((1, 1, self.sequence)), answer.hex(" ")
        return answer[4], answer[5:]


class BenchLine:
    """The PC's end of the line with the interface of pyserial; each empty read advances the card's time by `step_ms`.

    `spoil` receives the data sent in either direction, and returns the data that arrive.
    """

    port = "the bench"

    def __init__(self, bench: PortBench, spoil: Callable[[bytes], bytes], step_ms: float) -> None:
        self.bench, self._spoil, self._step_ms = bench, spoil, step_ms
        self._arrived = b""

    def write(self, data: bytes) -> None:
        self.bench.user.deliver(self._spoil(data))

    def read(self, size: int) -> bytes:
        if not self._arrived:
            self.bench.run_for(self._step_ms)
            sent = (data for data in self.bench.user.take() if isinstance(data, bytes))
            self._arrived = b"".join(map(self._spoil, sent))
        taken, self._arrived = self._arrived[:size], self._arrived[size:]
        return taken

    @property
    def in_waiting(self) -> int:
        return len(self._arrived)

    def close(self) -> None:
        pass


def client(
    bench: PortBench,
    spoil: Callable[[bytes], bytes] = lambda wire: wire,
    step_ms: float = 1.0,
    timeout_s: float = 5.0,
    retries: int = 3,
) -> ArpPort:
    found = ArpPort(CardLine(BenchLine(bench, spoil, step_ms), timeout_s, retries))
    found.hello()
    return found
