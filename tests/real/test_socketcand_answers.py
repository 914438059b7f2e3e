"""python-can connects to a busy bus although a late host has put frames behind the server's answer."""

import socket
import threading
from types import SimpleNamespace
from typing import Any

import can
import pytest
from can.interfaces.socketcand.socketcand import SocketCanDaemonBus

pytestmark = pytest.mark.real


def served(listener: socket.socket, answer: bytes) -> None:
    connection = listener.accept()[0]
    with connection:
        for answered in (b"< hi >", b"< ok >", answer):
            connection.sendall(answered)
            if not connection.recv(64):
                return


def connected(answer: bytes) -> can.Message | None:
    """Return the first message after a server has given this answer to `< rawmode >`."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        server = threading.Thread(target=served, args=(listener, answer))
        server.start()
        try:
            with can.Bus("can0", "socketcand", host="127.0.0.1", port=listener.getsockname()[1]) as bus:
                return bus.recv(60.0)
        finally:
            server.join()


def test_a_frame_behind_the_answer_is_heard() -> None:
    message = connected(b"< ok >< frame 702 1795956565.744601 05 >")
    assert message is not None
    assert (message.arbitration_id, bytes(message.data)) == (0x702, b"\x05")


def test_another_answer_is_refused() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        theirs.sendall(b"< error no >")
        bus = SimpleNamespace(_SocketCanDaemonBus__socket=ours)
        client: Any = SocketCanDaemonBus
        with pytest.raises(can.CanError, match="expected '< ok >', got b'< erro'"):
            client._expect_msg(bus, "< ok >")
