"""The frames of one CAN identifier in a recording: how often, how long, after which SYNC, with which contents."""

from array import array
from collections import Counter
from typing import Final

from fieldrig.clock import MS
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.from_recording.series import Room, Series

MOST_INSTANTS: Final = 4_096
"""Instants that are enough to find a period."""
MOST_BYTES: Final = 8
LATEST_ANSWER_NS: Final = 100 * MS
"""Longest time from a remote frame to the frame that answers it."""
MOST_SYNCS: Final = 240
"""Largest number of SYNCs from one cyclic PDO to the next (CiA 301, transmission types)."""


class Identifier:
    """The frames of one identifier of 11 bits."""

    __slots__ = (
        "_asked_ns",
        "_data",
        "_last_sync",
        "changed",
        "changes",
        "count",
        "first_ns",
        "instants",
        "last_ns",
        "lengths",
        "offsets",
        "on_request",
        "remote",
        "syncs",
    )  # fmt: skip

    def __init__(self, room: Room) -> None:
        self.count = self.remote = self.on_request = 0
        """Frames, remote frames, and the frames that answer a remote one."""
        self.first_ns = self.last_ns = 0
        self.lengths: Counter[int] = Counter()
        self.instants = array("q")
        """The first instants."""
        self.changed = bytearray()
        """1 for each of the first frames that had other data than the one before, otherwise 0."""
        self.changes = Series(room)
        """The data as numbers, little endian."""
        self.syncs: Counter[int] = Counter()
        """Numbers of SYNCs from one frame to the next."""
        self.offsets = array("q")
        """Times from the last SYNC to the first frames."""
        self._data: bytes | None = None
        self._asked_ns: int | None = None
        self._last_sync: int | None = None

    def take(self, time_ns: int, frame: CanFrame, sync: tuple[int, int] | None) -> None:
        """Take a frame; `sync` has number and instant of the last SYNC before it."""
        if frame.is_remote:
            self.remote += 1
            self._asked_ns = time_ns
            return
        data = frame.data
        if self._asked_ns is not None:
            self.on_request += time_ns - self._asked_ns <= LATEST_ANSWER_NS
            self._asked_ns = None
        if not self.count:
            self.first_ns = time_ns
        self.count += 1
        self.last_ns = time_ns
        self.lengths[len(data)] += 1
        if len(self.instants) < MOST_INSTANTS:
            self.instants.append(time_ns)
            self.changed.append(data != self._data)
            if sync is not None:
                self._relate(time_ns, sync)
        self._data = data
        if len(data) <= MOST_BYTES:
            self.changes.take(time_ns, int.from_bytes(data, "little"))

    def _relate(self, time_ns: int, sync: tuple[int, int]) -> None:
        number, sync_ns = sync
        self.offsets.append(time_ns - sync_ns)
        if self._last_sync is not None:
            self.syncs[min(number - self._last_sync, MOST_SYNCS + 1)] += 1
        self._last_sync = number

    @property
    def length(self) -> int:
        """The usual number of data bytes."""
        return self.lengths.most_common(1)[0][0] if self.lengths else 0
