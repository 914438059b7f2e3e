"""Pairs of connected sockets behind those of a block, at whose ends a byte that is sent is there at once.

POSIX has such pairs, and lets a socket lead to one of them under its own number.  Windows has pairs over its TCP only,
which delivers a moment later.  There a sender waits for that moment, and a socket gets another number when it is bound
or connected.
Left out: more than `SEEN` unread bytes, which on Windows may come in other pieces in each run.
"""

import os
import socket
from contextlib import closing
from typing import Any, Final
from weakref import WeakKeyDictionary, ref

IS_INSTANT: Final = hasattr(socket, "AF_UNIX")
"""True on POSIX, where the number of a socket is one of a file as well."""
SEEN: Final = 64 * 1024
"""Bytes that a sender waits for, of those that a socket has not read yet."""
BUFFER: Final = 8 * SEEN
_Socket: Final[Any] = socket.socket.__base__
"""The class in C, whose calls are the real ones also in a block."""


class _End:
    """The count of bytes that a socket has not read yet, over a TCP that delivers later."""

    __slots__ = ("is_over", "peer", "unread")

    def __init__(self, peer: socket.socket) -> None:
        self.peer = ref(peer)
        self.unread = 0
        self.is_over = False
        """True if the other end sends no more."""


class Pairs:
    """The pairs of one block."""

    def __init__(self) -> None:
        self._ends: WeakKeyDictionary[socket.socket, _End] = WeakKeyDictionary()

    def connect(self, sock: socket.socket) -> socket.socket:
        """Let a socket lead to one end of a new pair, and return a socket of its kind at the other end."""
        near, far = _pair()
        _stand_behind(sock, near)
        other = socket.socket(sock.family, sock.type, sock.proto, fileno=far.detach())
        if not IS_INSTANT:
            self._ends[sock], self._ends[other] = _End(other), _End(sock)
        return other

    def sent(self, sock: socket.socket, count: int) -> None:
        """Return when the other end has the bytes that were sent."""
        self._settle(sock, count)

    def sends_no_more(self, sock: socket.socket) -> None:
        """Return when the other end sees the end of what was sent."""
        self._settle(sock, 0, is_over=True)

    def read(self, sock: socket.socket, count: int) -> None:
        """Count bytes that were read, and return when those that follow are there."""
        if (end := self._ends.get(sock)) is not None:
            end.unread = max(0, end.unread - count)
            _wait_for(sock, end)

    def _settle(self, sock: socket.socket, count: int, *, is_over: bool = False) -> None:
        here = self._ends.get(sock)
        peer = here.peer() if here is not None else None
        end = self._ends.get(peer) if peer is not None else None
        if peer is not None and end is not None:
            end.unread += count
            end.is_over |= is_over
            _wait_for(peer, end)


def _pair() -> tuple[Any, Any]:
    if IS_INSTANT:
        return socket.socketpair()
    # Not socketpair of the standard library, whose sockets would be those of the block.
    with closing(_Socket(socket.AF_INET, socket.SOCK_STREAM)) as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen(1)
        near = _tcp(None)
        near.connect(listening.getsockname())
        far = _tcp(listening._accept()[0])
    if far.getpeername() != near.getsockname():  # a stranger was quicker
        near.close()
        far.close()
        raise ConnectionAbortedError("another program of this host has connected")
    return near, far


def _tcp(number: int | None) -> Any:
    made = _Socket(socket.AF_INET, socket.SOCK_STREAM, 0, number)
    made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)
    return made


def _stand_behind(sock: socket.socket, hidden: Any) -> None:
    """Let `sock` lead to another socket, with the same time-out."""
    timeout_s = sock.gettimeout()
    if IS_INSTANT:
        os.dup2(hidden.fileno(), sock.fileno(), inheritable=False)
        hidden.close()
    else:
        family, kind, protocol = sock.family, sock.type, sock.proto
        _Socket.close(sock)
        _Socket.__init__(sock, family, kind, protocol, hidden.detach())
    sock.settimeout(timeout_s)


def _wait_for(sock: socket.socket, end: _End) -> None:
    """Wait until what was sent to a socket can be read."""
    wanted = min(end.unread, SEEN)
    while sock.fileno() >= 0 and (wanted or end.is_over):
        try:
            there = len(_Socket.recv(sock, wanted or 1, socket.MSG_PEEK))
        except (BlockingIOError, TimeoutError):
            continue
        except OSError:  # the connection was reset, which its reader sees as well
            return
        if there >= wanted:
            return
