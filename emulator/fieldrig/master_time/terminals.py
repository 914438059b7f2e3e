"""The serial ports of the rig, which members of a block open by the path that they have in real time.

A pseudo-terminal of the system delivers its bytes when its kernel thread runs, so a run would depend on the host.  Here
a port is one end of a pair of sockets, and the calls for terminals (`os.open`, `termios`, `fcntl.ioctl`) know it.  So
pyserial, and every library that uses it, works as it is.
Left out: canonical input and other processing of characters; a serial port that a machine is connected to has none.
"""

import asyncio
import errno
import fcntl
import os
import socket
import struct
import termios
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from fieldrig.master_time.active import seeing_scheduler
from fieldrig.master_time.scheduler import Place
from fieldrig.master_time.threads import refused

MOST_PENDING: Final = 64 * 1024
"""Bytes kept for a program that reads slowly; data beyond that is lost, as on a line without a receiver."""
BAUD: Final = {getattr(termios, name): int(name[1:]) for name in dir(termios) if name[0] == "B" and name[1:].isdigit()}
SPECIAL_SPEED: Final = {0x802C542A, 0x402C542B}
"""TCGETS2 and TCSETS2, with which pyserial sets a rate without a name."""
SPECIAL_ISPEED: Final = 9
"""Place of the input speed among the integers of struct termios2 of Linux."""
SET_BREAK: Final = 0x5427
"""TIOCSBRK of Linux, for which Python has no name; TIOCCBRK is the next one."""
CLEAR_BREAK: Final = 0x5428
DEVICES: Final = "/dev/"
NO_DEVICE: Final = ("/dev/null", "/dev/zero", "/dev/random", "/dev/urandom", "/dev/shm/", "/dev/fd/", "/dev/std")
_DEFAULT: Final = [0, 0, termios.CS8 | termios.CREAD | termios.CLOCAL, 0, termios.B9600, termios.B9600, [b"\0"] * 32]
_real_open, _real_ioctl, _real_flock = os.open, fcntl.ioctl, fcntl.flock
_REAL: Final = {
    name: getattr(termios, name) for name in ("tcgetattr", "tcsetattr", "tcflush", "tcdrain", "tcflow", "tcsendbreak")
}


