"""A pseudo-terminal under a stable name, which a serial tool opens instead of `/dev/ttyUSB0`.

The name is a symbolic link, with `NAME.lock` beside it that is locked while the owner lives: a link that a killed
process left behind is replaced, and one that a living process owns is refused.  A lock is known by its content, so no
file of another program is taken for one, and deleted.  Clients can connect and disconnect.

An owner that wants to know whether a client is there gets it from two sources: the master end hangs up when the last
client has closed the slave, however it ended, and a watch of the slave's name reports who opens it.  The slave then is
open in no other process than the clients', and what is written while there is none is lost, as at a serial port that no
program has opened.  For other owners a slave end stays open, and keeps what is written for the next client.
Left out: Windows, which has no ptys, and where this module cannot be imported (`terminal` says what to use instead).
"""

import asyncio
import fcntl
import logging
import os
import secrets
import select
import sys
import termios
import tty
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from fieldrig.errors import BusError
from fieldrig.system.file_locks import lock
from fieldrig.system.own_files import open_own
from fieldrig_bus.open_watch import OpenWatch

assert sys.platform != "win32", "Windows has no pseudo-terminals"

BAUD = {getattr(termios, name): int(name[1:]) for name in dir(termios) if name[0] == "B" and name[1:].isdigit()}

log = logging.getLogger(__name__)

LOCK = b"fieldrig: a pty is in use\n"
"""Content of a lock."""
N_TTY = 0
"""The usual line discipline of Linux."""
MOST_PENDING = 64 * 1024
"""Bytes kept for a client that reads slowly; data beyond that is lost, as on a line without a receiver."""


class _Slave(NamedTuple):
    """The slave end, as the master end sees it."""

    is_left: bool
    """True if no client has it open."""
    has_data: bool
    """True if there is something to read."""


