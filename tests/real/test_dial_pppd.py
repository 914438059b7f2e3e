"""Our TCP/IP stack and `fieldrig dial` opposite pppd, with the TCP of Linux behind it."""

import os
import pty
import select
import socket
import subprocess
import sys
import threading
import tty
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from dial_peer import PAGE, PtyPeer
from pppd import SECRETS, is_in_guest

from fieldrig.testing import free_port

pytestmark = [
    pytest.mark.real,
    pytest.mark.ppp,
    pytest.mark.skipif(not is_in_guest(), reason="runs inside user-mode Linux: `python -m tests.driver ppp`"),
]

CONTROLLER, CALLER = "190.200.100.100", "190.200.100.101"
COMMON = ("38400", "local", "nodetach", "nocrtscts", "noipdefault", "user", "service")
LIMIT_S = 60


@pytest.fixture(autouse=True)
def guest() -> None:
    SECRETS.write_text("service * secret *\n")
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)


@contextmanager
def pppd(path: str, folder: Path, *options: str) -> Iterator[None]:
    log = folder / "pppd.log"
    with log.open("w") as output, subprocess.Popen(["pppd", path, *COMMON, *options], stdout=output) as process:
        try:
            yield
        finally:
            process.terminate()


@contextmanager
def started(command: list[str]) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def received(connection: socket.socket) -> bytes:
    found = bytearray()
    while chunk := connection.recv(65536):
        found += chunk
    return bytes(found)


def test_linux_fetches_a_page_from_our_stack_over_pppd(tmp_path: Path) -> None:
    with PtyPeer(has_modem=False) as peer, pppd(peer.path, tmp_path, "noauth"):
        until_up(tmp_path)
        with socket.create_connection((CONTROLLER, 80), timeout=LIMIT_S) as connection:
            connection.sendall(b"GET / HTTP/1.0\r\n\r\n")
            assert received(connection) == PAGE


def test_fieldrig_dial_reaches_a_server_of_linux_over_pppd(tmp_path: Path) -> None:
    master, slave = pty.openpty()
    tty.setraw(slave)
    local = free_port()
    with (
        socket.create_server(("127.0.0.1", 0)) as line,
        pppd(os.ttyname(slave), tmp_path, "require-pap", f"{CONTROLLER}:{CALLER}"),
    ):
        command = [sys.executable, "-m", "fieldrig", "dial", f"tcp://127.0.0.1:{line.getsockname()[1]}"]
        command += ["--user", "service", "--password", "secret", "--forward", f"{local}:7"]
        with started(command) as dial:
            end, _ = line.accept()
            threading.Thread(target=bridge, args=(end, master), daemon=True).start()
            assert dial.stdout is not None
            said = iter(dial.stdout.readline, "")
            assert any("The link is up: this end is 190.200.100.101" in text for text in said)
            until_up(tmp_path)
            until_leading(said)
            with socket.create_server((CONTROLLER, 7)) as server:
                threading.Thread(target=echo, args=(server,), daemon=True).start()
                data = bytes(place * 7 & 0xFF for place in range(30_000))
                with socket.create_connection(("127.0.0.1", local), timeout=LIMIT_S) as connection:
                    connection.sendall(data)
                    connection.shutdown(socket.SHUT_WR)
                    assert received(connection) == data
            dial.terminate()
            assert dial.wait(timeout=LIMIT_S) == 0
            end.close()
    os.close(slave)


def until_up(folder: Path) -> None:
    """Wait until the kernel has the address of the link."""
    for _ in range(LIMIT_S * 10):
        if "local  IP address" in (folder / "pppd.log").read_text():
            return
        select.select([], [], [], 0.1)
    raise AssertionError((folder / "pppd.log").read_text())


def until_leading(said: Iterator[str]) -> None:
    assert any("Ctrl-C hangs up." in text for text in said)


def echo(server: socket.socket) -> None:
    connection, _ = server.accept()
    with connection:
        connection.sendall(received(connection))


def bridge(end: socket.socket, master: int) -> None:
    """Carry bytes between a TCP connection and a pty until one of them ends."""
    with suppress(OSError):
        while True:
            ready, _, _ = select.select([end.fileno(), master], [], [])
            for source in ready:
                data = os.read(source, 4096)
                if not data:
                    return
                os.write(master if source == end.fileno() else end.fileno(), data)
