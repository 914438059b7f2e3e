"""TCP connections whose other end may vanish without a word, as when a cable is cut or a host loses its power."""

import asyncio
import socket
from typing import Final

KEEPALIVE: Final = {
    "TCP_KEEPIDLE": 4,
    "TCP_KEEPINTVL": 2,
    "TCP_KEEPCNT": 3,
}
"""Seconds, seconds and probes, where the system has them: the end of an idle connection is noticed after 10 s."""
UNANSWERED_MS: Final = 10_000
"""The same for data that is not acknowledged.  The system itself tries for some 15 minutes, ever more seldom, so that
a line of a minute's cut would be silent for up to another one."""


def notice_silence(sock: socket.socket) -> None:
    """Let a connection end when the other end has not answered the system for 10 s; idle ones are asked as well."""
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in KEEPALIVE.items():
        _set(sock, name, value)


def leave_when_silent(transport: asyncio.BaseTransport) -> None:
    """Do that for a connection of our own protocol, also while what was sent is not acknowledged or not read.

    It does nothing for a Unix socket, whose other end cannot vanish alone.
    """
    sock = transport.get_extra_info("socket")
    if sock is not None and sock.family in (socket.AF_INET, socket.AF_INET6):
        notice_silence(sock)
        _set(sock, "TCP_USER_TIMEOUT", UNANSWERED_MS)


def _set(sock: socket.socket, name: str, value: int) -> None:
    if hasattr(socket, name):
        sock.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
