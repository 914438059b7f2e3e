"""The contents of a PDO: the objects of its mapping, or bytes without a name where the mapping cannot be seen."""

from collections.abc import Collection, Iterator, Sequence
from typing import Final, NamedTuple

from fieldrig_devices.canopen.pdo.mapping import MAX_BITS, MAX_ENTRIES
from fieldrig_devices.from_recording.pdos import Number, Pdo

BYTES_OF_TPDO, BYTES_OF_RPDO, LAST_OF_MAKER = 0x5800, 0x5400, 0x5FFF
"""Indices of the maker's range for the bytes of PDOs, like those of the parameters in the range of CiA 301."""
BYTES: Final = range(BYTES_OF_RPDO, LAST_OF_MAKER + 1)
DUMMIES: Final = range(1, 8)


class Part(NamedTuple):
    """An object in a PDO."""

    object: int
    subindex: int
    bits: int

    @property
    def entry(self) -> int:
        """The value in the mapping parameter."""
        return self.object << 16 | self.subindex << 8 | self.bits

    @property
    def key(self) -> tuple[int, int]:
        return self.object, self.subindex


class Layout(NamedTuple):
    """The parts of a PDO in their order."""

    parts: list[Part]
    is_known: bool
    """False for bytes without a name."""
    is_assumed: bool = False
    """True for a mapping that no master has read, and that fits."""
    is_misfit: bool = False
    """True for a mapping that the node keeps to, and that the frames which it receives do not fit."""

    def values(self, data: int) -> list[int]:
        """Return the values of the parts in a PDO as unsigned numbers; `data` is its bytes, little endian."""
        found, at = [], 0
        for part in self.parts:
            found.append(data >> at & (1 << part.bits) - 1)
            at += part.bits
        return found


def layout_of(pdo: Pdo, number: Number, length: int, taken: Collection[int], *, is_refused: bool = False) -> Layout:
    """Return the layout by the mapping parameter, as far as its values are known and fit the length of the frames.

    `length` is in bytes, and `taken` are the indices that the node uses.  `is_refused` is True if the node reports
    frames of a wrong length, so that its mapping counts and not their length.
    """
    index = free_index(pdo, taken)
    count = number(pdo.mapping, 0)
    if count is None:
        fitting = _filled_up(list(_read(pdo, number)), index, length)
        entries: list[int | None] = []
    else:
        entries = [number(pdo.mapping, place) for place in range(1, count + 1)] if count <= MAX_ENTRIES else []
        fitting = _completed(entries, index, length)
    if fitting is None and is_refused and (parts := with_bytes(entries, index)):
        return Layout(parts, None not in entries, is_misfit=True)
    return fitting or Layout([Part(index, place, 8) for place in range(1, length + 1)], False)


def free_index(pdo: Pdo, taken: Collection[int]) -> int:
    """Return an index for the bytes of a PDO that the node does not use."""
    first = BYTES_OF_TPDO if pdo.is_transmitted else BYTES_OF_RPDO
    free = (index for index in range(first + pdo.number - 1, LAST_OF_MAKER) if index not in taken)
    return next(free, LAST_OF_MAKER)


def with_bytes(entries: Sequence[int | None], index: int) -> list[Part]:
    """Return the parts of the entries, with a byte for each that is not known; none if they do not fit into a PDO."""
    parts = [Part(index, place, 8) if entry is None else part_of(entry) for place, entry in enumerate(entries, 1)]
    fits = all(map(_is_usable, parts)) and sum(part.bits for part in parts) <= MAX_BITS
    return parts if fits else []


def part_of(entry: int) -> Part:
    """Return an entry of a mapping parameter as a part."""
    return Part(entry >> 16, entry >> 8 & 0xFF, entry & 0xFF)


def _completed(entries: Sequence[int | None], index: int, length: int) -> Layout | None:
    """Return the parts of the entries, in which unknown ones share the rest; None if they do not fit."""
    known = [part_of(entry) for entry in entries if entry is not None]
    unknown = len(entries) - len(known)
    rest = length * 8 - sum(part.bits for part in known)
    if not entries or not all(map(_is_usable, known)) or (not unknown and not 0 <= rest < 8):
        return None
    if unknown and (rest % 8 or not unknown <= rest // 8 <= unknown * MAX_BITS // 8):
        return None
    sizes = iter(_shares(rest // 8, unknown))
    parts = [
        part_of(entry) if entry is not None else Part(index, place, 8 * next(sizes))
        for place, entry in enumerate(entries, 1)
    ]
    return Layout(parts, not unknown)


def _read(pdo: Pdo, number: Number) -> Iterator[int]:
    """Yield the entries that were read of a mapping whose number of entries was not."""
    for place in range(1, MAX_ENTRIES + 1):
        entry = number(pdo.mapping, place)
        if not entry:
            return
        yield entry


def _filled_up(entries: Sequence[int], index: int, length: int) -> Layout | None:
    """Return the parts of the entries, with bytes up to the length of the frames; None if they do not fit."""
    parts = list(map(part_of, entries))
    rest = length * 8 - sum(part.bits for part in parts)
    if not parts or rest < 0 or not all(map(_is_usable, parts)):
        return None
    more = [Part(index, place, 8) for place in range(1, rest // 8 + 1)]
    return Layout(parts + more, not more)


def _shares(size: int, count: int) -> list[int]:
    """Return the bytes of each of `count` objects that share `size` bytes, the larger ones first."""
    return [size // count + (place < size % count) for place in range(count)] if count else []


def _is_usable(part: Part) -> bool:
    """True if an object of a data type has this length: one bit, or whole bytes."""
    return part.bits == 1 or (part.bits % 8 == 0 and part.bits > 0)
