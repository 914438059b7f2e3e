"""The transmitter of one line: it gives its data to the network at the rate of its carrier, to the bit.

A character takes 10 bits, or 8 if the modems correct errors, as V.42 carries no start and stop bits.  The frames of
V.42 are left out.  Data leave in chunks, each at the instant at which its last bit has left.
"""

from collections.abc import Iterator

from fieldrig.clock import S
from fieldrig_bus.telephone.message import Carrier

UNPACED_CHUNK = 1024
MOST_WAITING = 1 << 20
"""Bytes that may wait in a transmitter."""


def bits_per_character(carrier: Carrier) -> int:
    return 8 if carrier.is_corrected else 10


class Transmitter:
    def __init__(self, chunk_ns: int, is_paced: bool) -> None:
        self._chunk_ns, self._is_paced = chunk_ns, is_paced
        self._carrier = Carrier(0)
        self._waiting = bytearray()
        self._begin_ns = 0
        """The instant at which the first waiting character begins."""
        self._size = 1

    def start(self, now_ns: int, carrier: Carrier) -> None:
        """Begin to send with this carrier; a rate of 0 ends it, and what waits is lost."""
        self._carrier = carrier
        self._waiting.clear()
        self._begin_ns = now_ns
        chunk = self._chunk_ns * carrier.bps // (bits_per_character(carrier) * S)
        self._size = max(1, chunk) if self._is_paced else UNPACED_CHUNK

    def put(self, now_ns: int, data: bytes) -> bool:
        """Take data that are asked for now.  False if too many wait; without a carrier, they are lost."""
        if not self._carrier.bps:
            return True
        if len(self._waiting) + len(data) > MOST_WAITING:
            return False
        if not self._waiting:
            self._begin_ns = max(now_ns, self._begin_ns)
        self._waiting += data
        return True

    def next_ns(self) -> int | None:
        """Return the instant at which the next chunk has left; None while nothing waits."""
        waiting = len(self._waiting)
        return None if not waiting else self._begin_ns + self._ns_of(min(waiting, self._size))

    def take(self, now_ns: int) -> Iterator[tuple[int, bytes]]:
        """Yield what has left by now, each chunk with its instant."""
        while (done_ns := self.next_ns()) is not None and done_ns <= now_ns:
            chunk = bytes(self._waiting[: self._size])
            del self._waiting[: self._size]
            self._begin_ns = done_ns
            yield done_ns, chunk

    def repeat(self, chunk: bytes, pause_ns: int) -> None:
        """Send `chunk`, which was taken last, once more after a pause."""
        self._waiting[:0] = chunk
        self._begin_ns += pause_ns

    def _ns_of(self, count: int) -> int:
        if not self._is_paced:
            return 0
        return -(-count * bits_per_character(self._carrier) * S // self._carrier.bps)
