"""Fragments of IPv4 packets: those that arrive are put together, and those of a long packet are made.

Source: RFC 791, 3.2, and RFC 1122, 3.3.2.  Packets that wait for fragments are limited in number and time.  One with
fragments that overlap is dropped, as the kernels of today do, because only an attack has them.
"""

from bisect import bisect, insort
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from ipaddress import IPv4Address
from typing import Final

from fieldrig.clock import S
from fieldrig_devices.ip.ipv4 import HEADER_BYTES, MOST_BYTES, Packet

WAIT_NS: Final = 60 * S
"""How long the fragments of a packet are awaited (RFC 1122, 3.3.2: 60 s to 120 s)."""
MOST_WAITING: Final = 8
"""Packets that wait for fragments; a further one takes the place of the oldest."""
UNIT: Final = 8
"""Number of bytes in which offsets count."""

Key = tuple[IPv4Address, IPv4Address, int, int]


@dataclass
class _Partial:
    """The fragments of a packet so far."""

    due_ns: int
    pieces: dict[int, bytes] = field(default_factory=dict)
    starts: list[int] = field(default_factory=list)
    """The begins of the pieces, in order, so that a look at the two neighbours of a fragment finds what it overlaps."""
    count: int = 0
    """Bytes of all pieces."""
    first: Packet | None = None
    length: int | None = None
    """The length of the whole, from the last fragment."""

    def is_in_the_way(self, start: int, end: int, *, is_last: bool) -> bool:
        """Return whether a fragment contradicts those that there are."""
        if self.length is not None and (end > self.length or (is_last and end != self.length)):
            return True
        place = bisect(self.starts, start)
        before = self.starts[place - 1] if place else None
        if before is not None and before + len(self.pieces[before]) > start:
            return True
        is_last_of_all = place == len(self.starts)
        return not is_last_of_all and (is_last or self.starts[place] < end)

    def add(self, start: int, data: bytes) -> None:
        """Keep a fragment that is not in the way."""
        insort(self.starts, start)
        self.pieces[start] = data
        self.count += len(data)

    def is_complete(self) -> bool:
        return self.count == self.length


class Reassembly:
    """The packets of one host that are not complete."""

    def __init__(self, on_dropped: Callable[[], object] = lambda: None) -> None:
        """`on_dropped` is called when a packet gives way to a further one."""
        self._on_dropped = on_dropped
        self._waiting: dict[Key, _Partial] = {}

    def take(self, now_ns: int, packet: Packet) -> Packet | None:
        """Return the packet if it is whole, or its last missing fragment.  ValueError for an impossible fragment."""
        if not packet.is_fragment:
            return packet
        start, end = packet.offset, packet.offset + len(packet.payload)
        if not packet.payload or (packet.has_more and end % UNIT) or HEADER_BYTES + end > MOST_BYTES:
            raise ValueError(
                f"a fragment of the bytes {start} to {end}, expected multiples of {UNIT} up to {MOST_BYTES}"
            )
        key = packet.source, packet.destination, packet.protocol, packet.identification
        partial = self._waiting.get(key) or self._begin(key, now_ns)
        if partial.pieces.get(start) == packet.payload:
            return None  # it came twice
        if partial.is_in_the_way(start, end, is_last=not packet.has_more):
            del self._waiting[key]
            raise ValueError("fragments that overlap")
        partial.add(start, packet.payload)
        partial.first = packet if start == 0 else partial.first
        partial.length = partial.length if packet.has_more else end
        if not partial.is_complete():
            return None
        del self._waiting[key]
        payload = b"".join(partial.pieces[at] for at in partial.starts)
        return replace(packet, payload=payload, offset=0, has_more=False)

    def next_ns(self) -> int | None:
        return min((partial.due_ns for partial in self._waiting.values()), default=None)

    def expire(self, now_ns: int) -> Iterator[Packet]:
        """Give up what is overdue, and yield the first fragment of each, as far as it has arrived."""
        for key, partial in list(self._waiting.items()):
            if partial.due_ns <= now_ns:
                del self._waiting[key]
                if partial.first is not None:
                    yield partial.first

    def _begin(self, key: Key, now_ns: int) -> _Partial:
        if len(self._waiting) >= MOST_WAITING:
            del self._waiting[next(iter(self._waiting))]
            self._on_dropped()
        partial = self._waiting[key] = _Partial(now_ns + WAIT_NS)
        return partial


def fragments_of(packet: Packet, mtu: int) -> Iterator[Packet]:
    """Yield the packet, or its fragments if it is longer than `mtu`, which is at least 68 bytes."""
    if HEADER_BYTES + len(packet.payload) <= mtu:
        yield packet
        return
    step = (mtu - HEADER_BYTES) // UNIT * UNIT
    for start in range(0, len(packet.payload), step):
        part = packet.payload[start : start + step]
        yield replace(packet, payload=part, offset=start, has_more=start + step < len(packet.payload))
