"""The message logger: a ring of 325 entries in buffered RAM, and log files on the flash disk.

Source: PacDrive manual 4202-4392 (digest PD-110 to PD-124).  Numbers count the entries in the buffer, the oldest is 1
(our reading of both logs of the manual, where the newest is 325 in a full buffer of 325).  What a log file looks like
is our choice: the table as the manual prints it, newest first, with tabs.
"""

from collections.abc import Callable, Iterable, Iterator
from typing import Final, NamedTuple, Protocol

from fieldrig_devices.max4.messages.diagnosis import Sender
from fieldrig_devices.max4.messages.stamp import stamp

ENTRIES: Final = 325
COLUMNS: Final = ("No.", "Timestamp", "Type", "Object", "Instance", "Diag. Code", "Ext. diagnosis", "Message")


class Entry(NamedTuple):
    stamp_ms: int
    """Since power-on or boot."""
    type: int
    """The filter class: one bit of sixteen."""
    sender: Sender
    code: int
    ext: str
    text: str

    def line(self, number: int, *, is_plain: bool = False) -> str:
        """As the manual prints it, with tabs."""
        shown = (
            number, stamp(self.stamp_ms, is_plain=is_plain), f"0x{self.type:04x}", *self.sender, self.code or "",
            self.ext, self.text,
        )  # fmt: skip
        return "\t".join(map(str, shown))


class Files(Protocol):
    """The part of the flash disk that the logger uses.  ValueError says why not."""

    def write(self, name: str, data: bytes) -> None: ...

    def read(self, name: str) -> bytes: ...

    def delete(self, name: str) -> None: ...


class Ring(Protocol):
    """Where the entries lie."""

    def entries(self) -> Iterator[Entry]:
        """Oldest first."""

    def append(self, entry: Entry) -> None:
        """The oldest goes when it is full."""

    def clear(self) -> None: ...

    def __len__(self) -> int: ...


class Logger:
    def __init__(self, ring: Ring, files: Files, now_ms: Callable[[], int]) -> None:
        self._ring, self._files, self._now_ms = ring, files, now_ms
        self.filter = 0xFFFF
        """MsgFilter: a class whose bit is 0 is not recorded."""
        self.is_plain = False
        """Stamps in plain ms, as below V00.07.00."""

    def __len__(self) -> int:
        """MsgEntries."""
        return len(self._ring)

    def insert(self, type: int, sender: Sender, code: int, ext: str, text: str) -> bool:
        """MsgLogInsert(): whether the filter let it through."""
        if not type & self.filter:
            return False
        self._ring.append(Entry(self._now_ms(), type, sender, code, ext, text))
        return True

    def entries(self) -> list[tuple[int, Entry]]:
        """With their numbers, newest first."""
        return list(enumerate(self._ring.entries(), 1))[::-1]

    def lines(self, shown: int = 0xFFFF) -> list[str]:
        """As the tool shows them, newest first; `shown` is its display filter."""
        return [entry.line(number, is_plain=self.is_plain) for number, entry in self.entries() if entry.type & shown]

    def save(self, name: str) -> None:
        """MsgLogSave(): the buffer to a file.  ValueError if the disk doesn't take it."""
        self._files.write(name, text_of(self.lines()).encode("utf-8"))

    def reset(self) -> None:
        """MsgLogReset()."""
        self._ring.clear()

    def save_and_reset(self, name: str) -> None:
        self.save(name)
        self.reset()

    def load(self, name: str) -> list[str]:
        """The lines of a log file.  ValueError if there is none of this name."""
        return self._files.read(name).decode("utf-8", "replace").splitlines()[1:]

    def delete(self, name: str) -> None:
        """MsgLogDelete(): a file.  ValueError if there is none of this name."""
        self._files.delete(name)


def text_of(lines: Iterable[str]) -> str:
    return "\n".join(("\t".join(COLUMNS), *lines)) + "\n"
