"""Functions 11 and 12: the counter of completed messages at a server's port, and the log of the last 64 events there.

Source: Modbus application protocol V1.1b3, 6.9 and 6.10.  A program command that is still being processed does not
occur here, so the status is 0; nor do overruns, busy servers, and time-outs of writes.
"""

from collections import deque
from typing import Final

MOST_EVENTS: Final = 64
RECEIVED, SENT = 0x80, 0x40
"""The bits that say what kind of event a byte is."""
COMMUNICATION_ERROR, IN_LISTEN_ONLY, BROADCAST = 0x02, 0x20, 0x40
"""Bits of a received message: damaged frames before it, listen only mode, a broadcast."""
READ_EXCEPTION, ABORT_EXCEPTION, BUSY_EXCEPTION, PROGRAM_NAK = 0x01, 0x02, 0x04, 0x08
"""Bits of a response with exception code 1 to 3, 4, 5 to 6, and 7."""
ENTERED_LISTEN_ONLY, RESTARTED = 0x04, 0x00
_EXCEPTION_BITS: Final = dict(
    zip(
        range(1, 8),
        (READ_EXCEPTION,) * 3 + (ABORT_EXCEPTION,) + (BUSY_EXCEPTION,) * 2 + (PROGRAM_NAK,),
        strict=True,
    )
)
FETCHES: Final = frozenset({0x0B, 0x0C})
"""Functions that read the counter do not count themselves (6.9)."""


class EventLog:
    """The events of one port since its power-up, the latest first."""

    def __init__(self) -> None:
        self.completed = 0
        """Messages that were executed without an exception, but for `FETCHES`."""
        self._events: deque[int] = deque(maxlen=MOST_EVENTS)

    def receive(self, is_broadcast: bool, is_after_errors: bool, is_listening_only: bool) -> None:
        """Note a message, before it is executed."""
        self._events.appendleft(
            RECEIVED
            | BROADCAST * is_broadcast
            | COMMUNICATION_ERROR * is_after_errors
            | IN_LISTEN_ONLY * is_listening_only
        )

    def send(self, function: int, exception: int, is_listening_only: bool) -> None:
        """Note that a message has been executed, whether or not there is a response; exception 0 is none."""
        if exception == 0 and function not in FETCHES:
            self.completed = self.completed + 1 & 0xFFFF
        self._events.appendleft(SENT | _EXCEPTION_BITS.get(exception, 0) | IN_LISTEN_ONLY * is_listening_only)

    def enter_listen_only(self) -> None:
        self._events.appendleft(ENTERED_LISTEN_ONLY)

    def restart(self, is_cleared: bool) -> None:
        """Note a restart of communications, which clears the counter, and if wanted the older events."""
        self.completed = 0
        if is_cleared:
            self._events.clear()
        self._events.appendleft(RESTARTED)

    def clear_counter(self) -> None:
        self.completed = 0

    def counter(self) -> bytes:
        """The data of the response to function 11: status and counter."""
        return b"\x00\x00" + self.completed.to_bytes(2, "big")

    def log(self, messages: int) -> bytes:
        """The data of the response to function 12: its length, status, counter, number of messages, and events."""
        data = self.counter() + (messages & 0xFFFF).to_bytes(2, "big") + bytes(self._events)
        return bytes((len(data),)) + data
