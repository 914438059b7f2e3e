"""The network of the block: TCP from members to the ports of the rig, and among members, without the system's network.

A listening or connected socket keeps its class and its address, but behind it is an end of a pair of sockets (`pairs`).
So select, event loops and blocking calls work as they are, and a byte that is sent is there at once, while the system
may deliver those of its own TCP later.  A socket that listens can be read while a connection is waiting: for each, the
other end of its pair has sent a byte.
Left out: UDP, and options of TCP, which are accepted and do nothing.
"""

import errno
import itertools
import os
import socket
from collections import deque
from collections.abc import Callable
from typing import Any, Final
from weakref import WeakKeyDictionary, WeakSet, finalize, ref

from fieldrig.master_time.active import seeing_scheduler, waiting_scheduler
from fieldrig.master_time.descriptors import is_ready
from fieldrig.master_time.errors import VirtualTimeError
from fieldrig.master_time.pairs import Pairs
from fieldrig.master_time.scheduler import Place, Scheduler
from fieldrig.master_time.threads import refused

OUTSIDE: Final = {
    getattr(socket, name) for name in ("AF_CAN", "AF_PACKET", "AF_BLUETOOTH", "AF_VSOCK") if hasattr(socket, name)
}
"""Families whose sockets lead to devices of the host, such as a CAN adapter."""
LOOPBACK: Final = ("", "localhost", "::1", "::", "0.0.0.0")
FIRST_FREE: Final = 49152
"""The first port that is given to sockets that ask for any (RFC 6335, 6)."""
LAST_FREE: Final = 65535

Address = tuple[str, int]
_REAL: Final = {
    name: getattr(socket.socket, name)
    for name in (
        "_real_close", "accept", "bind", "connect", "connect_ex", "getpeername", "getsockname", "getsockopt", "listen",
        "recv", "recv_into", "recvfrom", "recvfrom_into", "recvmsg", "send", "sendall", "sendmsg", "sendto",
        "setsockopt", "shutdown",
    )
    if hasattr(socket.socket, name)
}  # fmt: skip
WAITING: Final = ("recv", "recv_into", "recvfrom", "recvfrom_into", "recvmsg", "send", "sendmsg", "sendto")
"""The calls that wait until data has come, or can be sent."""
PLACE_OF_FLAGS: Final = {"recv": 1, "recv_into": 2, "recvfrom": 1, "recvfrom_into": 2, "recvmsg": 2}
"""The place of the flags among the arguments of a call that reads."""
_real_getaddrinfo, _real_gethostbyname = socket.getaddrinfo, socket.gethostbyname
_real_gethostbyaddr, _real_getfqdn = socket.gethostbyaddr, socket.getfqdn


class _Listening:
    """The connections that wait to be accepted by a socket that listens."""

    def __init__(self, sock: socket.socket, door: socket.socket) -> None:
        """`door` is the other end of the pair of `sock`."""
        self.sock, self._door = ref(sock), door
        self._waiting: deque[tuple[socket.socket, int]] = deque()
        self.most: int | None = None
        """How many may wait; None before it listens."""
        finalize(sock, self.close)

    @property
    def is_open(self) -> bool:
        sock = self.sock()
        return sock is not None and sock.fileno() >= 0

    @property
    def accepts(self) -> bool:
        return self.is_open and self.most is not None and len(self._waiting) <= self.most

    def add(self, pairs: Pairs, other: socket.socket, own: int) -> None:
        """Let a connection wait; `own` is the port of its client."""
        self._waiting.append((other, own))
        _REAL["send"](self._door, b"+")
        pairs.sent(self._door, 1)

    def take(self, pairs: Pairs, sock: socket.socket) -> tuple[socket.socket, int]:
        """Return the connection that has waited longest.  BlockingIOError if there is none."""
        pairs.read(sock, len(_REAL["recv"](sock, 1)))
        return self._waiting.popleft()

    def close(self) -> None:
        self._door.close()
        while self._waiting:
            self._waiting.popleft()[0].close()


