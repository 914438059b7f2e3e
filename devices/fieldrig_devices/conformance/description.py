"""What the EDS promises, read with canopen's reader and shared with no line of our own node.

Source: CiA 306-1 4.6, CiA 301 table 44 (data types).
"""

import configparser
import re
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TextIO

from canopen.objectdictionary import ObjectDictionary, ODVariable
from canopen.objectdictionary.eds import import_eds

from fieldrig.errors import UsageError

BOOLEAN, DOMAIN = 0x01, 0x0F
SIGNED = {0x02: 8, 0x03: 16, 0x04: 32, 0x10: 24, 0x12: 40, 0x13: 48, 0x14: 56, 0x15: 64}
UNSIGNED = {BOOLEAN: 8, 0x05: 8, 0x06: 16, 0x07: 32, 0x16: 24, 0x18: 40, 0x19: 48, 0x1A: 56, 0x1B: 64}
OTHERS = {0x08: 32, 0x11: 64, 0x0C: 48, 0x0D: 48}
"""REAL32, REAL64, TIME_OF_DAY, TIME_DIFFERENCE."""
BITS = {**SIGNED, **UNSIGNED, **OTHERS}

PARSE: Callable[[TextIO, int], ObjectDictionary] = import_eds

FIRST_OBJECT, LAST_OF_COMMUNICATION = 0x1000, 0x1FFF
FIRST_SERVER = {"1200:01": 0x600, "1200:02": 0x580}
"""Always followed by the node-ID (CiA 301 7.5.2.33), also where the file was written for another node."""
OBJECT = re.compile(r"[0-9A-F]{4}", re.IGNORECASE)
COMPACT = "CompactSubObj"
READABLE, WRITABLE = ("ro", "rw", "rwr", "rww", "const"), ("wo", "rw", "rwr", "rww")


@dataclass(frozen=True, slots=True)
class Entry:
    """One sub-index as the EDS describes it."""

    index: int
    sub: int
    name: str
    type: int
    access: str
    default: bytes | None
    """As bytes on the bus; None if the EDS has none, or one that can't be made out."""
    low: int | None
    high: int | None
    is_mappable: bool

    @property
    def key(self) -> str:
        return f"{self.index:04X}h:{self.sub:02X}h"

    @property
    def size(self) -> int | None:
        """In bytes; None where any length will do."""
        bits = BITS.get(self.type)
        return None if bits is None else bits // 8

    @property
    def pdo_bits(self) -> int:
        """Its length in a PDO; 0 where the type has none."""
        return 1 if self.type == BOOLEAN else BITS.get(self.type, 0)

    @property
    def is_integer(self) -> bool:
        return self.type in SIGNED or self.type in UNSIGNED

    @property
    def is_readable(self) -> bool:
        return self.access in READABLE

    @property
    def is_writable(self) -> bool:
        return self.access in WRITABLE

    @property
    def range(self) -> tuple[int, int]:
        """What an integer type can hold."""
        if self.type in SIGNED:
            half = 1 << SIGNED[self.type] - 1
            return -half, half - 1
        return 0, (1 << UNSIGNED[self.type]) - 1

    def encode(self, value: int) -> bytes:
        return value.to_bytes(self.size or 4, "little", signed=self.type in SIGNED)


class Description:
    def __init__(self, path: Path, node_id: int) -> None:
        """UsageError if canopen's reader can't make anything of the file."""
        self.path, self.node_id = path, node_id
        try:
            with path.open(encoding="latin-1") as file:
                parsed = PARSE(file, node_id)
            compact = _compact(path)
        except (OSError, ValueError, LookupError, configparser.Error) as cause:
            raise UsageError(f"{path} is no EDS that can be read: {cause}", "`fieldrig eds check` says more") from cause
        self.entries = {(entry.index, entry.sub): entry for entry in _entries(parsed)}
        for index, count in compact.items():
            self._expand(index, count)
        for key, cob_id in FIRST_SERVER.items():
            self.set_default(key, cob_id + node_id)
        self.dummies = {index for index in parsed.indices if index < FIRST_OBJECT and index in BITS}

    def set_default(self, key: str, value: bool | int | float | str) -> None:
        """A power-on value of another source, for an entry such as `1017:00`; what isn't there is passed over."""
        index, _, sub = key.partition(":")
        entry = self.entries.get((int(index, 16), int(sub, 16)))
        if entry is not None:
            data = entry.encode(value) if isinstance(value, int) and entry.is_integer else None
            self.entries[entry.index, entry.sub] = replace(entry, default=data)

    def _expand(self, index: int, count: int) -> None:
        """A compact array, of which canopen's reader keeps the first member and no count (CiA 306-1 4.6.3.2)."""
        number, first = self.entries[index, 0], self.entries[index, 1]
        self.entries[index, 0] = replace(number, access="ro", default=bytes((count,)))
        for sub in range(1, count + 1):
            self.entries[index, sub] = replace(first, sub=sub)

    def __contains__(self, index: int) -> bool:
        return any(entry.index == index for entry in self.entries.values())

    def __iter__(self) -> Iterator[Entry]:
        """In order of index and sub-index."""
        return iter([self.entries[key] for key in sorted(self.entries)])

    def get(self, index: int, sub: int = 0) -> Entry | None:
        return self.entries.get((index, sub))

    def members(self, index: int) -> list[Entry]:
        """The entries of an object from sub-index 1 on, without the description of its structure (FFh)."""
        return [entry for entry in self if entry.index == index and 0 < entry.sub < 0xFF]

    def indices(self, first: int, last: int) -> list[int]:
        return sorted({index for index, _ in self.entries if first <= index <= last})


def _compact(path: Path) -> dict[int, int]:
    """How many members each compact array has.  ValueError for what is no number."""
    text = configparser.RawConfigParser(strict=False, allow_no_value=True, inline_comment_prefixes=(";",))
    text.read(path, encoding="latin-1")
    counts = {
        int(name, 16): int(text.get(name, COMPACT, fallback=None) or "0", 0)
        for name in text.sections()
        if OBJECT.fullmatch(name)
    }
    return {index: count for index, count in counts.items() if count > 0}


def _entries(parsed: ObjectDictionary) -> Iterator[Entry]:
    for index in sorted(parsed.indices):
        found = parsed.indices[index]
        if index >= FIRST_OBJECT:
            for variable in [found] if isinstance(found, ODVariable) else found.subindices.values():
                yield _entry(variable)


def _entry(variable: ODVariable) -> Entry:
    return Entry(
        variable.index,
        variable.subindex,
        variable.name,
        variable.data_type or 0,
        variable.access_type,
        _default(variable),
        variable.min,
        variable.max,
        variable.pdo_mappable,
    )


def _default(variable: ODVariable) -> bytes | None:
    """A DCF's ParameterValue goes before DefaultValue."""
    value = variable.value if getattr(variable, "value", None) is not None else variable.default
    if value is None or variable.data_type == DOMAIN:
        return None
    if variable.data_type in SIGNED and isinstance(value, int):
        bits = SIGNED[variable.data_type]
        return (value & (1 << bits) - 1).to_bytes(bits // 8, "little")
    try:
        return bytes(variable.encode_raw(value))
    except (ValueError, TypeError, OverflowError, struct.error):
        return None
