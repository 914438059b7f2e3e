"""A transfer over a data connection of FTP.

Source: RFC 959, 3.2 and 5.1; RFC 2428.  In passive mode the client connects, before or after its command; in active
mode the server does after the command.  A file that arrives is written when all of it is there: if its connection
breaks, the old file stays.
"""

from collections.abc import Callable
from typing import Final, Protocol

from fieldrig.clock import Alarm, Clock, S
from fieldrig_devices.connections.connection import Connection
from fieldrig_devices.ftp.replies import Reply

CONNECT_NS: Final = 30 * S
STALL_NS: Final = 60 * S
MOST_EARLY: Final = 1 << 20
"""Bytes that may arrive before the command that they belong to."""


class Job(Protocol):
    """A command that needs the data connection."""

    def content(self) -> bytes | None:
        """Return the bytes to send; None to receive."""

    def done(self, received: bytes) -> str:
        """Finish after everything was transferred, and return the reply."""

    def limit(self) -> int:
        """Return the number of bytes that may be received at most."""


class DataPort:
    """The data connection of one session.  `on_reply` is called with the reply at the end of a transfer."""

    def __init__(self, clock: Clock, on_reply: Callable[[str], None]) -> None:
        self._clock, self._on_reply = clock, on_reply
        self._transfer: _Transfer | None = None
        self._job: Job | None = None
        self._timer = Alarm(self._clock)
        self._connect: Callable[[], None] | None = None
        self.is_open = False
        """True after a PASV, EPSV, PORT or EPRT that has not been used."""

    def open(self, connect: Callable[[], None] | None = None) -> None:
        """Expect a connection of the client, or open one with `connect` at the next command; all before is over."""
        self.abort()
        self._connect = connect
        self.is_open = True

    def accept(self, connection: Connection) -> "_Transfer":
        """Take a connection of the client; a second one is closed at once."""
        transfer = _Transfer(self, connection)
        if self.is_open and self._transfer is None:
            self._transfer = transfer
            self._begin()
        else:
            connection.close()
        return transfer

    def start(self, job: Job) -> None:
        """Carry out a command on the connection, or when it is there."""
        self._job = job
        self._timer.after(CONNECT_NS, self._on_timer)
        connect, self._connect = self._connect, None
        if connect is not None:
            connect()
        self._begin()

    def refused(self) -> None:
        """Take the news that the client does not accept our connection."""
        if self._transfer is None and self.abort():
            self._on_reply(Reply.NO_DATA_CONNECTION)

    @property
    def is_busy(self) -> bool:
        return self._job is not None

    def abort(self) -> bool:
        """End without a reply.  Return true if a transfer was under way."""
        transfer, self._transfer = self._transfer, None
        was_busy, self._job, self._connect, self.is_open = self._job is not None, None, None, False
        self._timer.stop()
        if transfer is not None:
            transfer.close()
        return was_busy

    # ---- for the connection

    def moved(self) -> None:
        """Bytes have arrived, so the transfer is not stalled."""
        if self._job is not None:
            self._timer.after(STALL_NS, self._on_timer)

    def complete(self, transfer: "_Transfer", received: bytes) -> None:
        job = self._job
        if transfer is self._transfer and job is not None:
            self.abort()
            self._on_reply(job.done(received))

    def fail(self, transfer: "_Transfer", reply: str) -> None:
        if transfer is self._transfer and self.abort():
            self._on_reply(reply)

    # ---- inside

    def _begin(self) -> None:
        if self._job is None or self._transfer is None:
            return
        self._timer.after(STALL_NS, self._on_timer)
        self._on_reply(Reply.OPENING)
        content = self._job.content()
        if content is None:
            self._transfer.receive(self._job.limit())
        else:
            self._transfer.send(content)

    def _on_timer(self) -> None:
        if self._transfer is not None and self._transfer.has_moved():
            self._timer.after(STALL_NS, self._on_timer)
            return
        reply = Reply.NO_DATA_CONNECTION if self._transfer is None else Reply.TRANSFER_ABORTED
        if self.abort():
            self._on_reply(reply)


class _Transfer:
    """The session of one data connection."""

    def __init__(self, port: DataPort, connection: Connection) -> None:
        self._port, self._connection = port, connection
        self._received = bytearray()
        self._limit: int | None = None
        self._is_sending = self._has_ended = False
        self._unsent = 0

    def send(self, content: bytes) -> None:
        self._is_sending = True
        self._connection.write(content)
        self._unsent = self._connection.unsent
        if not self._connection.unsent:
            self._port.complete(self, b"")

    def has_moved(self) -> bool:
        """Return true if the client has taken bytes since the last call."""
        before, self._unsent = self._unsent, self._connection.unsent
        return self._unsent < before

    def receive(self, limit: int) -> None:
        self._limit = limit
        self._check()

    def close(self) -> None:
        self._connection.close()

    def received(self, data: bytes) -> None:
        if not self._is_sending:
            self._received += data
            self._port.moved()
            self._check()

    def drained(self) -> None:
        if self._is_sending:
            self._port.complete(self, b"")

    def ended(self) -> None:
        self._has_ended = True
        if not self._is_sending:
            self._check()

    def lost(self) -> None:
        self._port.fail(self, Reply.TRANSFER_ABORTED)

    def _check(self) -> None:
        limit = MOST_EARLY if self._limit is None else self._limit
        if len(self._received) > limit:
            self._port.fail(self, Reply.NO_SPACE)
        elif self._has_ended and self._limit is not None:
            self._port.complete(self, bytes(self._received))
