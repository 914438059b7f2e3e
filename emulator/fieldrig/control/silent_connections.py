"""The connections at the control endpoint that have not said who they are, for `fieldrig status`.

Zenoh listens there and keeps them for some seconds, but it only tells of those that have.  The system knows all of
them, and shows them on Linux as files (proc(5)): `net/tcp` and `net/tcp6` with a line for each end, and `net/unix` with
one for each socket.
"""

from pathlib import Path
from typing import Final

import zenoh

from fieldrig.outside.addresses import UNIX_SOCKET

_FILES: Final = Path("/proc/self/net")
_ESTABLISHED: Final = "01"
"""The state of a TCP connection whose handshake is over (`include/net/tcp_states.h` of Linux)."""
_CONNECTED: Final = "03"
"""The state of a Unix socket with another end (`include/uapi/linux/net.h`: SS_CONNECTED)."""


def silent_connections(session: zenoh.Session, endpoint: str) -> int | None:
    """Return how many connections at the endpoint have said nothing yet; None where the system does not tell."""
    protocol, _, address = endpoint.partition("?")[0].partition("/")
    try:
        there = _of_path(address) if protocol == UNIX_SOCKET else _of_port(int(address.rpartition(":")[2]))
    except OSError:
        return None
    known = sum(str(link.src).partition("?")[0].endswith(_end(protocol, address)) for link in session.info.links())
    return max(there - known, 0)


def _end(protocol: str, address: str) -> str:
    """Return how Zenoh writes the end of a link at this address: a wildcard is another address there."""
    return address if protocol == UNIX_SOCKET else f":{address.rpartition(':')[2]}"


def _of_port(port: int) -> int:
    """Return how many connections to this port are there: sl, local address, remote address, state."""
    count = 0
    for file in (_FILES / "tcp", _FILES / "tcp6"):
        rows = (line.split() for line in file.read_text(encoding="ascii").splitlines()[1:])
        count += sum(row[1].endswith(f":{port:04X}") and row[3] == _ESTABLISHED for row in rows)
    return count


def _of_path(path: str) -> int:
    """Return how many connections to this socket are there: the sixth word is the state, the last one the path."""
    lines = (_FILES / "unix").read_text(encoding="utf-8", errors="surrogateescape").splitlines()
    rows = (line.split(maxsplit=7) for line in lines[1:])
    return sum(len(row) == 8 and row[7] == path and row[5] == _CONNECTED for row in rows)
