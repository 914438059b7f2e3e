"""Reading from ports of pyserial: everything that has arrived comes at once, whatever the port is."""

import os
import socket
import tty
from collections.abc import Iterator
from contextlib import closing
from typing import Any

import pytest
from serial import SerialException, serial_for_url

from fieldrig_bus.serial.reading import read_arrived

pytestmark = pytest.mark.system

DATA = bytes(range(250)) * 16
OPEN: Any = serial_for_url  # which has no types


@pytest.fixture
def line() -> Iterator[tuple[socket.socket, Any]]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = OPEN(f"socket://127.0.0.1:{server.getsockname()[1]}", timeout=0.01)
        peer, _ = server.accept()
        with peer, closing(port):
            yield peer, port


def test_everything_that_a_socket_has_comes_at_once(line: tuple[socket.socket, Any]) -> None:
    peer, port = line
    peer.sendall(DATA)
    assert read_arrived(port) == DATA
    assert read_arrived(port) == b""
    assert port.timeout == 0.01


def test_the_last_bytes_of_a_socket_come_before_its_end(line: tuple[socket.socket, Any]) -> None:
    peer, port = line
    peer.sendall(b"x")
    peer.close()
    assert read_arrived(port) == b"x"
    with pytest.raises(SerialException):
        read_arrived(port)


def test_everything_that_a_pty_has_comes_at_once() -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    with closing(OPEN(os.ttyname(slave), timeout=0.01)) as port:
        os.write(master, DATA[:1000])
        assert read_arrived(port) == DATA[:1000]
        assert read_arrived(port) == b""
    os.close(master)
    os.close(slave)