class Terminal:
    """One serial port, as the rig's end of it sees it; it has the calls of `fieldrig_bus.pty.Pty`."""

    def __init__(self, terminals: "Terminals", path: Path | str) -> None:
        self.path = path
        self._terminals = terminals
        self._client: socket.socket | None = None
        self._is_read_on = True
        self._on_bytes: Callable[[bytes], None] = lambda _: None
        self._on_presence: Callable[[bool], None] | None = None
        self.attributes: list[Any] = list(_DEFAULT)
        """The list that `tcgetattr` returns."""
        self.special_baud: int | None = None
        """A rate without a name in termios."""
        self.outputs = termios.TIOCM_DTR | termios.TIOCM_RTS
        self.inputs = termios.TIOCM_CTS | termios.TIOCM_DSR | termios.TIOCM_CD
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
        return self.special_baud or BAUD.get(self.attributes[5])

    def set_baud(self, baud: int) -> bool:
        code = next((code for code, rate in BAUD.items() if rate == baud), None)
        if code is not None:
            self.attributes[4] = self.attributes[5] = code
        return code is not None

    # ---- the program

    def plug_in(self) -> int:
        """Return a descriptor of a program that opens the port."""
        near, far = socket.socketpair()
        near.setblocking(False)
        far.setblocking(False)
        far.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, MOST_PENDING)
        self._terminals.call(self._on_opened, far)
        return near.detach()

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
    """The serial ports of one block, and the calls that reach them."""

    def __init__(self, call: Callable[..., None], find: Callable[[str], Terminal | None]) -> None:
        """`call` calls a function with its argument in the event loop of the ports.

        `find` returns the port behind a URL of a line, such as `fieldrig://com1`.
        """
        self.call, self._find = call, find
        self.by_path: dict[str, Terminal] = {}
        self._by_descriptor: dict[int, tuple[Terminal, tuple[int, int]]] = {}

    @property
    def are_open(self) -> bool:
        """True if a program may have one of them open."""
        return bool(self._by_descriptor)

    def swaps(self) -> list[tuple[Any, Any]]:
        """Return the calls of the system, each with its stand-in."""
        named = {name: getattr(self, name) for name in _REAL}
        return [
            (_real_open, self.open),
            (_real_ioctl, self.ioctl),
            (_real_flock, self.flock),
            *((_REAL[name], stand_in) for name, stand_in in named.items()),
        ]

    def open(self, path: Any, flags: int, mode: int = 0o777, *, dir_fd: int | None = None) -> int:
        scheduler = seeing_scheduler()
        if scheduler is None or not isinstance(path, str | os.PathLike):
            return _real_open(path, flags, mode, dir_fd=dir_fd)
        text = os.fspath(path)
        terminal = self.by_path.get(_name(text)) or self._find(text)
        if terminal is not None:
            descriptor = terminal.plug_in()
            self._by_descriptor[descriptor] = terminal, _identity(descriptor)
            return descriptor
        if text.startswith(DEVICES) and not text.startswith(NO_DEVICE):
            known = ", ".join(sorted(self.by_path)) or "no serial port"
            raise refused(scheduler, f"{text} is a device of this host, where time is not virtual; the rig has {known}")
        return _real_open(path, flags, mode, dir_fd=dir_fd)

    def tcgetattr(self, descriptor: Any) -> Any:
        terminal = self._terminal(descriptor)
        return _REAL["tcgetattr"](descriptor) if terminal is None else _copied(terminal.attributes)

    def tcsetattr(self, descriptor: Any, when: int, attributes: Any) -> None:
        terminal = self._terminal(descriptor)
        if terminal is None:
            _REAL["tcsetattr"](descriptor, when, attributes)
            return
        terminal.special_baud = None
        terminal.attributes = _copied(attributes)

    def tcflush(self, descriptor: Any, queue: int) -> None:
        if self._terminal(descriptor) is None:
            _REAL["tcflush"](descriptor, queue)
        elif queue in (termios.TCIFLUSH, termios.TCIOFLUSH):
            _empty(_number(descriptor))

    def tcdrain(self, descriptor: Any) -> None:
        if self._terminal(descriptor) is None:
            _REAL["tcdrain"](descriptor)

    def tcflow(self, descriptor: Any, action: int) -> None:
        if self._terminal(descriptor) is None:
            _REAL["tcflow"](descriptor, action)

    def tcsendbreak(self, descriptor: Any, duration: int) -> None:
        terminal = self._terminal(descriptor)
        if terminal is None:
            _REAL["tcsendbreak"](descriptor, duration)
        elif terminal.on_break is not None:
            self.call(_tell_break, terminal)

    def flock(self, descriptor: Any, operation: int) -> None:
        if self._terminal(descriptor) is None:
            _real_flock(descriptor, operation)

    def ioctl(self, descriptor: Any, request: int, argument: Any = 0, mutate: bool = True) -> Any:
        terminal = self._terminal(descriptor)
        if terminal is None or request in (termios.FIONREAD, termios.TIOCOUTQ):
            return _real_ioctl(descriptor, request, argument, mutate)
        if request & 0xFFFF_FFFF in SPECIAL_SPEED:
            if request & 0xFFFF_FFFF == 0x402C542B:
                terminal.special_baud = argument[SPECIAL_ISPEED]
            return 0
        return self._control(terminal, request, argument)

    def _control(self, terminal: Terminal, request: int, argument: Any) -> Any:
        """Read or set control lines.  OSError for a request that a serial port does not have."""
        bits = struct.unpack("I", argument)[0] if isinstance(argument, bytes) and len(argument) == 4 else 0
        if request == termios.TIOCMGET:
            return struct.pack("I", terminal.outputs | terminal.inputs)
        if request in (termios.TIOCMBIS, termios.TIOCMBIC, termios.TIOCMSET):
            kept = {
                termios.TIOCMBIS: terminal.outputs | bits,
                termios.TIOCMBIC: terminal.outputs & ~bits,
                termios.TIOCMSET: bits,
            }
            terminal.outputs = kept[request] & (termios.TIOCM_DTR | termios.TIOCM_RTS)
            self.call(_tell_outputs, terminal)
        elif request == SET_BREAK and terminal.on_break is not None:
            self.call(_tell_break, terminal)
        elif request not in (SET_BREAK, CLEAR_BREAK, termios.TIOCEXCL, termios.TIOCNXCL):
            raise OSError(errno.ENOTTY, os.strerror(errno.ENOTTY))
        return 0

    def _terminal(self, descriptor: Any) -> Terminal | None:
        """Return the port behind a descriptor, unless that was closed meanwhile and leads elsewhere."""
        scheduler = seeing_scheduler()
        if scheduler is None or scheduler.place is not Place.MEMBER or not self._by_descriptor:
            return None
        number = _number(descriptor)
        terminal, identity = self._by_descriptor.get(number, (None, (0, 0)))
        if terminal is not None and _identity(number) != identity:
            del self._by_descriptor[number]
            return None
        return terminal


def _tell_outputs(terminal: Terminal) -> None:
    if terminal.on_outputs is not None:
        outputs = terminal.outputs
        terminal.on_outputs(bool(outputs & termios.TIOCM_DTR), bool(outputs & termios.TIOCM_RTS))


def _tell_break(terminal: Terminal) -> None:
    if terminal.on_break is not None:
        terminal.on_break()


def _name(path: str | os.PathLike[str]) -> str:
    text = os.fspath(path)
    return text if "://" in text else str(Path(text).absolute())


def _number(descriptor: Any) -> int:
    return descriptor if isinstance(descriptor, int) else int(descriptor.fileno())


def _identity(descriptor: int) -> tuple[int, int]:
    try:
        found = os.fstat(descriptor)
    except OSError:
        return (0, 0)
    return found.st_dev, found.st_ino


def _copied(attributes: Any) -> list[Any]:
    return [list(each) if isinstance(each, list) else each for each in attributes]


def _empty(descriptor: int) -> None:
    """Discard what has arrived."""
    try:
        while os.read(descriptor, 65536):
            pass
    except OSError:
        return
