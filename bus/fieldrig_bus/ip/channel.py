"""One end of a channel of a relay, as passive code: a `Stream` that is carried by messages."""

from collections.abc import Callable
from typing import Any

from fieldrig_bus.ip.message import LARGEST, WINDOW, Closed, Consumed, Ended, Portion, RelayMessage

COMPLETE = "both ends have ended"


def _ignore(*_: Any) -> None:
    """Do nothing, for a handler that the user did not set."""


class Channel:
    def __init__(self, opener: str, number: int, is_answer: bool, emit: Callable[[RelayMessage], None]) -> None:
        """`is_answer` is True at the end that offers the service; `emit` sends messages."""
        self.on_data: Callable[[bytes], None] = _ignore
        self.on_end: Callable[[], None] = _ignore
        self.on_close: Callable[[str], None] = _ignore
        self.on_room: Callable[[], None] = _ignore
        self._id = opener, number, is_answer
        self._emit = emit
        self._unsent = bytearray()
        self._credit = WINDOW
        self._unread = bytearray()
        self._is_paused = self._is_ending = self._has_ended = self._was_full = False
        self._peer_has_ended = self._is_end_reported = False
        self.is_over = False

    @property
    def room(self) -> int:
        return max(self._credit - len(self._unsent), 0)

    @property
    def is_complete(self) -> bool:
        return self._has_ended and self._is_end_reported

    def send(self, data: bytes) -> None:
        if not (self.is_over or self._is_ending):
            self._unsent += data
            self._was_full |= self.room == 0
            self._flush()

    def end(self) -> None:
        if not (self.is_over or self._is_ending):
            self._is_ending = True
            self._flush()

    def abort(self) -> None:
        self._lose("aborted")

    def pause(self) -> None:
        self._is_paused = True

    def resume(self) -> None:
        if self._is_paused and not self.is_over:
            self._is_paused = False
            self._report()

    def take(self, message: Portion | Consumed | Ended | Closed) -> None:
        """Take a message of the other end."""
        if self.is_over:
            return
        match message:
            case Portion() if len(self._unread) + len(message.data) > WINDOW or self._peer_has_ended:
                self._lose("more data than the window or after the end")
                self.on_close("more data than the window or after the end")
            case Portion():
                self._unread += message.data
                self._report()
            case Consumed():
                self._credit = min(self._credit + message.size, WINDOW)
                self._flush()
                if self._was_full and 2 * self.room >= WINDOW and not self._is_ending:
                    self._was_full = False
                    self.on_room()
            case Ended():
                self._peer_has_ended = True
                self._report()
            case Closed():
                self.is_over = True
                self.on_close(message.why)

    def _flush(self) -> None:
        while self._unsent and self._credit:
            data = bytes(self._unsent[: min(self._credit, LARGEST)])
            del self._unsent[: len(data)]
            self._credit -= len(data)
            self._emit(Portion(*self._id, data))
        if self._is_ending and not self._unsent and not self._has_ended:
            self._has_ended = True
            self.is_over = is_last = self.is_complete
            self._emit(Ended(*self._id))
            if is_last:
                self.on_close(COMPLETE)

    def _report(self) -> None:
        while self._unread and not (self._is_paused or self.is_over):
            data = bytes(self._unread)
            self._unread.clear()
            self.on_data(data)
            if not self.is_over:
                self._emit(Consumed(*self._id, len(data)))
        is_read = not (self._unread or self._is_paused)
        if self._peer_has_ended and is_read and not (self._is_end_reported or self.is_over):
            self._is_end_reported = True
            self.on_end()
            if self.is_complete and not self.is_over:
                self.is_over = True
                self.on_close(COMPLETE)

    def _lose(self, why: str) -> None:
        if not self.is_over:
            self.is_over = True
            self._emit(Closed(*self._id, why))
