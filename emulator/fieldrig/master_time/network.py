"""The network of the block: TCP from members to the ports of the rig, and among members, without the system's network.

A listening or connected socket keeps its number, its class and its address, but behind it is a Unix socket without a
name in the file system.  So select, event loops and blocking calls work as they are, and a byte that is sent is there
at once, while the system may deliver those of its own TCP later.
Left out: UDP, and options of TCP, which are accepted and do nothing.
"""

import errno
import itertools
import os
import secrets
import socket
from collections.abc import Callable
from typing import Any, Final
from weakref import WeakKeyDictionary, WeakSet, ref

from fieldrig.master_time.active import seeing_scheduler, waiting_scheduler
from fieldrig.master_time.descriptors import is_ready
from fieldrig.master_time.errors import VirtualTimeError
from fieldrig.master_time.scheduler import Place, Scheduler
from fieldrig.master_time.threads import refused

LOOPBACK: Final = ("", "localhost", "::1", "::", "0.0.0.0")
FIRST_FREE: Final = 49152
"""The first port that is given to sockets that ask for any (RFC 6335, 6)."""
LAST_FREE: Final = 65535

Address = tuple[str, int]
_PREFIX: Final = b"\0" + secrets.token_bytes(5)
"""Begins the names of this process.  A socket of AF_INET keeps the first 14 bytes of a name only."""
_sequence = itertools.count()
_REAL: Final = {
    name: getattr(socket.socket, name)
    for name in (
        "accept", "bind", "connect", "connect_ex", "getpeername", "getsockname", "getsockopt", "listen", "recv",
        "recv_into", "recvfrom", "recvfrom_into", "recvmsg", "send", "sendall", "sendmsg", "sendto", "setsockopt",
    )
    if hasattr(socket.socket, name)
}  # fmt: skip
_real_getaddrinfo, _real_gethostbyname = socket.getaddrinfo, socket.gethostbyname
_real_gethostbyaddr, _real_getfqdn = socket.gethostbyaddr, socket.getfqdn


class Network:
    """The addresses of one block."""

    def __init__(self) -> None:
        self._listening: dict[Address, tuple[ref[socket.socket], bytes]] = {}
        """The socket that listens at each address, and the name of the socket behind it."""
        self._addresses: WeakKeyDictionary[socket.socket, tuple[Any, Any]] = WeakKeyDictionary()
        """The own address of each socket, and that of its peer."""
        self._of_ports: WeakSet[socket.socket] = WeakSet()
        """The sockets of ports of the rig that have been connected."""
        self._free = itertools.cycle(range(FIRST_FREE, LAST_FREE + 1))
        self._known: set[Address] = set()
        """The addresses at which a server listens, or has listened."""
        self.rig_addresses: list[str] = []
        """The addresses of the rig file, for messages."""

    # ---- what the calls of a socket do

    def bind(self, sock: socket.socket, address: Any) -> None:
        host, port = str(address[0]), int(address[1]) or next(self._free)
        place = _place(host, port)
        if self._name(place) is not None:
            raise OSError(errno.EADDRINUSE, f"{os.strerror(errno.EADDRINUSE)}: {host}:{port}")
        with socket.socket(socket.AF_UNIX, sock.type) as hidden:
            name = _hidden_name(port)
            _REAL["bind"](hidden, name)
            _stand_behind(sock, hidden)
        self._addresses[sock] = ((host, port), None)
        self._listening[place] = (ref(sock), name)
        self._known.add(place)

    def connect(self, scheduler: Scheduler, sock: socket.socket, address: Any) -> None:
        host, port = str(address[0]), int(address[1])
        name = self._name(_place(host, port))
        if name is None:
            if _place(host, port) in self._known or scheduler.place is Place.DOORS:
                raise ConnectionRefusedError(errno.ECONNREFUSED, os.strerror(errno.ECONNREFUSED))
            sock.close()  # its owner expects an OSError, or none, and would leave it open
            raise self.outside(scheduler, f"{host}:{port}")
        own = next(self._free)
        with socket.socket(socket.AF_UNIX, sock.type) as hidden:
            _REAL["bind"](hidden, _hidden_name(own))
            hidden.setblocking(False)
            try:
                _REAL["connect"](hidden, name)
            except OSError:  # the server has closed, or accepts no more
                raise ConnectionRefusedError(errno.ECONNREFUSED, os.strerror(errno.ECONNREFUSED)) from None
            _stand_behind(sock, hidden)
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

    def accepted(self, listening: socket.socket, sock: socket.socket, hidden: Any) -> Any:
        """Return the address of a client that was accepted."""
        own = int.from_bytes(bytes(hidden)[-2:], "big")
        near = "::1" if listening.family == socket.AF_INET6 else "127.0.0.1"
        peer = _full(listening, near, own)
        self._addresses[sock] = (self._addresses[listening][0], peer)
        self._note(sock)
        return peer

    def own_address(self, sock: socket.socket) -> Any:
        return _full(sock, *self._addresses[sock][0][:2])

    def peer_address(self, sock: socket.socket) -> Any:
        if self._addresses[sock][1] is None:
            raise OSError(errno.ENOTCONN, os.strerror(errno.ENOTCONN))
        return self._addresses[sock][1]

    def has(self, sock: socket.socket) -> bool:
        return sock in self._addresses

    def outside(self, scheduler: Scheduler, what: str) -> VirtualTimeError:
        known = ", ".join(self.rig_addresses) or "no address"
        return refused(scheduler, f"{what} is outside of the rig, where time is not virtual; the rig has {known}")

    def _name(self, place: Address) -> bytes | None:
        """Return the name of the socket behind an address, if a server listens there."""
        held, name = self._listening.get(place, (None, b""))
        sock = held() if held is not None else None
        return name if sock is not None and sock.fileno() >= 0 else None