class Pty:
    """One pty, whose master end the running event loop reads."""

    def __init__(self, link: Path) -> None:
        self.path = link
        self._lock_path = link.with_name(link.name + ".lock")
        self._pending = bytearray()
        self._lock = self._master = self._slave = -1
        self._target = ""
        self._was_there = False
        """True if the lock was there already."""
        self._watch: OpenWatch | None = None
        self._clients = 0
        self._is_present = False
        self._is_read_on = False
        self._on_bytes: Callable[[bytes], None] = lambda _data: None
        self._on_presence: Callable[[bool], None] | None = None

    def open(self, on_bytes: Callable[[bytes], None], on_presence: Callable[[bool], None] | None = None) -> None:
        """Open the pty at `path`, and call `on_bytes` with everything that clients write.

        `on_presence(True)` is called when a client has opened the pty, and `on_presence(False)` when the last one has
        closed it, after everything that it wrote.  Where the system does not report who opens the pty, a client counts
        as present all the time.
        BusError, with its remedy, if the path is not available.
        """
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._take_lock()
            self._make()
            if on_presence is not None:
                self._begin_watch()
            self._make_link()
        except OSError as cause:
            self.close()
            raise BusError(
                f"{self.path}: {cause.strerror}", "choose a path in a folder that you may write to"
            ) from cause
        except BusError:
            self.close()
            raise
        self._on_bytes, self._on_presence = on_bytes, on_presence
        self._is_read_on = True
        self._wait_for_clients()

    def read_on(self, is_wanted: bool) -> None:
        """Read from clients, or pause reading, so that the buffer of the kernel blocks them."""
        self._is_read_on = is_wanted
        loop = asyncio.get_running_loop()
        if is_wanted and self._is_present:  # without a client, the master is readable all the time
            loop.add_reader(self._master, self._on_readable)
        else:
            loop.remove_reader(self._master)

    def write(self, data: bytes) -> None:
        """Send `data` to the client: all of it, or nothing when the client is too slow or absent."""
        if self._pending:
            self._keep(data)
            return
        if not self._is_present and self._look().is_left:  # the kernel might keep it for the next client
            log.debug("%s: no client, %d bytes lost", self.path, len(data))
            return
        try:
            written = os.write(self._master, data)
        except BlockingIOError:
            written = 0
        except OSError as fault:  # EIO: the client has closed the pty
            log.debug("%s: %s, %d bytes lost", self.path, fault, len(data))
            return
        if written < len(data):
            asyncio.get_running_loop().add_writer(self._master, self._on_writable)
            self._pending += data[written:]

    def forget(self) -> None:
        """Discard what was written and has not been read, as on a line without a receiver.

        Only for an owner that does not ask for the presence of clients.
        """
        if self._pending:
            self._pending.clear()
            asyncio.get_running_loop().remove_writer(self._master)
        termios.tcflush(self._slave, termios.TCIFLUSH)

    def baud(self) -> int | None:
        """The rate that the last client set; None for a rate without a name in termios."""
        return BAUD.get(termios.tcgetattr(self._master)[5])  # the master shows the settings of the slave

    def set_baud(self, baud: int) -> bool:
        """Set the initial value of `baud`.  False if the system has no name for that rate."""
        code = next((code for code, rate in BAUD.items() if rate == baud), None)
        if code is None:
            return False
        attributes = termios.tcgetattr(self._master)
        attributes[4] = attributes[5] = code
        termios.tcsetattr(self._master, termios.TCSANOW, attributes)
        return True

    def close(self) -> None:
        """Close the descriptors and remove the link.  Closing twice is allowed."""
        if self._master >= 0:
            self._drop()
            if self._target and self.path.is_symlink() and str(self.path.readlink()) == self._target:
                self.path.unlink()
        if self._lock >= 0:
            self._lock_path.unlink(missing_ok=True)
            os.close(self._lock)
        self._lock = -1
        self._target = ""

    def _make(self) -> None:
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self._target = os.ttyname(self._slave)

    def _drop(self) -> None:
        """Close what `_make` and `_begin_watch` have opened."""
        self._forget_loop()
        os.close(self._master)
        if self._slave >= 0:
            os.close(self._slave)
        if self._watch is not None:
            self._watch.close()
        self._watch = None
        self._master = self._slave = -1
        self._pending.clear()

    def _forget_loop(self) -> None:
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:  # the event loop is closed, and its readers with it
            return
        loop.remove_reader(self._master)
        loop.remove_writer(self._master)
        if self._watch is not None:
            loop.remove_reader(self._watch.fd)

    def _take_lock(self) -> None:
        self._was_there = self._lock_path.exists()
        if self.path.is_symlink():
            if not self._was_there and self.path.exists():
                raise BusError(f"{self.path} is a link of another program", "remove it, or choose another path")
        elif self.path.exists():
            raise BusError(f"{self.path} exists and is not a link", "move it away, or choose another path")
        file = open_own(self._lock_path, os.O_RDWR | os.O_CREAT)
        try:
            if not lock(file):
                raise BusError(
                    f"{self.path} belongs to another rig that is running", "stop that rig, or choose another path"
                )
            if not self._is_lock(os.read(file, len(LOCK) + 1)):
                raise BusError(
                    f"{self._lock_path} is a file of another program", "move it away, or choose another path"
                )
            os.pwrite(file, LOCK, 0)
        except BusError:
            os.close(file)  # not ours to remove
            raise
        self._lock = file

    def _is_lock(self, content: bytes) -> bool:
        """Return whether the file has the content of a lock; those of earlier versions are empty, beside their link."""
        return content == LOCK or (not content and (not self._was_there or self.path.is_symlink()))

    def _make_link(self) -> None:
        """Make the link in one step, under a name that nothing else has until then."""
        aside = self.path.with_name(f".{self.path.name}.{secrets.token_hex(8)}")
        aside.symlink_to(self._target)
        aside.replace(self.path)

    # ---- presence of clients

    def _begin_watch(self) -> None:
        try:
            self._watch = OpenWatch(self._target)
        except OSError as fault:
            log.debug("%s: %s; a client counts as present", self.path, fault)
            return
        os.close(self._slave)
        self._slave = -1
        for _ in self._watch.events():
            """Ours, as no client knows the name yet."""

    def _wait_for_clients(self) -> None:
        if self._watch is not None:
            asyncio.get_running_loop().add_reader(self._watch.fd, self._on_opened)
        else:
            self._say_present(True)

    def _on_opened(self) -> None:
        """Count the clients; if the count disagrees with the master end, the latter is right."""
        assert self._watch is not None
        has_hung_up = self._clients <= 0  # if a client is present, it has gone meanwhile
        for is_opened in self._watch.events():
            self._clients += 1 if is_opened else -1
            has_hung_up |= self._clients <= 0
        slave = self._look()
        if slave.is_left:
            self._clients = 0
            if slave.has_data:  # of a client that has come and gone; otherwise `_on_readable` sees the end
                self._say_present(True)
            return
        if self._is_present and has_hung_up and self._clients > 0:
            self._end_of_client()  # and another one has come at once
        self._clients = max(self._clients, 1)
        self._say_present(True)

    def _look(self) -> "_Slave":
        poll = select.poll()
        poll.register(self._master, select.POLLIN)
        events = sum(mask for _, mask in poll.poll(0))
        return _Slave(bool(events & select.POLLHUP), bool(events & select.POLLIN))

    def _say_present(self, is_present: bool) -> None:
        if is_present is self._is_present:
            return
        self._is_present = is_present
        if self._on_presence is not None:
            self._on_presence(is_present)
        self.read_on(self._is_read_on)

    def _end_of_client(self) -> None:
        """Discard what the last client has not read, as closing a serial port does."""
        self._pending.clear()
        asyncio.get_running_loop().remove_writer(self._master)
        self._say_present(False)

    def _on_hang_up(self) -> None:
        self._clients = 0
        self._end_of_client()
        try:
            self._clean()
        except OSError as fault:  # EBUSY: a client that was killed had reserved the pty for itself (TIOCEXCL)
            log.debug("%s: %s: %s", self.path, self._target, fault)
            self._replace()

    def _clean(self) -> None:
        """Take from the slave what a client that was killed has left: its line discipline, such as PPP, and data."""
        slave = os.open(self._target, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        try:
            fcntl.ioctl(slave, termios.TIOCSETD, N_TTY.to_bytes(4, sys.byteorder))
            termios.tcflush(slave, termios.TCIFLUSH)
        finally:
            os.close(slave)

    def _replace(self) -> None:
        """Make another pty with the same settings."""
        attributes = termios.tcgetattr(self._master)
        self._drop()
        self._make()
        termios.tcsetattr(self._master, termios.TCSANOW, attributes)
        self._begin_watch()
        self._make_link()
        self._wait_for_clients()

    # ---- data

    def _on_readable(self) -> None:
        try:
            data = os.read(self._master, 65536)
        except BlockingIOError:
            return
        except OSError as fault:  # EIO: the last client has closed the pty, and we have everything that it wrote
            log.debug("%s: %s", self.path, fault)
            if self._watch is not None:
                self._on_hang_up()
            return
        self._on_bytes(data)

    def _on_writable(self) -> None:
        try:
            written = os.write(self._master, self._pending)
        except BlockingIOError:
            return
        except OSError as fault:  # EIO, which a read will see as well
            log.debug("%s: %s, %d bytes lost", self.path, fault, len(self._pending))
            written = len(self._pending)
        del self._pending[:written]
        if not self._pending:
            asyncio.get_running_loop().remove_writer(self._master)

    def _keep(self, data: bytes) -> None:
        if len(self._pending) + len(data) > MOST_PENDING:
            log.debug("%s: no client reads, %d bytes lost", self.path, len(data))
            return
        self._pending += data
