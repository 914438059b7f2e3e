"""The messages that the buses of a rig in real time publish, for a tool without an event loop."""

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from threading import Thread
from typing import Any, Final, NamedTuple

from fieldrig.control.messages import Client
from fieldrig.traces.trace import is_batch

READY_S: Final = 5.0
"""The longest time until a bus answers, and so knows of its listener."""


class Batch(NamedTuple):
    """Messages of one bus, as `bus_stream` publishes them."""

    bus: str
    content: Mapping[str, Any]


class BusInbox:
    """Takes what buses publish, in a thread of its own."""

    def __init__(self, endpoint: str, buses: Sequence[str]) -> None:
        self._client = Client(endpoint)
        self._batches: deque[Batch] = deque()
        self._inbox = self._client.inbox([f"trace/{bus}" for bus in buses])
        self._is_open = True
        self._take(next(self._inbox))  # which declares the listeners
        for bus in buses:
            self._client.ask(f"bus/{bus}/status", timeout_s=READY_S)  # a bus that has answered knows of them
        self._thread = Thread(target=self._work, name="traffic", daemon=True)
        self._thread.start()

    def batches(self) -> Iterator[Batch]:
        """Yield what has come since the last call."""
        while self._batches:
            yield self._batches.popleft()

    def close(self) -> None:
        self._is_open = False
        self._thread.join()
        self._client.__exit__()

    def _work(self) -> None:
        for published in self._inbox:
            self._take(published)
            if not self._is_open:
                return

    def _take(self, published: tuple[str, Any] | None) -> None:
        if published is not None and is_batch(published[1]):
            self._batches.append(Batch(*published))