class Network:
    """The addresses of one block."""

    def __init__(self) -> None:
        self.pairs = Pairs()
        self._listening: dict[Address, _Listening] = {}
        """The sockets that listen, by their address."""
        self._of_socket: WeakKeyDictionary[socket.socket, _Listening] = WeakKeyDictionary()
        self._addresses: WeakKeyDictionary[socket.socket, tuple[Any, Any]] = WeakKeyDictionary()
        """The own address of each socket, and that of its peer."""
        self._of_ports: WeakSet[socket.socket] = WeakSet()
        """The sockets of ports of the rig that have been connected."""
        self.is_used = False
        """True once a member has connected."""
        self._free = itertools.cycle(range(FIRST_FREE, LAST_FREE + 1))
        self._known: set[Address] = set()
        """The addresses at which a server listens, or has listened."""
        self.rig_addresses: list[str] = []
        """The addresses of the rig file, for messages."""

    # ---- what the calls of a socket do

    def bind(self, sock: socket.socket, address: Any) -> None:
        host, port = str(address[0]), int(address[1]) or next(self._free)
        place = _place(host, port)
        if place in self._listening and self._listening[place].is_open:
            raise OSError(errno.EADDRINUSE, f"{os.strerror(errno.EADDRINUSE)}: {host}:{port}")
        self._listening[place] = self._of_socket[sock] = _Listening(sock, self.pairs.connect(sock))
        self._addresses[sock] = ((host, port), None)
        self._known.add(place)

    def listen(self, sock: socket.socket, backlog: int) -> None:
        self._of_socket[sock].most = max(backlog, 0)

    def connect(self, scheduler: Scheduler, sock: socket.socket, address: Any) -> None:
        host, port = str(address[0]), int(address[1])
        place = _place(host, port)
        scheduler.settle()
        listening = self._listening.get(place)
        if listening is None or not listening.is_open:
            if place in self._known or scheduler.place is Place.DOORS:
                raise ConnectionRefusedError(errno.ECONNREFUSED, os.strerror(errno.ECONNREFUSED))
            sock.close()  # its owner expects an OSError, or none, and would leave it open
            raise self.outside(scheduler, f"{host}:{port}")
        if not listening.accepts:
            raise ConnectionRefusedError(errno.ECONNREFUSED, os.strerror(errno.ECONNREFUSED))
        self.is_used, own = True, next(self._free)
        listening.add(self.pairs, self.pairs.connect(sock), own)
        near = "::1" if sock.family == socket.AF_INET6 else "127.0.0.1"
        self._addresses[sock] = (_full(sock, near, own), _full(sock, host, port))
        self._note(sock)

    def _note(self, sock: socket.socket) -> None:
        scheduler = seeing_scheduler()
        if scheduler is not None and scheduler.place is Place.DOORS:
            self._of_ports.add(sock)

    def has_connections(self) -> bool:
        """True if a port of the rig has a connection."""
        return any(sock.fileno() >= 0 for sock in self._of_ports)

    def accept(self, sock: socket.socket) -> tuple[socket.socket, Any]:
        """Return a connection that was waiting, and the address of its client."""
        made, own = self._of_socket[sock].take(self.pairs, sock)
        made.settimeout(socket.getdefaulttimeout())
        near = "::1" if sock.family == socket.AF_INET6 else "127.0.0.1"
        peer = _full(sock, near, own)
        self._addresses[made] = (self._addresses[sock][0], peer)
        self._note(made)
        return made, peer

    def closed(self, sock: socket.socket) -> None:
        """Do what the end of a socket means for the others."""
        if (listening := self._of_socket.get(sock)) is not None:
            listening.close()
        self.pairs.sends_no_more(sock)

    def own_address(self, sock: socket.socket) -> Any:
        return _full(sock, *self._addresses[sock][0][:2])

    def peer_address(self, sock: socket.socket) -> Any:
        if self._addresses[sock][1] is None:
            raise OSError(errno.ENOTCONN, os.strerror(errno.ENOTCONN))
        return self._addresses[sock][1]

    def has(self, sock: socket.socket) -> bool:
        return sock in self._addresses

    def is_bound(self, sock: socket.socket) -> bool:
        return sock in self._of_socket

    def outside(self, scheduler: Scheduler, what: str) -> VirtualTimeError:
        known = ", ".join(self.rig_addresses) or "no address"
        return refused(scheduler, f"{what} is outside of the rig, where time is not virtual; the rig has {known}")


