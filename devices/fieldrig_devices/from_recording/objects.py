"""The objects of a node in a recording: what SDO transfers read, wrote and were refused."""

from collections import Counter
from typing import Final

from fieldrig_devices.canopen.cob_id import is_valid
from fieldrig_devices.canopen.pdo_maps import TO_MAPPING
from fieldrig_devices.cia402.objects import CONTROL_WORD, MODE, MODE_DISPLAY, STATUS_WORD
from fieldrig_devices.dialogues import SdoTransfer
from fieldrig_devices.from_recording.pdos import is_mapping
from fieldrig_devices.from_recording.series import Room, Series

MOST_OBJECTS: Final = 20_000
"""Objects of one node that are kept: a scan of all indices and sub-indices would be 16 million."""
MOST_ANNOUNCED: Final = 4_096
MOST_ABORTS: Final = 64
MOST_WORDS: Final = 50_000
WORDS: Final = frozenset({CONTROL_WORD, STATUS_WORD, MODE, MODE_DISPLAY})
WORD: Final = 8
"""Largest size of a value that is followed as a number."""
Key = tuple[int, int]
"""Index and sub-index."""


class ObjectLog:
    """One object of one node."""

    __slots__ = (
        "aborts",
        "accepted",
        "announced",
        "first",
        "first_write_ns",
        "is_certain",
        "is_moved",
        "is_read",
        "is_written",
        "last",
        "refused_writes",
        "sizes",
        "values",
        "writes",
    )  # fmt: skip

    def __init__(self, room: Room) -> None:
        self.is_read = self.is_written = False
        self.announced = 0
        """Size of a value that was announced, and not transferred to its end; 0 without one."""
        self.is_moved = False
        """True if a read value differs from the one that was read or written before, so the device changed it."""
        self.first: bytes | None = None
        """The value of the first read before any write."""
        self.last: bytes | None = None
        self.sizes: Counter[int] = Counter()
        self.values = Series(room)
        """Read values as numbers."""
        self.writes = 0
        self.first_write_ns: int | None = None
        self.aborts: Counter[tuple[bool, int]] = Counter()
        """Abort codes of the device, each with whether a write was refused."""
        self.refused_writes: set[tuple[int, bytes]] = set()
        """Abort codes and data of the refused writes, where the log shows them."""
        self.accepted: set[bytes] = set()
        """Data of the accepted writes."""
        self.is_certain = True
        """False from a reset of the node until the value is seen again."""

    def read(self, time_ns: int, data: bytes) -> None:
        if not self.is_read and not self.is_written:
            self.first = data
        if self.last is not None and data != self.last and self.is_certain:
            self.is_moved = True
        self.is_read, self.last, self.is_certain = True, data, True
        self.sizes[len(data)] += 1
        if len(data) <= WORD:
            self.values.take(time_ns, int.from_bytes(data, "little"))

    def write(self, time_ns: int, data: bytes) -> None:
        if self.first_write_ns is None:
            self.first_write_ns = time_ns
        self.is_written, self.last, self.is_certain = True, data, True
        self.writes += 1
        if len(self.accepted) < MOST_ABORTS:
            self.accepted.add(data)
        self.sizes[len(data)] += 1

    def forget(self) -> None:
        """The node begins again: the next value may differ from the last one without having moved."""
        self.is_certain = False

    def refuse(self, transfer: SdoTransfer) -> None:
        assert transfer.abort is not None
        key = transfer.is_download, transfer.abort
        if key in self.aborts or len(self.aborts) < MOST_ABORTS:
            self.aborts[key] += 1
        if transfer.is_download and transfer.data is not None and len(self.refused_writes) < MOST_ABORTS:
            self.refused_writes.add((transfer.abort, transfer.data))

    @property
    def is_there(self) -> bool:
        return self.is_read or self.is_written or self.announced > 0

    @property
    def start(self) -> bytes | None:
        """The value that the emulated node begins with: the one before any write, else the last one.

        Of a value that was only announced, nothing is known but its size.
        """
        if self.first is None and self.last is None and self.announced:
            return bytes(self.announced)
        return self.last if self.first is None else self.first


