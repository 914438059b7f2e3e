"""The far end of a call: a modem by hand, PPP, and a stack with services, as passive code and at a pty."""

import os
import select
import threading
import time
import tty
from collections.abc import Callable
from ipaddress import IPv4Address
from typing import Self

from fieldrig.clock import S
from fieldrig_devices.ip.stack import Stack
from fieldrig_devices.ip.tcp.connection import Connection
from fieldrig_devices.ppp.link import PppLink
from fieldrig_devices.ppp.phases import Phase
from fieldrig_devices.ppp.settings import Login, PppSettings

SERVED = PppSettings(
    demanded=Login.of("service", "secret"),
    local_address=IPv4Address("190.200.100.100"),
    peer_address=IPv4Address("190.200.100.101"),
)
PAGE = b"HTTP/1.0 200 OK\r\nContent-Type: text/plain\r\nContent-Length: 50000\r\n\r\n" + b"0123456789" * 5000


class FarEnd:
    """The modem answers commands with `answers`, and anything else that begins with AT with OK."""

    def __init__(self, transmit: Callable[[bytes], None], answers: dict[bytes, bytes] | None = None) -> None:
        self.transmit = transmit
        self.commands: list[bytes] = []
        self.answers = {b"ATDT4711": b"CONNECT 38400"} if answers is None else answers
        self.is_silent = False
        self.now_ns = 0
        self.is_online = False
        self._line = bytearray()
        self.ppp = PppLink(SERVED, lambda: 0x12345678, transmit, self._on_ip, self._on_phase)
        self.stack: Stack | None = None

    def receive(self, now_ns: int, data: bytes) -> None:
        self.now_ns = now_ns
        if self.is_online and not data.startswith(b"+++"):
            self.ppp.receive(now_ns, data)
            return
        if data.startswith(b"+++"):
            self.is_online = False
            return
        self._line += data
        while b"\r" in self._line:
            command, _, rest = bytes(self._line).partition(b"\r")
            self._line = bytearray(rest)
            self._on_command(command)

    def _on_command(self, command: bytes) -> None:
        self.commands.append(command)
        if self.is_silent or not command:
            return
        answer = self.answers.get(command, b"OK")
        self.transmit(b"\r\n" + answer + b"\r\n")
        if answer.startswith(b"CONNECT"):
            self.is_online = True
            self.ppp.up(self.now_ns)

    def hang_up(self) -> None:
        self.is_online = False
        self.ppp.down(self.now_ns)
        self.transmit(b"\r\nNO CARRIER\r\n")

    def next_ns(self) -> int | None:
        parts = (self.ppp, self.stack)
        return min((due for part in parts if part is not None and (due := part.next_ns()) is not None), default=None)

    def advance(self, now_ns: int) -> None:
        self.now_ns = now_ns
        self.ppp.advance(now_ns)
        if self.stack is not None:
            self.stack.advance(now_ns)

    def _on_ip(self, packet: bytes) -> None:
        if self.stack is not None:
            self.stack.receive(self.now_ns, packet)

    def _on_phase(self, phase: Phase) -> None:
        if phase is Phase.RUNNING:
            self.stack = Stack(
                self.ppp.local_address, self.ppp.mtu, lambda packet: void(self.ppp.send_ip(self.now_ns, packet))
            )
            self.stack.listen(80, serve_page)
            self.stack.listen(7, serve_echo)


def void(_: object) -> None:
    """Return nothing."""


def serve_page(connection: Connection) -> None:
    def on_data(data: bytes) -> None:
        connection.send(PAGE)
        connection.end()

    connection.on_data = on_data


def serve_echo(connection: Connection) -> None:
    connection.on_data, connection.on_end = connection.send, connection.end


class PtyPeer:
    """The far end at a pty, in a thread and in real time."""

    def __init__(self, has_modem: bool = True) -> None:
        """PPP begins at once if there is no modem."""
        self._has_modem = has_modem
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.path = os.ttyname(self._slave)
        self.end = FarEnd(lambda data: void(os.write(self._master, data)))
        self._is_wanted = True
        self._hangs_up = threading.Event()
        self._thread = threading.Thread(target=self._work)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
        os.close(self._master)
        os.close(self._slave)

    def stop(self) -> None:
        """Answer nothing more."""
        self._is_wanted = False
        self._thread.join()

    def hang_up(self) -> None:
        """Lose the carrier."""
        self._hangs_up.set()

    def _work(self) -> None:
        if not self._has_modem:
            self.end.is_online = True
            self.end.ppp.up(time.monotonic_ns())
        while self._is_wanted:
            due_ns = self.end.next_ns()
            wait_s = 0.02 if due_ns is None else min(max(due_ns - time.monotonic_ns(), 0) / S, 0.02)
            if select.select([self._master], [], [], wait_s)[0]:
                self.end.receive(time.monotonic_ns(), os.read(self._master, 4096))
            if self._hangs_up.is_set():
                self._hangs_up.clear()
                self.end.hang_up()
            self.end.advance(time.monotonic_ns())
