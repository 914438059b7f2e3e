"""The calls for terminals of POSIX, which lead a member of a block to the serial ports of the rig.

Left out: canonical input and other processing of characters; a serial port that a machine is connected to has none.
"""

import errno
import fcntl
import os
import struct
import sys
import termios
from typing import Any, Final

from fieldrig.master_time.active import seeing_scheduler
from fieldrig.master_time.scheduler import Place
from fieldrig.master_time.terminals import DTR, RTS, Terminal, Terminals
from fieldrig.master_time.threads import refused

assert sys.platform != "win32", "Windows has neither of the two modules"

BAUD: Final = {getattr(termios, name): int(name[1:]) for name in dir(termios) if name[0] == "B" and name[1:].isdigit()}
SPECIAL_SPEED: Final = {0x802C542A, 0x402C542B}
"""TCGETS2 and TCSETS2 of Linux, with which pyserial sets a rate without a name."""
SET_SPECIAL_SPEED: Final = 0x402C542B
SPECIAL_ISPEED: Final = 9
"""Place of the input speed among the integers of struct termios2 of Linux."""
SET_BREAK: Final = 0x5427
"""TIOCSBRK of Linux, for which Python has no name; TIOCCBRK is the next one."""
CLEAR_BREAK: Final = 0x5428
DEVICES: Final = "/dev/"
NO_DEVICE: Final = ("/dev/null", "/dev/zero", "/dev/random", "/dev/urandom", "/dev/shm/", "/dev/fd/", "/dev/std")
_MODES: Final = termios.CS8 | termios.CREAD | termios.CLOCAL
_real_open, _real_ioctl, _real_flock = os.open, fcntl.ioctl, fcntl.flock
_REAL: Final = {
    name: getattr(termios, name) for name in ("tcgetattr", "tcsetattr", "tcflush", "tcdrain", "tcflow", "tcsendbreak")
}


class TerminalCalls:
    """Stand-ins for the calls of the system that open and set terminals."""

    def __init__(self, terminals: Terminals) -> None:
        self._terminals = terminals

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
        terminal = self._terminals.find(text)
        if terminal is not None:
            return self._terminals.open(terminal)
        if text.startswith(DEVICES) and not text.startswith(NO_DEVICE):
            known = self._terminals.names
            raise refused(scheduler, f"{text} is a device of this host, where time is not virtual; the rig has {known}")
        return _real_open(path, flags, mode, dir_fd=dir_fd)

    def tcgetattr(self, descriptor: Any) -> Any:
        terminal = self._terminal(descriptor)
        return _REAL["tcgetattr"](descriptor) if terminal is None else _copied(_attributes(terminal))

    def tcsetattr(self, descriptor: Any, when: int, attributes: Any) -> None:
        terminal = self._terminal(descriptor)
        if terminal is None:
            _REAL["tcsetattr"](descriptor, when, attributes)
            return
        terminal.attributes = _copied(attributes)
        terminal.rate = BAUD.get(attributes[5])

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
        else:
            terminal.send_break()

    def flock(self, descriptor: Any, operation: int) -> None:
        if self._terminal(descriptor) is None:
            _real_flock(descriptor, operation)

    def ioctl(self, descriptor: Any, request: int, argument: Any = 0, mutate: bool = True) -> Any:
        terminal = self._terminal(descriptor)
        if terminal is None or request in (termios.FIONREAD, termios.TIOCOUTQ):
            return _real_ioctl(descriptor, request, argument, mutate)
        if request & 0xFFFF_FFFF in SPECIAL_SPEED:
            if request & 0xFFFF_FFFF == SET_SPECIAL_SPEED:
                terminal.rate = argument[SPECIAL_ISPEED]
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
            terminal.set_outputs(kept[request] & (DTR | RTS))
        elif request == SET_BREAK:
            terminal.send_break()
        elif request not in (CLEAR_BREAK, termios.TIOCEXCL, termios.TIOCNXCL):
            raise OSError(errno.ENOTTY, os.strerror(errno.ENOTTY))
        return 0

    def _terminal(self, descriptor: Any) -> Terminal | None:
        scheduler = seeing_scheduler()
        if scheduler is None or scheduler.place is not Place.MEMBER or not self._terminals.are_open:
            return None
        return self._terminals.behind(_number(descriptor))


def _attributes(terminal: Terminal) -> list[Any]:
    """Return the list of `tcgetattr`."""
    if terminal.attributes is not None:
        return terminal.attributes
    code = next((code for code, rate in BAUD.items() if rate == terminal.rate), termios.B9600)
    return [0, 0, _MODES, 0, code, code, [b"\0"] * 32]


def _number(descriptor: Any) -> int:
    return descriptor if isinstance(descriptor, int) else int(descriptor.fileno())


def _copied(attributes: Any) -> list[Any]:
    return [list(each) if isinstance(each, list) else each for each in attributes]


def _empty(descriptor: int) -> None:
    """Discard what has arrived."""
    try:
        while os.read(descriptor, 65536):
            pass
    except OSError:
        return
