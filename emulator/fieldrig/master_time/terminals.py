"""The serial ports of the rig, which members of a block open by the path that they have in real time.

A pseudo-terminal of the system delivers its bytes when its kernel thread runs, so a run would depend on the host.  Here
a port is one end of a pair of sockets.  On POSIX, the calls for terminals know it (`terminal_calls`), so pyserial, and
every library that uses it, works as it is.
"""

import asyncio
import os
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

MOST_PENDING: Final = 64 * 1024
"""Bytes kept for a program that reads slowly; data beyond that is lost, as on a line without a receiver."""
DTR, RTS, CTS, CD, RI, DSR = 0x2, 0x4, 0x20, 0x40, 0x80, 0x100
"""The bits of TIOCMGET, on Linux and on macOS."""
BAUD: Final = 9600
"""The rate of a port before a program sets it."""


class Terminal:
    """One serial port, as the rig's end of it sees it; it has the calls of `fieldrig_bus.terminal.Terminal`."""

    def __init__(self, terminals: "Terminals", path: Path | str) -> None:
        self.path = path
        self._terminals = terminals
        self._client: socket.socket | None = None
        self._is_read_on = True
        self._on_bytes: Callable[[bytes], None] = lambda _: None
        self._on_presence: Callable[[bool], None] | None = None
        self.attributes: list[Any] | None = None
        """The list that a program gave to `tcsetattr`; None before."""
        self.rate: int | None = BAUD
        """The rate that the program has set; None for one that is not known."""
        self.outputs = DTR | RTS
        self.inputs = CTS | DSR | CD
        """The control lines that the program reads, as bits of TIOCMGET."""
        self.on_outputs: Callable[[bool, bool], None] | None = None
        """Called with DTR and RTS when the program sets them."""
        self.on_break: Callable[[], None] | None = None

    def open(self, on_bytes: Callable[[bytes], None], on_presence: Callable[[bool], None] | None = None) -> None:
        """Call `on_bytes` with what a program writes, and `on_presence` when one opens and closes the port."""
        self._on_bytes, self._on_presence = on_bytes, on_presence
        self._terminals.by_path[_name(self.path)] = self

    def close(self) -> None:
        self._terminals.by_path.pop(_name(self.path), None)
        self._drop()

    def read_on(self, is_wanted: bool) -> None:
        self._is_read_on = is_wanted
        if self._client is not None:
            self._watch()

    def write(self, data: bytes) -> None:
        """Send to the program: all of it, or nothing if it is too slow or absent."""
        if self._client is None:
            return
        try:
            self._client.send(data)
        except OSError:
            return

    def forget(self) -> None:
        """Keep nothing for a program that comes later; there is nothing."""

    def baud(self) -> int | None:
        return self.rate

    def set_baud(self, baud: int) -> bool:
        self.rate = baud
        return True

    # ---- the program

    def plug_in(self) -> socket.socket:
        """Return the end of a program that opens the port."""
        near, far = socket.socketpair()
        near.setblocking(False)
        far.setblocking(False)
        far.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, MOST_PENDING)
        self._terminals.call(self._on_opened, far)
        return near

    def set_outputs(self, outputs: int) -> None:
        """Take the control lines of the program, as bits of TIOCMGET."""
        self.outputs = outputs & (DTR | RTS)
        self._terminals.call(Terminal._tell_outputs, self)

    def send_break(self) -> None:
        if self.on_break is not None:
            self._terminals.call(Terminal._tell_break, self)

    def _tell_outputs(self) -> None:
        if self.on_outputs is not None:
            self.on_outputs(bool(self.outputs & DTR), bool(self.outputs & RTS))

    def _tell_break(self) -> None:
        if self.on_break is not None:
            self.on_break()

    def _on_opened(self, far: socket.socket) -> None:
        self._drop()  # a port has one program; another one takes the line over
        self._client = far
        if self._on_presence is not None:
            self._on_presence(True)
        self._watch()

    def _watch(self) -> None:
        assert self._client is not None
        loop = asyncio.get_running_loop()
        if self._is_read_on:
            loop.add_reader(self._client.fileno(), self._on_readable)
        else:
            loop.remove_reader(self._client.fileno())

    def _on_readable(self) -> None:
        if self._client is None:
            return
        try:
            data = self._client.recv(65536)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if data:
            self._on_bytes(data)
            return
        self._drop()
        if self._on_presence is not None:
            self._on_presence(False)

    def _drop(self) -> None:
        if self._client is not None:
            asyncio.get_running_loop().remove_reader(self._client.fileno())
            self._client.close()
            self._client = None


class Terminals:
    """The serial ports of one block."""

    def __init__(self, call: Callable[..., None], find: Callable[[str], Terminal | None]) -> None:
        """`call` calls a function with its argument in the event loop of the ports.

        `find` returns the port behind a URL of a line, such as `fieldrig://com1`.
        """
        self.call, self._find = call, find
        self.by_path: dict[str, Terminal] = {}
        self._opened: dict[int, tuple[Terminal, tuple[int, int]]] = {}

    @property
    def are_open(self) -> bool:
        """True if a program may have one of them open."""
        return bool(self._opened)

    @property
    def names(self) -> str:
        """Their paths, for a message."""
        return ", ".join(sorted(self.by_path)) or "no serial port"

    def find(self, path: str) -> Terminal | None:
        """Return the port at a path, or behind the URL of a line."""
        return self.by_path.get(_name(path)) or self._find(path)

    def open(self, terminal: Terminal) -> int:
        """Return a descriptor of a program that opens this port."""
        return self.connect(terminal).detach()

    def connect(self, terminal: Terminal) -> socket.socket:
        """Return the end of a program that opens this port."""
        near = terminal.plug_in()
        self._opened[near.fileno()] = terminal, _identity(near.fileno())
        return near

    def behind(self, descriptor: int) -> Terminal | None:
        """Return the port behind a descriptor, unless that was closed meanwhile and leads elsewhere."""
        terminal, identity = self._opened.get(descriptor, (None, (0, 0)))
        if terminal is not None and _identity(descriptor) != identity:
            del self._opened[descriptor]
            return None
        return terminal


def _name(path: str | os.PathLike[str]) -> str:
    text = os.fspath(path)
    return text if "://" in text else str(Path(text).absolute())


def _identity(descriptor: int) -> tuple[int, int]:
    try:
        found = os.fstat(descriptor)
    except OSError:
        return (0, 0)
    return found.st_dev, found.st_ino
