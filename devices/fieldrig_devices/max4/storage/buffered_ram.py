"""Buffered RAM of the controller: the NVRAM for retain data, and the ring of the message logger.

Source: PacDrive manual 4210-4214, 6031-6032 (digest PD-048, PD-111, PD-112).  Both live off a capacitor for 7 days at
most.  Entries are of a fixed size; start and count of the ring lie in one aligned word, which is written last, so a
process that is killed leaves the ring as it was before or after an entry.
"""

import struct
from collections.abc import Iterator
from typing import Final

from fieldrig_devices.max4.messages.diagnosis import Sender
from fieldrig_devices.max4.messages.logger import ENTRIES, Entry

NVRAM_BYTES: Final = 1024
RETENTION_DAYS: Final = 7.0
_MAGIC: Final = 0x344D4158  # "XAM4"
_HEAD: Final = struct.Struct("<I")
_PLACES: Final = struct.Struct("<HH")  # of the oldest entry, and how many there are
_RECORD: Final = struct.Struct("<QHH16s32s48s80s4x")
_MAGIC_AT, _PLACES_AT, _NVRAM_AT, _LOG_AT = 0, 4, 64, 64 + NVRAM_BYTES
RAM_BYTES: Final = _LOG_AT + ENTRIES * _RECORD.size


def ram_bytes(retain_bytes: int) -> int:
    """With the module's memory behind the controller's own."""
    return RAM_BYTES if retain_bytes == NVRAM_BYTES else RAM_BYTES + retain_bytes


class BufferedRam:
    def __init__(self, ram: memoryview, retain_bytes: int = NVRAM_BYTES, *, has_battery: bool = False) -> None:
        """`ram` has `ram_bytes(retain_bytes)`; a battery keeps the retain data, and them only."""
        self._has_battery, self._retain_bytes = has_battery, retain_bytes
        self.log = LogRing(ram)
        self._lie_in(ram)

    def _lie_in(self, ram: memoryview) -> None:
        own = self._retain_bytes == NVRAM_BYTES
        at = _NVRAM_AT if own else RAM_BYTES
        self._ram, self.nvram = ram, ram[at : at + self._retain_bytes]
        self.log.lie_in(ram)

    def move_to(self, ram: memoryview) -> None:
        """From now on everything lies in `ram`, which is of the same size."""
        ram[:] = self._ram
        self._lie_in(ram)

    def wake(self, off_days: float) -> bool:
        """Power-on after so many days without it; whether what was there is still there."""
        (magic,) = _HEAD.unpack_from(self._ram, _MAGIC_AT)
        if magic == _MAGIC and off_days <= RETENTION_DAYS:
            return True
        self.lose()
        return False

    def lose(self) -> None:
        kept = bytes(self.nvram) if self._has_battery else bytes(len(self.nvram))
        self._ram[:] = bytes(len(self._ram))
        self.nvram[:] = kept
        _HEAD.pack_into(self._ram, _MAGIC_AT, _MAGIC)


class LogRing:
    """`logger.Ring` in buffered RAM."""

    def __init__(self, ram: memoryview) -> None:
        self._ram = ram

    def lie_in(self, ram: memoryview) -> None:
        self._ram = ram

    def __len__(self) -> int:
        return self._places()[1]

    def entries(self) -> Iterator[Entry]:
        start, count = self._places()
        for place in range(start, start + count):
            yield self._at(place % ENTRIES)

    def append(self, entry: Entry) -> None:
        start, count = self._places()
        texts = (entry.sender.object, entry.sender.instance, entry.ext, entry.text)
        at = _LOG_AT + (start + count) % ENTRIES * _RECORD.size
        is_full = count == ENTRIES
        if is_full:  # the oldest goes first, for its place is taken
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

    def _at(self, place: int) -> Entry:
        stamp_ms, type, code, *texts = _RECORD.unpack_from(self._ram, _LOG_AT + place * _RECORD.size)
        one, instance, ext, text = (_text(field) for field in texts)
        return Entry(stamp_ms, type, Sender(one, instance), code, ext, text)


_SIZES: Final = (16, 32, 48, 80)


def _packed(text: str, size: int) -> bytes:
    """In UTF-8, cut where a character ends."""
    return text.encode("utf-8")[:size].decode("utf-8", "ignore").encode("utf-8")


def _text(field: bytes) -> str:
    return field.rstrip(b"\0").decode("utf-8", "replace")
