"""Buffered RAM of the controller: the NVRAM for retain data, and the ring buffer of the message logger.

Source: PacDrive manual 4210-4214, 6031-6032 (digest PD-048, PD-111, PD-112).  A capacitor supplies both for at most 7
days.  Entries have a fixed size.  Start and count of the ring buffer are in one aligned word, which is written last, so
that a killed process leaves the buffer as it was before or after an entry.  Retain data go through a journal for the
same reason (`retained.py`).
"""

import struct
from collections.abc import Iterator
from functools import lru_cache
from typing import Final

from fieldrig_devices.max4.messages.diagnosis import Sender
from fieldrig_devices.max4.messages.logger import ENTRIES, Entry
from fieldrig_devices.max4.storage.retained import Retained, extra_bytes

NVRAM_BYTES: Final = 1024
RETENTION_DAYS: Final = 7.0
_MAGIC: Final = 0x344D4158  # "XAM4"
_HEAD: Final = struct.Struct("<I")
_PLACES: Final = struct.Struct("<HH")  # position of the oldest entry, number of entries
_RECORD: Final = struct.Struct("<QHH16s32s48s80s4x")
_MAGIC_AT, _PLACES_AT, _NVRAM_AT, _LOG_AT = 0, 4, 64, 64 + NVRAM_BYTES
_MODULE_AT: Final = _LOG_AT + ENTRIES * _RECORD.size
RAM_BYTES: Final = _MODULE_AT + extra_bytes(NVRAM_BYTES)


def ram_bytes(retain_bytes: int) -> int:
    """Size of the RAM; the memory of a module, and the journal of the retain data, follow the other parts."""
    if retain_bytes == NVRAM_BYTES:
        return RAM_BYTES
    return _MODULE_AT + retain_bytes + extra_bytes(retain_bytes)


class BufferedRam:
    """The RAM of one controller."""

    def __init__(self, ram: memoryview, retain_bytes: int = NVRAM_BYTES, *, has_battery: bool = False) -> None:
        """`ram` has `ram_bytes(retain_bytes)` bytes; a battery keeps only the retain data."""
        self._has_battery, self._retain_bytes = has_battery, retain_bytes
        self.log = LogRing(ram)
        self._use(ram)

    def _use(self, ram: memoryview) -> None:
        size = self._retain_bytes
        at, end = (_NVRAM_AT, _MODULE_AT) if size == NVRAM_BYTES else (_MODULE_AT, _MODULE_AT + size)
        self._ram, self.nvram = ram, ram[at : at + size]
        self.retained = Retained(self.nvram, ram[end : end + extra_bytes(size)])
        self.log.use(ram)

    def move_to(self, ram: memoryview) -> None:
        """Move the content to `ram`, which has the same size."""
        ram[:] = self._ram
        self._use(ram)

    @property
    def is_known(self) -> bool:
        """True if the memory has a content, which an earlier process may have left."""
        (magic,) = _HEAD.unpack_from(self._ram, _MAGIC_AT)
        return bool(magic == _MAGIC)

    def wake(self, off_days: float) -> bool:
        """Switch on after `off_days` without power.  Return true if the content has been kept."""
        if self.is_known and off_days <= RETENTION_DAYS:
            self.retained.recover()
            return True
        self.lose()
        return False

    def lose(self) -> None:
        """Clear the content, except for retain data that a battery keeps."""
        self.retained.recover()
        kept = self.retained.copy() if self._has_battery else b""
        self._ram[:] = bytes(len(self._ram))
        self.retained.paste(kept)
        _HEAD.pack_into(self._ram, _MAGIC_AT, _MAGIC)


class LogRing:
    """The `logger.Ring` in buffered RAM."""

    def __init__(self, ram: memoryview) -> None:
        self._ram = ram

    def use(self, ram: memoryview) -> None:
        self._ram = ram

    def __len__(self) -> int:
        return self._places()[1]

    def entries(self) -> Iterator[Entry]:
        start, count = self._places()
        for number in range(start, start + count):
            yield self._at(number % ENTRIES)

    def append(self, entry: Entry) -> None:
        start, count = self._places()
        texts = (entry.sender.object, entry.sender.instance, entry.ext, entry.text)
        at = _LOG_AT + (start + count) % ENTRIES * _RECORD.size
        is_full = count == ENTRIES
        if is_full:  # drop the oldest entry first, because its place is overwritten
            _PLACES.pack_into(self._ram, _PLACES_AT, (start + 1) % ENTRIES, count - 1)
            start, count = self._places()
        _RECORD.pack_into(
            self._ram, at, entry.stamp_ms, entry.type & 0xFFFF, entry.code & 0xFFFF, *map(_packed, texts, _SIZES)
        )
        _PLACES.pack_into(self._ram, _PLACES_AT, start, count + 1)

    def clear(self) -> None:
        _PLACES.pack_into(self._ram, _PLACES_AT, 0, 0)

    def _places(self) -> tuple[int, int]:
        start, count = _PLACES.unpack_from(self._ram, _PLACES_AT)
        return start % ENTRIES, min(count, ENTRIES)

    def _at(self, number: int) -> Entry:
        at = _LOG_AT + number * _RECORD.size
        return _entry(bytes(self._ram[at : at + _RECORD.size]))


_SIZES: Final = (16, 32, 48, 80)


def _packed(text: str, size: int) -> bytes:
    """The text in UTF-8, cut at the end of a character."""
    return text.encode("utf-8")[:size].decode("utf-8", "ignore").encode("utf-8")


def _text(field: bytes) -> str:
    return field.rstrip(b"\0").decode("utf-8", "replace")


@lru_cache(maxsize=2 * ENTRIES)  # a page of the controller shows all of them, which took a quarter of its time
def _entry(record: bytes) -> Entry:
    stamp_ms, type, code, *texts = _RECORD.unpack(record)
    object, instance, ext, text = (_text(field) for field in texts)
    return Entry(stamp_ms, type, Sender(object, instance), code, ext, text)
