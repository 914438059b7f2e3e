"""Help for tests: a link that records, ports for rigs in real time, and the plain forms of shortcuts."""

import os
import secrets
import socket
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final, Generic, TypeVar

from fieldrig.errors import ArgumentError
from fieldrig.outside.untrusted import shown
from fieldrig.shortcuts import SHORTCUTS
from fieldrig.system.file_locks import lock
from fieldrig.text.nearest import closest

__all__ = ["RecordedLink", "free_port", "plain_forms", "return_port"]

M = TypeVar("M")
PORTS: Final = range(15_000, 29_500)
"""Ports that are given to tests; the shipped rigs listen below and above."""
MOST_TRIES: Final = 100
_PORTS_OF_CONNECTIONS: Final = Path("/proc/sys/net/ipv4/ip_local_port_range")


class RecordedLink(Generic[M]):
    """A link that keeps what was sent, and delivers what the test passes in.  Interest is kept but not applied."""

    def __init__(self) -> None:
        self.sent: list[M] = []
        self.interest: Sequence[object] | None = None
        self._handler: Callable[[M], None] | None = None

    def send(self, message: M) -> None:
        self.sent.append(message)

    def on_receive(self, handler: Callable[[M], None], interest: Sequence[object] | None = None) -> None:
        self._handler, self.interest = handler, interest

    def deliver(self, message: M) -> None:
        if self._handler is not None:
            self._handler(message)

    def take(self) -> list[M]:
        """Return what was sent since the last call."""
        sent, self.sent = self.sent, []
        return sent


@contextmanager
def plain_forms(*names: str) -> Iterator[None]:
    """Have what is built in this context do all of its work: no shortcut with one of these names is taken.

    Build and run the object in the same context, because some of its parts may be built while it runs.
    """
    unknown = [name for name in names if name not in SHORTCUTS]
    if unknown:
        raise ArgumentError(f"there is no shortcut {shown(unknown[0])}", closest(unknown[0], list(SHORTCUTS)))
    places = [SHORTCUTS[name] for name in names]
    before = [shortcut.is_taken for shortcut in places]
    try:
        for shortcut in places:
            shortcut.is_taken = False
        yield
    finally:
        for shortcut, is_taken in zip(places, before, strict=True):
            shortcut.is_taken = is_taken


_kept: dict[int, int] = {}
"""The ports that this process was given, with the descriptors of the lock files that keep other processes off them.

They are open to the end of the process, at which Python would complain of each file that is an object.
"""


def free_port() -> int:
    """Return a TCP port of 127.0.0.1 that is free, and that no other living process was given by this function.

    So the workers of a parallel test run, and the jobs of one machine, don't give one port to two rigs.  On Windows
    only this process keeps its ports apart.  It is none that the system gives to the near end of a connection, where it
    says which these are: such a port could be gone before a rig listens at it.
    """
    folder = Path(tempfile.gettempdir()) / "fieldrig-ports"
    folder.mkdir(exist_ok=True)
    while True:
        port = _unused()
        if port not in _kept and (file := _locked(folder / str(port))) is not None:
            _kept[port] = file
            return port


def _unused() -> int:
    """Return a port at which nothing listens."""
    for _ in range(MOST_TRIES if _first_of_connections() >= PORTS.stop else 0):
        port = secrets.choice(PORTS)
        with socket.socket() as probe, suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        given: int = probe.getsockname()[1]
        return given


def _first_of_connections() -> int:
    """Return the first port that Linux gives to connections; 0 elsewhere."""
    try:
        return int(_PORTS_OF_CONNECTIONS.read_text(encoding="ascii").split()[0])
    except (OSError, ValueError, IndexError):
        return 0


def return_port(port: int) -> None:
    """Give a port of `free_port` back, for programs that need many of them one after another."""
    if port not in _kept:
        raise ArgumentError(f"port {shown(port)} cannot be returned", "expected a port that free_port has given")
    os.close(_kept.pop(port))


def _locked(path: Path) -> int | None:
    """Return the descriptor of the file, locked for as long as it is open; None if another process has it."""
    try:
        file = os.open(path, os.O_WRONLY | os.O_CREAT, 0o666)
    except PermissionError:  # another user's
        return None
    if not lock(file):
        os.close(file)
        return None
    return file
