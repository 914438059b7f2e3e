"""A python-can whose client of socketcand reads no further than the answer that it expects.

The original takes all that one read returns for the answer.  On a host that is late, frames follow the last `< ok >`
in the same segment, and it refuses the connection: "Expected '< ok >' got: '< ok >< frame 702 ...".  Nothing
that a server does can prevent it, as TCP knows no messages.
"""

from typing import Any

import can
from can.interfaces.socketcand.socketcand import SocketCanDaemonBus


def install() -> None:
    """Have python-can do so in this process."""
    client: Any = SocketCanDaemonBus
    client._expect_msg = _expect


def _expect(bus: Any, expected: str) -> None:
    connection, heard = bus._SocketCanDaemonBus__socket, b""
    while len(heard) < len(expected) and (more := connection.recv(len(expected) - len(heard))):
        heard += more
    if heard != expected.encode():
        raise can.CanError(f"expected {expected!r}, got {heard!r}")
