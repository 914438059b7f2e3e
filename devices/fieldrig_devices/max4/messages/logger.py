"""The message logger: a ring buffer of 325 entries in buffered RAM, and log files on the flash disk.

Source: PacDrive manual 4202-4392 (digest PD-110 to PD-124).  The entries in the buffer are numbered from 1, the oldest
(our reading of both logs of the manual, where the newest entry of a full buffer is 325).  The format of a log file is
our choice: the table as the manual prints it, newest first, with tabs.  A time stamp is the time since power-on as
`DDD HH:MM:SS.sss` without leading parts that are zero (PD-115).
"""

from collections.abc import Callable, Iterable, Iterator
from typing import Final, NamedTuple, Protocol

from fieldrig_devices.max4.messages.diagnosis import Sender

ENTRIES: Final = 325
COLUMNS: Final = ("No.", "Timestamp", "Type", "Object", "Instance", "Diag. Code", "Ext. diagnosis", "Message")


class Entry(NamedTuple):
    """One entry of the log."""

    stamp_ms: int
    """Time since power-on or boot, in milliseconds."""
    type: int
    """Filter class, one bit of sixteen."""
    sender: Sender
    code: int
    ext: str
    text: str

    def line(self, number: int, *, is_plain: bool = False) -> str:
        """The entry as a line of the table in the manual, with tabs."""
        shown = (
            number, stamp(self.stamp_ms, is_plain=is_plain), f"0x{self.type:04x}", *self.sender, self.code or "",
            self.ext, self.text,
        )  # fmt: skip
        return "\t".join(map(str, shown))


class Files(Protocol):
    """The part of the flash disk that the logger uses.  Each method raises ValueError if it fails."""

    def write(self, name: str, data: bytes) -> None: ...

    def read(self, name: str) -> bytes: ...

    def delete(self, name: str) -> None: ...


class Ring(Protocol):
    """The ring buffer of the entries."""

    def entries(self) -> Iterator[Entry]:
        """The entries, oldest first."""

    def append(self, entry: Entry) -> None:
        """Append an entry; a full buffer drops its oldest entry."""

    def clear(self) -> None: ...

    def __len__(self) -> int: ...


class Logger:
    """The logger of one controller."""

    def __init__(self, ring: Ring, files: Files, now_ms: Callable[[], int]) -> None:
        self._ring, self._files, self._now_ms = ring, files, now_ms
        self.filter = 0xFFFF
        """MsgFilter, a mask of filter classes; entries of other classes are not recorded."""
        self.is_plain = False
        """True for time stamps in plain milliseconds, as before V00.07.00."""

    def __len__(self) -> int:
        """Number of entries (MsgEntries)."""
        return len(self._ring)

    def insert(self, type: int, sender: Sender, code: int, ext: str, text: str) -> bool:
        """Insert an entry (MsgLogInsert()).  Return true if the filter accepts it."""
        if not type & self.filter:
            return False
        self._ring.append(Entry(self._now_ms(), type, sender, code, ext, text))
        return True

    def entries(self) -> list[tuple[int, Entry]]:
        """The entries with their numbers, newest first."""
        return list(enumerate(self._ring.entries(), 1))[::-1]

    def lines(self, shown: int = 0xFFFF) -> list[str]:
        """The entries as lines of the tool, newest first; `shown` is the mask of its display filter."""
        return [entry.line(number, is_plain=self.is_plain) for number, entry in self.entries() if entry.type & shown]

    def save(self, name: str) -> None:
        """Save the buffer to a file (MsgLogSave()).  ValueError if the disk does not accept it."""
        self._files.write(name, text_of(self.lines()).encode("utf-8"))

    def reset(self) -> None:
        """Delete all entries (MsgLogReset())."""
        self._ring.clear()

    def save_and_reset(self, name: str) -> None:
        self.save(name)
        self.reset()

    def load(self, name: str) -> list[str]:
        """The lines of a log file.  ValueError if the file does not exist."""
        return self._files.read(name).decode("utf-8", "replace").splitlines()[1:]

    def delete(self, name: str) -> None:
        """Delete a log file (MsgLogDelete()).  ValueError if the file does not exist."""
        self._files.delete(name)


def text_of(lines: Iterable[str]) -> str:
    return "\n".join(("\t".join(COLUMNS), *lines)) + "\n"


def stamp(ms: int, *, is_plain: bool = False) -> str:
    """Return a time stamp such as `1`, `9.540`, `22:39.709`, `2:35:21.429` or `1 02:35:21.429`.

    Before V00.07.00 it was a plain number of milliseconds.
    """
    if is_plain:
        return str(ms)
    seconds, rest = divmod(ms, 1000)
    minutes, seconds = divmod(seconds, 60)
    hours, minutes = divmod(minutes, 60)
    days, hours = divmod(hours, 24)
    if days:
        return f"{days} {hours:02}:{minutes:02}:{seconds:02}.{rest:03}"
    if hours:
        return f"{hours}:{minutes:02}:{seconds:02}.{rest:03}"
    if minutes:
        return f"{minutes}:{seconds:02}.{rest:03}"
    return f"{seconds}.{rest:03}" if seconds else str(rest)