class ObjectLogs:
    """The objects of one node."""

    def __init__(self, room: Room) -> None:
        self._room = room
        self.by_key: dict[Key, ObjectLog] = {}
        self.answer_ns: list[int] = []
        """Times from the first requests to their answers."""
        self.unanswered = self.left_out = 0
        self.words: list[SdoTransfer] = []
        """Transfers of control word, status word and mode of a drive."""
        self.lost_first: bool | None = None
        """True if the first request after a boot-up had no answer; None if the recording has no boot-up."""
        self.maps_while_valid = False
        """True if the node has let a master change the mapping of a PDO that was valid."""
        self._is_after_boot = False

    def take(self, transfer: SdoTransfer) -> None:
        if self._is_after_boot:
            self.lost_first, self._is_after_boot = bool(self.lost_first) or not transfer.is_answered, False
        if transfer.index in WORDS and not transfer.subindex and len(self.words) < MOST_WORDS:
            self.words.append(transfer)
        if transfer.end_ns is None or transfer.abort_by_client:
            self.unanswered += not transfer.is_answered
            self._announce(transfer)
            return
        log = self._log((transfer.index, transfer.subindex))
        if log is None:
            return
        if len(transfer.entries) == 2 and len(self.answer_ns) < 4_096:
            self.answer_ns.append(max(transfer.end_ns - transfer.begin_ns, 0))  # the time of a log may jump back
        if transfer.abort is not None:
            log.refuse(transfer)
            self._announce(transfer)
        elif transfer.data is not None and transfer.is_download:
            self.maps_while_valid |= is_mapping(transfer.index) and self._is_valid(transfer.index - TO_MAPPING)
            log.write(transfer.begin_ns, transfer.data)
        elif transfer.data is not None:
            log.read(transfer.begin_ns, transfer.data)

    def _is_valid(self, parameter: int) -> bool:
        """True if the COB-ID of a PDO is known to be valid at present."""
        log = self.by_key.get((parameter, 1))
        is_known = log is not None and log.last is not None and log.is_certain
        return is_known and is_valid(self.number(parameter, 1) or 0)

    def _announce(self, transfer: SdoTransfer) -> None:
        """Take an upload that was broken off: what the node has announced exists."""
        log = self._log((transfer.index, transfer.subindex)) if transfer.size and not transfer.is_download else None
        if log is not None:
            log.announced = min(transfer.size or 0, MOST_ANNOUNCED)

    def boot(self) -> None:
        """The node has sent its boot-up message."""
        self._is_after_boot = True
        self.forget()

    def forget(self) -> None:
        """The node is reset, so its values are those of power-on."""
        for log in self.by_key.values():
            log.forget()

    def _log(self, key: Key) -> ObjectLog | None:
        log = self.by_key.get(key)
        if log is None and len(self.by_key) < MOST_OBJECTS:
            log = self.by_key[key] = ObjectLog(self._room)
        self.left_out += log is None
        return log

    def number(self, index: int, subindex: int = 0) -> int | None:
        """Return the last value of an object as a number; None if the recording does not have it."""
        log = self.by_key.get((index, subindex))
        return None if log is None or log.last is None else int.from_bytes(log.last, "little")

    def first_number(self, index: int, subindex: int = 0) -> int | None:
        """Return the value before any write as a number, or else the last one; None if there is none."""
        log = self.by_key.get((index, subindex))
        return self.number(index, subindex) if log is None or log.first is None else int.from_bytes(log.first, "little")

    def there(self) -> dict[Key, ObjectLog]:
        """Return the objects that exist, in their order."""
        return {key: log for key, log in sorted(self.by_key.items()) if log.is_there}
