"""The messages that the buses of a rig in real time publish, for a tool without an event loop.

What waits to be read is limited.  What comes beyond that is dropped and counted, with what was lost on the way: batches
are numbered by their publisher, so a gap tells how many messages it had.
"""

from collections import Counter, deque
from collections.abc import Iterator, Mapping, Sequence
from threading import Thread
from typing import Any, Final, NamedTuple

from fieldrig.control.messages import Client
from fieldrig.outside.limits import Reached
from fieldrig.traces.trace import is_batch

READY_S: Final = 5.0
"""The longest time until a bus answers, and so knows of its listener."""
MOST_MESSAGES: Final = 100_000
"""Messages that wait to be read: ten seconds of a CAN bus at 1 Mbit/s, and some 30 MB."""
MOST_BATCHES: Final = 10_000
"""Batches that wait, which have a message or none each."""
MOST_SOURCES: Final = 1_000
"""Processes that publish; a rig has one for each device and bus at most."""


class Batch(NamedTuple):
    """Messages of one bus, as `bus_stream` publishes them."""

    bus: str
    content: Mapping[str, Any]


class Waiting:
    """Batches on their way from the thread that puts them in to the one that takes them out."""

    def __init__(self) -> None:
        self.reached = Reached("messages of the buses")
        self._batches: deque[Batch] = deque()
        self._put = self._taken = 0  # each is written by one thread
        self._missed: Counter[str] = Counter()
        self._expected: dict[tuple[str, str], int] = {}

    def put(self, batch: Batch) -> None:
        """Keep a batch, unless too many messages wait."""
        entries, first = batch.content["entries"], batch.content["first"]
        source = (batch.bus, batch.content["process"])
        self._missed[batch.bus] += max(first - self._expected.get(source, first), 0)
        if source in self._expected or len(self._expected) < MOST_SOURCES:
            self._expected[source] = first + len(entries)
        if len(self._batches) >= MOST_BATCHES or self._put - self._taken + len(entries) > MOST_MESSAGES:
            self._missed[batch.bus] += len(entries)
            self.reached.note(
                "batches over the limit",
                f"{self._put - self._taken} messages wait to be read; those of a batch are lost",
            )
            return
        self._put += len(entries)
        self._batches.append(batch)

    def take(self) -> Iterator[Batch]:
        """Yield what waits."""
        while self._batches:
            batch = self._batches.popleft()
            self._taken += len(batch.content["entries"])
            yield batch

    def missed(self, bus: str) -> int:
        """Return how many messages of a bus were lost."""
        return self._missed[bus]


class BusInbox:
    """Takes what buses publish, in a thread of its own."""

    def __init__(self, endpoint: str, buses: Sequence[str]) -> None:
        self._client = Client(endpoint)
        self._waiting = Waiting()
        self._unread = 0
        """Batches that were lost here before they were read."""
        self._inbox = self._client.inbox([f"trace/{bus}" for bus in buses], self._on_full)
        self._is_open = True
        self._take(next(self._inbox))  # which declares the listeners
        for bus in buses:
            self._client.ask(f"bus/{bus}/status", timeout_s=READY_S)  # a bus that has answered knows of them
        self._thread = Thread(target=self._work, name="traffic", daemon=True)
        self._thread.start()

    def batches(self) -> Iterator[Batch]:
        """Yield what has come since the last call."""
        return self._waiting.take()

    def missed(self, buses: Sequence[str]) -> int:
        """Return how many messages of these buses were lost, at least: the last batch of all has none behind it."""
        return max(sum(map(self._waiting.missed, buses)), self._unread if buses else 0)

    def close(self) -> None:
        self._is_open = False
        self._thread.join()
        self._client.__exit__()

    def _on_full(self) -> None:
        self._unread += 1

    def _work(self) -> None:
        for published in self._inbox:
            self._take(published)
            if not self._is_open:
                return

    def _take(self, published: tuple[str, Any] | None) -> None:
        if published is not None and is_batch(published[1]):
            self._waiting.put(Batch(*published))
