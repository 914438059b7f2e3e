"""A stream of bytes in both directions, as passive code: a connection of a TCP/IP stack, or a channel of a relay."""

from collections.abc import Callable
from typing import Any, Protocol


class Stream(Protocol):
    """One end of a stream.  Its user sets the handlers."""

    on_data: Callable[[bytes], None]
    on_end: Callable[[], None]
    """Called after the last data of the other end; it may still be sent to."""
    on_close: Callable[[Any], None]
    """Called once with the reason, when both directions have ended, or the stream was lost."""
    on_room: Callable[[], None]
    """Called when there is room again, after there was none."""

    @property
    def room(self) -> int:
        """The bytes that should be sent at most now.  `send` takes more, but a user should wait for `on_room`."""

    @property
    def is_complete(self) -> bool:
        """True if both directions have ended in order."""

    def send(self, data: bytes) -> None: ...

    def end(self) -> None:
        """End our direction after everything that was sent."""

    def abort(self) -> None:
        """Lose the stream at once.  `on_close` is not called."""

    def pause(self) -> None:
        """Call `on_data` no more until `resume`, so that the other end has to wait."""

    def resume(self) -> None: ...


class Opening(Stream, Protocol):
    """A stream that this side opens, and that the other end has not answered yet."""

    on_open: Callable[[], None]
    """Called when the other end has accepted it."""

    @property
    def is_refused(self) -> bool:
        """True if the stream is over because the other end has refused it."""


def join(first: Stream, second: Stream) -> None:
    """Carry everything between two streams: data, ends, losses and back-pressure."""
    _carry(first, second)
    _carry(second, first)


def _carry(source: Stream, target: Stream) -> None:
    def on_data(data: bytes) -> None:
        target.send(data)
        if target.room == 0:
            source.pause()

    def on_close(_reason: object) -> None:
        if not source.is_complete:
            target.abort()

    source.on_data, source.on_end, source.on_close = on_data, target.end, on_close
    target.on_room = source.resume
