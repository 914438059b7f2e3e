"""The changes of one value during a recording, in little memory."""

from array import array
from typing import Final, NamedTuple

MOST: Final = 50_000
"""Changes of one value that are kept; hours of a position that moves in each millisecond would fill the memory."""


MOST_OF_ALL: Final = 2_000_000
"""Changes of all values of a bus, which are 48 MB."""


class Room:
    """The number of changes that all values of a bus may still have."""

    __slots__ = ("left",)

    def __init__(self) -> None:
        self.left = MOST_OF_ALL


class Change(NamedTuple):
    """A new value; the change was after `before_ns`, when the old one was seen last, and not later than `seen_ns`."""

    before_ns: int
    seen_ns: int
    value: int
    place: int = 0
    """Its place in the series, from 0."""


class Series:
    """Values of up to 64 bits, with the instants at which they were seen; equal ones in a row are one."""

    __slots__ = ("_before", "_room", "_seen", "_values", "last_ns", "left_out")

    def __init__(self, room: Room) -> None:
        self._room = room
        self._before, self._seen, self._values = array("q"), array("q"), array("Q")
        self.last_ns = 0
        """When the last value was seen last."""
        self.left_out = 0
        """Changes for which there was no room."""

    def __len__(self) -> int:
        return len(self._values)

    def take(self, time_ns: int, value: int) -> None:
        """Take a value.  An instant before the last one, as odd logs have it, counts as that one."""
        time_ns = max(time_ns, self.last_ns)
        before_ns, self.last_ns = self.last_ns, time_ns
        if self._values and self._values[-1] == value:
            return
        if len(self._values) >= MOST or self._room.left <= 0:
            self.left_out += 1
            return
        self._room.left -= 1
        self._before.append(before_ns if self._values else time_ns)
        self._seen.append(time_ns)
        self._values.append(value)

    def changes(self, since_ns: int) -> list[Change]:
        """Return the changes from an instant on, with the value that was there at that instant as the first one."""
        rows = zip(self._before, self._seen, self._values, range(len(self)), strict=True)
        every = [Change(*row) for row in rows]
        later = [change for change in every if change.seen_ns >= since_ns]
        return later or every[-1:]

    @property
    def last(self) -> int | None:
        return self._values[-1] if self._values else None
