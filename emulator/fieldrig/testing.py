"""Fakes for unit tests of devices: good enough to live in the product, small enough to read."""

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

M = TypeVar("M")


class RecordedLink(Generic[M]):
    """A link that keeps what was sent, and delivers what the test says.  Interest is kept, not applied."""

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
        """What was sent since the last call."""
        sent, self.sent = self.sent, []
        return sent
