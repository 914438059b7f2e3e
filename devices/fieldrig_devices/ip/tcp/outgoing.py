"""The sending half of a connection: the data that are not acknowledged yet, and the peer's window (RFC 9293, 3.4)."""


class Outgoing:
    """Keeps data until they are acknowledged.  Positions are those of `sequence`; the SYN is at `first`."""

    def __init__(self, first: int) -> None:
        self.first = first
        self.unacknowledged = first
        """SND.UNA."""
        self.next = first
        """SND.NXT: what is sent next.  It goes back to SND.UNA when everything is sent again."""
        self.highest = first
        """The highest SND.NXT so far."""
        self.window = 0
        """SND.WND, in bytes."""
        self.widest = 0
        """The widest window so far."""
        self.has_ended = False
        """True if a FIN follows the data."""
        self._window_from = (0, 0)
        self._data = bytearray()
        self._base = first + 1

    @property
    def end_of_data(self) -> int:
        """The position behind the last byte, which is that of the FIN."""
        return self._base + len(self._data)

    @property
    def queued(self) -> int:
        """The bytes that are not acknowledged yet."""
        return len(self._data)

    @property
    def in_flight(self) -> int:
        """The bytes that were sent and are not acknowledged yet."""
        return self.next - self.unacknowledged

    @property
    def oldest_acknowledgment(self) -> int:
        """The lowest acknowledgment that a late segment of the peer can have: SND.UNA - MAX.SND.WND (RFC 5961, 5.2)."""
        return max(self.unacknowledged - self.widest, self.first)

    @property
    def is_everything_sent(self) -> bool:
        return self.next == self.end_of_data + self.has_ended

    @property
    def is_end_acknowledged(self) -> bool:
        return self.has_ended and self.unacknowledged > self.end_of_data

    def append(self, data: bytes) -> None:
        self._data += data

    def at(self, position: int, size: int) -> bytes:
        """Return up to `size` bytes from `position` on."""
        start = position - self._base
        return bytes(self._data[start : start + size])

    def sent(self, end: int) -> bool:
        """Everything before `end` was sent.  True if it was sent for the first time."""
        self.next = max(self.next, end)
        is_new = end > self.highest
        self.highest = max(self.highest, end)
        return is_new

    def acknowledge(self, position: int) -> int:
        """Take a new acknowledgment, and return how many positions it covers."""
        covered = position - self.unacknowledged
        self.unacknowledged = position
        self.next = max(self.next, position)
        gone = min(position, self.end_of_data) - self._base
        if gone > 0:
            del self._data[:gone]
            self._base += gone
        return covered

    def go_back(self) -> None:
        """Begin again with what is not acknowledged."""
        self.next = self.unacknowledged

    def update_window(self, sequence: int, acknowledgment: int, window: int) -> bool:
        """Take the window of a segment, unless it is older than the last one (RFC 9293, 3.10.7.4).

        True if the window has changed.
        """
        if (sequence, acknowledgment) < self._window_from:
            return False
        self._window_from = sequence, acknowledgment
        has_changed = window != self.window
        self.window = window
        self.widest = max(self.widest, window)
        return has_changed
