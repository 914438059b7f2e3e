"""The needs of a rig in real time: POSIX, for its sockets between processes and for its ptys."""

import socket

from fieldrig.errors import RigError


def check_system() -> None:
    """RigError where the system cannot run a rig in real time, such as Windows."""
    if not hasattr(socket, "AF_UNIX"):
        raise RigError(
            "this system cannot run a rig in real time: its processes need Unix sockets, which Windows has not",
            "run it in virtual time (`--set time=virtual`), or run fieldrig in WSL 2 or in Docker",
        )