def _place(host: str, port: int) -> Address:
    """Return an address with one name for all of loopback."""
    is_loopback = host in LOOPBACK or host.startswith("127.")
    return ("" if is_loopback else host, port)


def _full(sock: socket.socket, host: str, port: int) -> Any:
    return (host, port, 0, 0) if sock.family == socket.AF_INET6 else (host, port)


# ---- what members call


class SocketStandIns:
    """The methods of `socket.socket`, for one network."""

    def __init__(self, network: Network) -> None:
        self._network = network

    def methods(self) -> dict[str, Callable[..., Any]]:
        """Return the methods by name."""
        network = self._network

        def bind(sock: socket.socket, address: Any) -> None:
            scheduler = seeing_scheduler()
            if scheduler is not None and sock.family in OUTSIDE:
                raise network.outside(scheduler, repr(address))
            if scheduler is None or not _is_internet(sock):
                _REAL["bind"](sock, address)
            else:
                _check_stream(network, scheduler, sock, address)
                network.bind(sock, address)

        def connect(sock: socket.socket, address: Any) -> None:
            scheduler = seeing_scheduler()
            if scheduler is None:
                _REAL["connect"](sock, address)
            elif not _is_internet(sock):
                raise network.outside(scheduler, repr(address))
            else:
                _check_stream(network, scheduler, sock, address)
                network.connect(scheduler, sock, address)

        def connect_ex(sock: socket.socket, address: Any) -> int:
            if seeing_scheduler() is None:
                return int(_REAL["connect_ex"](sock, address))
            try:
                connect(sock, address)
            except OSError as fault:
                return fault.errno or errno.EIO
            return 0

        def accept(sock: socket.socket) -> Any:
            _wait_until_ready(sock, is_write=False)
            return network.accept(sock) if network.is_bound(sock) else _REAL["accept"](sock)

        def listen(sock: socket.socket, backlog: int = socket.SOMAXCONN) -> None:
            if network.is_bound(sock):
                network.listen(sock, backlog)
            else:
                _REAL["listen"](sock, backlog)

        def real_close(sock: socket.socket, *arguments: Any) -> None:
            _REAL["_real_close"](sock, *arguments)
            if network.has(sock):
                network.closed(sock)

        def shutdown(sock: socket.socket, how: int) -> None:
            _REAL["shutdown"](sock, how)
            if how != socket.SHUT_RD:
                network.pairs.sends_no_more(sock)

        def getsockname(sock: socket.socket) -> Any:
            return network.own_address(sock) if network.has(sock) else _REAL["getsockname"](sock)

        def getpeername(sock: socket.socket) -> Any:
            return network.peer_address(sock) if network.has(sock) else _REAL["getpeername"](sock)

        def setsockopt(sock: socket.socket, level: int, *arguments: Any) -> None:
            if not (network.has(sock) and level != socket.SOL_SOCKET):
                _REAL["setsockopt"](sock, level, *arguments)

        def getsockopt(sock: socket.socket, level: int, *arguments: Any) -> Any:
            is_tcp = network.has(sock) and level != socket.SOL_SOCKET
            return 0 if is_tcp else _REAL["getsockopt"](sock, level, *arguments)

        def sendto(sock: socket.socket, *arguments: Any) -> Any:
            scheduler = seeing_scheduler()
            if scheduler is not None and _is_internet(sock) and not network.has(sock):
                raise network.outside(scheduler, f"UDP to {arguments[-1]!r}")
            return waiting["sendto"](sock, *arguments)

        def sendall(sock: socket.socket, data: Any, *flags: int) -> None:
            if waiting_scheduler() is None:
                _REAL["sendall"](sock, data, *flags)
                return
            left = memoryview(data).cast("B")
            while left:
                left = left[waiting["send"](sock, left, *flags) :]

        waiting = {name: _waiting(network.pairs, name) for name in WAITING if name in _REAL}
        named: dict[str, Callable[..., Any]] = {
            "bind": bind, "connect": connect, "connect_ex": connect_ex, "accept": accept, "getsockname": getsockname,
            "getpeername": getpeername, "setsockopt": setsockopt, "getsockopt": getsockopt, "sendto": sendto,
            "sendall": sendall, "listen": listen, "shutdown": shutdown, "_real_close": real_close,
        }  # fmt: skip
        return waiting | named

    def names(self) -> list[tuple[Any, Any]]:
        """Return the calls that look names up, each with its stand-in."""
        look = _Names(self._network)
        return [
            (_real_getaddrinfo, look.getaddrinfo),
            (_real_gethostbyname, look.gethostbyname),
            (_real_gethostbyaddr, look.gethostbyaddr),
            (_real_getfqdn, look.getfqdn),
        ]