def _hidden_name(port: int) -> bytes:
    """Return a name that no other socket of this system has, with a port at its end."""
    return _PREFIX + next(_sequence).to_bytes(6, "big") + port.to_bytes(2, "big")


def _place(host: str, port: int) -> Address:
    """Return an address with one name for all of loopback."""
    is_loopback = host in LOOPBACK or host.startswith("127.")
    return ("" if is_loopback else host, port)


def _full(sock: socket.socket, host: str, port: int) -> Any:
    return (host, port, 0, 0) if sock.family == socket.AF_INET6 else (host, port)


def _stand_behind(sock: socket.socket, hidden: socket.socket) -> None:
    """Let `sock` lead to another socket, with the same number and the same time-out."""
    os.dup2(hidden.fileno(), sock.fileno(), inheritable=False)
    sock.settimeout(sock.gettimeout())


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
            made, hidden = _REAL["accept"](sock)
            return made, network.accepted(sock, made, hidden) if network.has(sock) else hidden

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
            return _REAL["sendto"](sock, *arguments)

        def sendall(sock: socket.socket, data: Any, *flags: int) -> None:
            if waiting_scheduler() is None:
                _REAL["sendall"](sock, data, *flags)
                return
            left = memoryview(data).cast("B")
            while left:
                _wait_until_ready(sock, is_write=True)
                left = left[_REAL["send"](sock, left, *flags) :]

        named: dict[str, Callable[..., Any]] = {
            "bind": bind, "connect": connect, "connect_ex": connect_ex, "accept": accept, "getsockname": getsockname,
            "getpeername": getpeername, "setsockopt": setsockopt, "getsockopt": getsockopt, "sendto": sendto,
            "sendall": sendall,
        }  # fmt: skip
        waiting = {name: _waiting(name, is_write=name.startswith("send")) for name in _REAL if name not in named}
        del waiting["listen"]
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


def _waiting(name: str, is_write: bool) -> Callable[..., Any]:
    real = _REAL[name]

    def method(sock: socket.socket, *arguments: Any, **options: Any) -> Any:
        _wait_until_ready(sock, is_write)
        return real(sock, *arguments, **options)

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
