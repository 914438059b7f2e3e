"""One of two logs that are compared, divided into streams."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import chain, islice
from typing import Final

from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.replay.offset import HEAD
from fieldrig_devices.replay.streams import Item, Numbered, Stream, Streams, in_time, telegrams

MOST_STREAMS: Final = 20_000


class LogSide:
    """One log: its first messages, then all of them."""

    def __init__(self, entries: Iterable[TraceEntry], leave_out: Callable[[Stream], bool]) -> None:
        self._streams, self._leave_out = Streams(), leave_out
        self._names: Mapping[str, str] = {}
        self._rest = iter(self._placed(telegrams(in_time(entries))))
        self.head = list(islice(self._rest, HEAD))
        self.buses: dict[str, str] = {stream.bus: stream.family for stream, _ in self.head}
        """The family of each bus."""

    def rename(self, buses: Mapping[str, str]) -> None:
        """Call these buses by other names from now on, and in `head`."""
        self._names = buses
        self.head = [(self._renamed(stream), item) for stream, item in self.head]

    def all(self) -> Iterator[tuple[Stream, Item]]:
        """Yield all messages, once."""
        head, self.head = self.head, []
        return chain(
            head, ((self._renamed(stream), item) for stream, item in self._rest) if self._names else self._rest
        )

    def _renamed(self, stream: Stream) -> Stream:
        name = self._names.get(stream.bus)
        return stream if name is None else stream._replace(bus=name)

    def _placed(self, numbered: Iterator[Numbered]) -> Iterator[tuple[Stream, Item]]:
        left_out: dict[Stream, bool] = {}
        for number, entry in numbered:
            stream, item = self._streams.place(number, entry)
            is_out = left_out.get(stream)
            if is_out is None:
                if len(left_out) >= MOST_STREAMS:
                    left_out.clear()
                is_out = left_out[stream] = self._leave_out(stream)
            if not is_out:
                yield stream, item
