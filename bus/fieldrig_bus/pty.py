"""A pseudo-terminal under a stable name, which a serial tool opens instead of `/dev/ttyUSB0`.

The name is a symbolic link, with `NAME.lock` beside it that is locked while the owner lives: a link that a killed
process left behind is replaced, and one that a living process owns is refused.  A slave end stays open, so that clients
can connect and disconnect.
Left out: Windows, which has no ptys; use a TCP variant of the same bus there.
"""

import asyncio
import logging
import os
from collections.abc import Callable
from pathlib import Path

from fieldrig.errors import BusError

try:
    import fcntl
    import termios
    import tty
except ImportError:  # Windows; `open` says so
    HAS_PTY = False
else:
    HAS_PTY = True
    BAUD = {getattr(termios, name): int(name[1:]) for name in dir(termios) if name[0] == "B" and name[1:].isdigit()}

log = logging.getLogger(__name__)

MOST_PENDING = 64 * 1024
"""Bytes kept for a client that reads slowly; data beyond that is lost, as on a line without a receiver."""


class Pty:
    """One pty, whose master end the running event loop reads."""

    def __init__(self, link: Path) -> None:
        self.path = link
        self._lock_path = link.with_name(link.name + ".lock")
        self._pending = bytearray()
        self._lock = self._master = self._slave = -1
        self._target = ""
        self._on_bytes: Callable[[bytes], None] = lambda _data: None

    def open(self, on_bytes: Callable[[bytes], None]) -> None:
        """Open the pty at `path`, and call `on_bytes` with everything that clients write.

        BusError, with its remedy, if the path is not available.
        """
        if not HAS_PTY:
            raise BusError(f"{self.path}: this system has no pseudo-terminals", "use the TCP variant of this bus")
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._take_lock()
            self._master, self._slave = os.openpty()
            tty.setraw(self._slave)
            os.set_blocking(self._master, False)
            self._target = os.ttyname(self._slave)
            self._make_link()
        except OSError as cause:
            self.close()
            raise BusError(
                f"{self.path}: {cause.strerror}", "choose a path in a folder that you may write to"
            ) from cause
        except BusError:
            self.close()
            raise
        self._on_bytes = on_bytes
        self.read_on(True)

    def read_on(self, is_wanted: bool) -> None:
        """Read from clients, or pause reading, so that the buffer of the kernel blocks them."""
        loop = asyncio.get_running_loop()
        if is_wanted:
            loop.add_reader(self._master, self._on_readable)
        else:
            loop.remove_reader(self._master)

    def write(self, data: bytes) -> None:
        """Send `data` to the client: all of it, or nothing when the client is too slow or absent."""
        if self._pending:
            self._keep(data)
            return
        try:
            written = os.write(self._master, data)
        except BlockingIOError:
            written = 0
        if written < len(data):
            asyncio.get_running_loop().add_writer(self._master, self._on_writable)
            self._pending += data[written:]

    def forget(self) -> None:
        """Discard what was written and has not been read, as on a line without a receiver."""
        if self._pending:
            self._pending.clear()
            asyncio.get_running_loop().remove_writer(self._master)
        termios.tcflush(self._slave, termios.TCIFLUSH)

    def baud(self) -> int | None:
        """The rate that the last client set; None for a rate without a name in termios."""
        return BAUD.get(termios.tcgetattr(self._slave)[5])

    def set_baud(self, baud: int) -> bool:
        """Set the initial value of `baud`.  False if the system has no name for that rate."""
        code = next((code for code, rate in BAUD.items() if rate == baud), None)
        if code is None:
            return False
        attributes = termios.tcgetattr(self._slave)
        attributes[4] = attributes[5] = code
        termios.tcsetattr(self._slave, termios.TCSANOW, attributes)
        return True

    def close(self) -> None:
        """Close the descriptors and remove the link.  Closing twice is allowed."""
        if self._master >= 0:
            self._forget_loop()
            os.close(self._master)
            os.close(self._slave)
            if self._target and self.path.is_symlink() and str(self.path.readlink()) == self._target:
                self.path.unlink()
        if self._lock >= 0:
            self._lock_path.unlink(missing_ok=True)
            os.close(self._lock)
        self._lock = self._master = self._slave = -1
        self._target = ""
        self._pending.clear()

    def _forget_loop(self) -> None:
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:  # the event loop is closed, and its readers with it
            return
        loop.remove_reader(self._master)
        loop.remove_writer(self._master)

    def _take_lock(self) -> None:
        known = self._lock_path.exists()
        if self.path.is_symlink():
            if not known and self.path.exists():
                raise BusError(f"{self.path} is a link of another program", "remove it, or choose another path")
        elif self.path.exists():
            raise BusError(f"{self.path} exists and is not a link", "move it away, or choose another path")
        self._lock = os.open(self._lock_path, os.O_RDWR | os.O_CREAT, 0o600)
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(self._lock)
            self._lock = -1  # not ours to remove
            raise BusError(
                f"{self.path} belongs to another rig that is running", "stop that rig, or choose another path"
            ) from None

    def _make_link(self) -> None:
        aside = self.path.with_name(self.path.name + ".new")
        aside.unlink(missing_ok=True)
        aside.symlink_to(self._target)
        aside.replace(self.path)

    def _on_readable(self) -> None:
        try:
            data = os.read(self._master, 65536)
        except OSError as fault:  # EAGAIN; EIO cannot be, as we hold a slave end
            log.debug("%s: %s", self.path, fault)
            return
        self._on_bytes(data)

    def _on_writable(self) -> None:
        try:
            written = os.write(self._master, self._pending)
        except BlockingIOError:
            return
        del self._pending[:written]
        if not self._pending:
            asyncio.get_running_loop().remove_writer(self._master)

    def _keep(self, data: bytes) -> None:
        if len(self._pending) + len(data) > MOST_PENDING:
            log.debug("%s: no client reads, %d bytes lost", self.path, len(data))
            return
        self._pending += data
