"""The stack opposite Linux, over a TUN device in a network namespace: a program that runs one scene.

    unshare -Urn python tests/support/tun_kernel.py SCENE LOSS

The kernel is the caller, 190.200.100.101, and the stack is the controller.  The program prints what the scene found.
"""

import fcntl
import os
import select
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from ipaddress import IPv4Address
from random import Random

from fieldrig_devices.ip.stack import Stack
from fieldrig_devices.ip.tcp.connection import Connection, Ending

CALLER, CONTROLLER = "190.200.100.101", "190.200.100.100"
PORT = 80
DATA = bytes((place * 7 + place // 251) & 0xFF for place in range(1_000_000))
TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454CA, 0x0001, 0x1000


def say(line: str) -> None:
    sys.stdout.write(f"{line}\n")


def open_tun() -> int:
    tun = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(tun, TUNSETIFF, struct.pack("16sH", b"tun0", IFF_TUN | IFF_NO_PI))
    for command in (f"addr add {CALLER} peer {CONTROLLER} dev tun0", "link set tun0 mtu 1500 up", "link set lo up"):
        subprocess.run(["ip", *command.split()], check=True)
    return tun


class Bench:
    """The stack, driven by the time of the system until the scene is over."""

    def __init__(self, lost: float) -> None:
        self.tun, self._lost, self._random = open_tun(), lost, Random(1)
        self.stack = Stack(IPv4Address(CONTROLLER), 1500, self._transmit)

    def _transmit(self, packet: bytes) -> None:
        if self._random.random() >= self._lost:
            os.write(self.tun, packet)

    def run(self, scene: Callable[[], None]) -> None:
        thread = threading.Thread(target=scene)
        thread.start()
        while thread.is_alive() or any(connection.ending is None for connection in self.stack.connections):
            due_ns = self.stack.next_ns()
            wait_s = 0.02 if due_ns is None else min(max(due_ns - time.monotonic_ns(), 0) / 1e9, 0.02)
            if select.select([self.tun], [], [], wait_s)[0]:
                self._receive_all()
            self.stack.advance(time.monotonic_ns())
        thread.join()

    def _receive_all(self) -> None:
        while True:
            try:
                packet = os.read(self.tun, 2000)
            except BlockingIOError:
                return
            if self._random.random() >= self._lost:
                self.stack.receive(time.monotonic_ns(), packet)


def received(connection: socket.socket) -> bytes:
    found = bytearray()
    while chunk := connection.recv(65536):
        found += chunk
    return bytes(found)


def judge(found: bytes) -> str:
    return "all of it" if found == DATA else f"{len(found)} bytes, which differ"


def download(bench: Bench) -> None:
    """The kernel's client asks, and the stack sends and ends."""

    def accept(connection: Connection) -> None:
        def on_data(data: bytes) -> None:
            connection.send(DATA)
            connection.close()

        connection.on_data = on_data

    def client() -> None:
        with socket.create_connection((CONTROLLER, PORT)) as connection:
            connection.sendall(b"GET")
            say(judge(received(connection)))

    bench.stack.listen(PORT, accept)
    bench.run(client)


def upload(bench: Bench) -> None:
    """The kernel's client sends and ends, and the stack answers with its judgement."""

    def accept(connection: Connection) -> None:
        found = bytearray()

        def on_end() -> None:
            connection.send(judge(bytes(found)).encode())
            connection.end()

        connection.on_data, connection.on_end = found.extend, on_end

    def client() -> None:
        with socket.create_connection((CONTROLLER, PORT)) as connection:
            connection.sendall(DATA)
            connection.shutdown(socket.SHUT_WR)
            say(received(connection).decode())

    bench.stack.listen(PORT, accept)
    bench.run(client)


def dial_out(bench: Bench) -> None:
    """The stack connects to the kernel's server, which sends everything back."""
    listener = socket.create_server((CALLER, PORT))

    def server() -> None:
        connection, _ = listener.accept()
        with connection:
            found = bytearray()
            while chunk := connection.recv(65536):
                found += chunk
            connection.sendall(found)

    connection = bench.stack.connect(IPv4Address(CALLER), PORT)
    found = bytearray()
    connection.on_data = found.extend
    connection.on_close = lambda ending: say(judge(bytes(found)) if ending is Ending.COMPLETE else ending.value)
    connection.send(DATA)
    connection.end()
    bench.run(server)


def refused(bench: Bench) -> None:
    """Neither side has a listener."""

    def client() -> None:
        try:
            socket.create_connection((CONTROLLER, PORT)).close()
        except ConnectionRefusedError:
            say("the stack refuses")

    bench.stack.connect(IPv4Address(CALLER), PORT).on_close = lambda ending: say(ending.value)
    bench.run(client)


def reset(bench: Bench) -> None:
    """The kernel's client closes with unread data, so it resets."""
    endings: list[Ending] = []

    def accept(connection: Connection) -> None:
        connection.on_close = endings.append
        connection.send(bytes(1000))

    def client() -> None:
        connection = socket.create_connection((CONTROLLER, PORT))
        connection.recv(1)
        connection.close()

    bench.stack.listen(PORT, accept)
    bench.run(client)
    say(" ".join(ending.value for ending in endings))


def slow_reader(bench: Bench) -> None:
    """The kernel's client fills the window of a user that pauses, and then all is read."""

    def accept(connection: Connection) -> None:
        found = bytearray()

        def on_end() -> None:
            connection.send(judge(bytes(found)).encode())
            connection.end()

        def on_data(data: bytes) -> None:
            found.extend(data)
            connection.pause()
            threading.Timer(0.001, wanted.append, [connection]).start()

        connection.on_data, connection.on_end = on_data, on_end

    wanted: list[Connection] = []

    def client() -> None:
        with socket.create_connection((CONTROLLER, PORT)) as connection:
            connection.sendall(DATA)
            connection.shutdown(socket.SHUT_WR)
            say(received(connection).decode())

    advance = bench.stack.advance

    def resume_and_advance(now_ns: int) -> None:
        while wanted:
            wanted.pop().resume()
        advance(now_ns)

    bench.stack.advance = resume_and_advance  # type: ignore[method-assign]
    bench.stack.listen(PORT, accept)
    bench.run(client)


def ping(bench: Bench) -> None:
    """The kernel sends an echo and accepts only an answer whose checksum, addresses and identifier fit."""
    with open("/proc/sys/net/ipv4/ping_group_range", "w", encoding="ascii") as file:  # noqa: PTH123
        file.write("0 0")

    def client() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM, socket.IPPROTO_ICMP) as echo:
            echo.sendto(bytes.fromhex("0800 0000 0000 0007") + b"are you there", (CONTROLLER, 0))
            say(repr(echo.recv(1000)[6:]))

    bench.run(client)


SCENES = {scene.__name__: scene for scene in (download, upload, dial_out, refused, reset, slow_reader, ping)}

if __name__ == "__main__":
    SCENES[sys.argv[1]](Bench(float(sys.argv[2])))
