"""pppd of Linux at the other end of a link, on a pty, in real time; only inside user-mode Linux, as root."""

import os
import pty
import random
import select
import socket
import struct
import subprocess
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from fieldrig_devices.ppp.link import LoginAttempt, PppLink
from fieldrig_devices.ppp.phases import Phase
from fieldrig_devices.ppp.settings import PppSettings

LIMIT_S = 60
SECRETS = Path("/etc/ppp/pap-secrets")
COMMON = ("38400", "local", "nodetach", "nocrtscts", "noipdefault", "+ipv6", "debug")
"""IPv6, CCP and VJ compression are what pppd asks for beyond IP, and our end refuses."""
ECHO_REQUEST, ECHO_REPLY = 8, 0
ICMP = 1


def is_in_guest() -> bool:
    processors = Path("/proc/cpuinfo")
    return processors.exists() and "User Mode Linux" in processors.read_text(encoding="utf-8")


def internet_checksum(data: bytes) -> int:
    """RFC 1071."""
    total: int = sum(struct.unpack(f">{(len(data) + 1) // 2}H", data + bytes(len(data) % 2)))
    while total >> 16:
        total = (total & 0xFFFF) + (total >> 16)
    return total ^ 0xFFFF


def echo_message(kind: int, data: bytes) -> bytes:
    """Return an ICMP echo message (RFC 792); `data` begins with identifier and sequence number."""
    checksum = internet_checksum(bytes((kind, 0, 0, 0)) + data)
    return struct.pack(">BBH", kind, 0, checksum) + data


def ip_packet(source: bytes, destination: bytes, payload: bytes) -> bytes:
    header = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(payload), 0, 0, 64, ICMP, 0, source, destination)
    return header[:10] + internet_checksum(header).to_bytes(2, "big") + header[12:] + payload


class PppdLink:
    """One end of ours; it answers pings."""

    def __init__(self, settings: PppSettings, master: int, slave: int, log: Path) -> None:
        self._master, self._slave, self._log = master, slave, log
        self.attempts: list[LoginAttempt] = []
        self.phases: list[Phase] = []
        self.replies: list[bytes] = []
        """The data of the echo replies from the kernel."""
        self.link = PppLink(
            settings,
            lambda: random.getrandbits(32),
            self._write,
            self._on_ip,
            self.phases.append,
            self.attempts.append,
        )
        self.link.up(time.monotonic_ns())
        self.exit_code: Callable[[], int | None] = lambda: None
        self.terminate: Callable[[], None] = lambda: None
        self._is_line_there = True

    def output(self) -> str:
        """Return what pppd has written, with its packets in words."""
        return self._log.read_text()

    def run_until(self, is_done: Callable[[], bool]) -> None:
        """Serve the line until `is_done`.  AssertionError after the limit, with what pppd has written."""
        end_ns = time.monotonic_ns() + LIMIT_S * 1_000_000_000
        while not is_done():
            now_ns = time.monotonic_ns()
            assert now_ns < end_ns, f"{self.link.phase}, {self.link.ended_by}\n{self.output()}"
            self.link.advance(now_ns)
            if select.select([self._master] if self._is_line_there else [], [], [], 0.05)[0]:
                self._read()

    def run_until_end(self) -> int:
        """Serve the line until pppd has ended, and return its exit code."""
        self.run_until(lambda: self.exit_code() is not None)
        return self.exit_code() or 0

    def ping(self, data: bytes) -> None:
        """Send an echo request to the kernel."""
        now_ns, link = time.monotonic_ns(), self.link
        message = echo_message(ECHO_REQUEST, data)
        assert link.send_ip(now_ns, ip_packet(link.local_address.packed, link.peer_address.packed, message))

    def _read(self) -> None:
        try:
            data = os.read(self._master, 65536)
        except OSError:
            data = b""  # pppd has closed its end
        if data:
            self._let_go_of_slave()
            self.link.receive(time.monotonic_ns(), data)
        else:
            self._is_line_there = False
            self.link.down(time.monotonic_ns())

    def _let_go_of_slave(self) -> None:
        """Leave the slave to pppd alone, which has opened it now, so that its end is the end of the line."""
        if self._slave >= 0:
            os.close(self._slave)
            self._slave = -1

    def hang_up(self) -> None:
        """End the line, as a modem does when its terminal is no longer ready."""
        if self._master >= 0:
            self._let_go_of_slave()
            os.close(self._master)
            self._master, self._is_line_there = -1, False

    def _write(self, data: bytes) -> None:
        while data:
            data = data[os.write(self._master, data) :]

    def _on_ip(self, packet: bytes) -> None:
        source, destination, message = packet[12:16], packet[16:20], packet[20:]
        if packet[0] != 0x45 or packet[9] != ICMP:
            return  # the kernel's own messages
        if message[0] == ECHO_REPLY:
            self.replies.append(message[4:])
        elif message[0] == ECHO_REQUEST:
            answer = ip_packet(destination, source, echo_message(ECHO_REPLY, message[4:]))
            self.link.send_ip(time.monotonic_ns(), answer)


@contextmanager
def pppd_on_pty(settings: PppSettings, folder: Path, *options: str) -> Iterator[PppdLink]:
    """Start pppd with `COMMON` and these options, and our end with `settings`; both have ended afterwards."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    log = folder / "pppd.log"
    command = ["pppd", os.ttyname(slave), *COMMON, *options]
    with log.open("w") as output, subprocess.Popen(command, stdout=output, stderr=output) as process:
        line = PppdLink(settings, master, slave, log)
        line.exit_code, line.terminate = process.poll, process.terminate
        try:
            yield line
        finally:
            line.hang_up()
            process.kill()


@contextmanager
def ping_socket(address: str) -> Iterator[socket.socket]:
    """A raw socket of the kernel that sends echo requests to `address` and receives its replies."""
    with socket.socket(socket.AF_INET, socket.SOCK_RAW, socket.IPPROTO_ICMP) as raw:
        raw.setblocking(False)
        raw.connect((address, 0))
        yield raw


def reply_in(raw: socket.socket) -> bytes | None:
    """Return the data of an echo reply that has come, or None without one."""
    try:
        packet = raw.recv(65536)
    except BlockingIOError:
        return None
    return packet[24:] if packet[20] == ECHO_REPLY else None