def _is_internet(sock: socket.socket) -> bool:
    return sock.family in (socket.AF_INET, socket.AF_INET6)


def _check_stream(network: Network, scheduler: Scheduler, sock: socket.socket, address: Any) -> None:
    if sock.type != socket.SOCK_STREAM:
        raise network.outside(scheduler, f"UDP with {address!r}")


def _wait_until_ready(sock: socket.socket, is_write: bool) -> None:
    """Wait as long as the time-out of the socket says.  TimeoutError if it passes."""
    scheduler, timeout_s = waiting_scheduler(), sock.gettimeout()
    if scheduler is None:
        return
    descriptor = sock.fileno()
    if descriptor < 0 or is_ready(descriptor, is_write):
        return
    if timeout_s == 0:
        scheduler.poll()
        return
    until_ns = scheduler.until(timeout_s)

    def ready() -> bool:  # a socket that another thread closes meanwhile is an error, not a wait
        return sock.fileno() != descriptor or is_ready(descriptor, is_write)

    if not scheduler.wait(until_ns, ready=ready) and not ready():
        raise TimeoutError("timed out")


def _waiting(pairs: Pairs, name: str) -> Callable[..., Any]:
    real, is_write, place = _REAL[name], name.startswith("send"), PLACE_OF_FLAGS.get(name, 0)

    def method(sock: socket.socket, *arguments: Any, **options: Any) -> Any:
        _wait_until_ready(sock, is_write)
        result = real(sock, *arguments, **options)
        if is_write:
            pairs.sent(sock, result)
        elif not (options.get("flags", 0) or (arguments[place] if len(arguments) > place else 0)) & socket.MSG_PEEK:
            first = result[0] if isinstance(result, tuple) else result
            pairs.read(sock, first if isinstance(first, int) else len(first))
        return result

    return method


class _Names:
    """Names of hosts: those of loopback, numbers, and no others."""

    def __init__(self, network: Network) -> None:
        self._network = network

    def getaddrinfo(
        self, host: Any, port: Any, family: int = 0, type: int = 0, proto: int = 0, flags: int = 0
    ) -> list[Any]:
        if seeing_scheduler() is not None and host in ("localhost", b"localhost"):
            host = "::1" if family == socket.AF_INET6 else "127.0.0.1"
        elif seeing_scheduler() is not None and host is not None:
            self._check(host)
        return _real_getaddrinfo(host, port, family, type, proto, flags)

    def gethostbyname(self, host: str) -> str:
        if seeing_scheduler() is None:
            return _real_gethostbyname(host)
        self._check(host)
        return "127.0.0.1" if host == "localhost" else host

    def gethostbyaddr(self, host: str) -> Any:
        if seeing_scheduler() is None:
            return _real_gethostbyaddr(host)
        self._check(host)
        return "localhost", [], ["127.0.0.1" if host in LOOPBACK else host]

    def getfqdn(self, name: str = "") -> str:
        if seeing_scheduler() is None:
            return _real_getfqdn(name)
        return "localhost" if _place(name, 0)[0] == "" else name

    def _check(self, host: Any) -> None:
        """VirtualTimeError for a name that only a server outside could look up."""
        name, scheduler = host.decode() if isinstance(host, bytes) else str(host), seeing_scheduler()
        if scheduler is None or name in LOOPBACK or _is_number(name):
            return
        raise self._network.outside(scheduler, name)


def _is_number(host: str) -> bool:
    for family in (socket.AF_INET, socket.AF_INET6):
        try:
            socket.inet_pton(family, host.partition("%")[0])
        except OSError:
            continue
        return True
    return False
