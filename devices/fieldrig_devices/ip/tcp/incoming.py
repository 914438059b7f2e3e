"""The receiving half of a connection: data in order, the gaps in them, and the window (RFC 9293, 3.4 and 3.8.6)."""

from bisect import insort
from typing import Final

MOST_PIECES: Final = 64
"""Pieces that wait for a gap to be filled.  A further one is dropped, and the peer sends it again."""


class Incoming:
    """Takes data and hands them over in order.  Positions are those of `sequence`."""

    def __init__(self, first: int, capacity: int, mss: int) -> None:
        """`first` is the position of the peer's SYN, `capacity` the largest window in bytes."""
        self.next = first + 1
        """RCV.NXT: the position of the next byte that is expected."""
        self.edge = self.next + capacity
        """The end of the window that the peer was granted (RCV.NXT + RCV.WND)."""
        self.is_paused = False
        self.has_ended = False
        """True after the peer's FIN arrived in order."""
        self._capacity = capacity
        self._step = min(mss, capacity // 2)
        self._ready = bytearray()
        self._pieces: list[tuple[int, bytes]] = []
        self._end: int | None = None

    @property
    def window(self) -> int:
        return self.edge - self.next

    @property
    def has_gaps(self) -> bool:
        return bool(self._pieces) or (self._end is not None and not self.has_ended)

    def is_acceptable(self, start: int, length: int) -> bool:
        """True if a segment is at least partly in the window (RFC 9293, table 6).

        An ACK without data may also be at the end of the window, where a peer sends it that has filled the window.
        """
        if length == 0:
            return self.next <= start <= self.edge
        return self.window > 0 and start < self.edge and start + length > self.next

    def arrived(self, start: int, data: bytes, is_last: bool) -> None:
        """Take the data of an acceptable segment; `is_last` if a FIN follows them."""
        end = start + len(data)
        if is_last and end < self.edge and self._end is None:
            self._end = end
        data = data[max(self.next - start, 0) : max(self.edge - start, 0)]
        start = max(start, self.next)
        if start > self.next:
            if data and len(self._pieces) < MOST_PIECES:
                insort(self._pieces, (start, data))
            return
        self._append(data)
        while self._pieces and self._pieces[0][0] <= self.next:
            start, data = self._pieces.pop(0)
            self._append(data[self.next - start :])
        if self.next == self._end:
            self.next += 1
            self.edge = max(self.edge, self.next)
            self.has_ended = True

    def take(self) -> bytes:
        """Remove and return the data in order; none while paused."""
        if self.is_paused:
            return b""
        data = bytes(self._ready)
        self._ready.clear()
        return data

    def open_window(self) -> bool:
        """Move the window behind what was taken, if that is worth telling (RFC 9293, 3.8.6.2.2); True if it moved."""
        edge = self.next + self._capacity - len(self._ready)
        if self.has_ended or edge - self.edge < self._step:
            return False
        self.edge = edge
        return True

    def _append(self, data: bytes) -> None:
        if self._end is not None:
            data = data[: max(self._end - self.next, 0)]
        self._ready += data
        self.next += len(data)
