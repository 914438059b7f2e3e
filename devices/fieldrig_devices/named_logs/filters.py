"""Which rows of a log are chosen: by node, identifier, unit, register and kind of service.

Nodes and identifiers choose among the rows of CAN buses, units and registers among those of Modbus buses; several of
one kind are alternatives.  The name of a device chooses on all buses where nothing else does.  A bus for which none is
given has no rows then.  A service chooses on all buses.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Final

from fieldrig.errors import UsageError
from fieldrig.text.nearest import closest
from fieldrig_bus.can.frame import EXTENDED_MASK
from fieldrig_devices.canopen.cob_id import EXTENDED_KEY
from fieldrig_devices.named_logs.row import Row
from fieldrig_devices.registers.named import NamedRegisters

SERVICES: Final = (
    "sdo", "pdo", "tpdo", "rpdo", "emcy", "nmt", "heartbeat", "boot-up", "guarding", "loss", "sync", "time", "lss",
    "modbus", "read", "write", "exception", "abort", "unanswered", "broadcast", "stray", "error", "other",
)  # fmt: skip
REFERENCES: Final = {0: "coils", 1: "discrete_inputs", 3: "input_registers", 4: "holding_registers"}
"""The kinds of the numbers that manuals use, by their first digit: 40001 is the first holding register."""
_ADDRESSES: Final = {
    "coil": "coils", "discrete": "discrete_inputs", "input": "input_registers", "holding": "holding_registers",
}  # fmt: skip
MOST_SEEN: Final = 1_000
"""Different numbers that are remembered, for the message about one that the log does not have."""

Range = tuple[str, int, int]
"""Space, first address and number of registers or bits."""


@dataclass
class Filter:
    """The words of the options; an empty kind chooses all."""

    nodes: Sequence[str] = ()
    """Node-IDs, or names of devices of the rig; a * in a name matches any characters."""
    identifiers: Sequence[str] = ()
    """Such as 0x181, 0x180-0x1FF, or 0x180/0x780 with a mask."""
    units: Sequence[str] = ()
    registers: Sequence[str] = ()
    """Such as 40001, 40001-40010, holding:0, or the name of a register table."""
    services: Sequence[str] = ()
    tables: Sequence[tuple[int, NamedRegisters]] = ()
    """The register tables that are known, with their units."""

    def __post_init__(self) -> None:
        """Raise ValueError, with what was expected, for a wrong word."""
        self._ids = [identifiers_of(word) for word in self.identifiers]
        self._units = {_number(word, 255, "a unit") for word in self.units}
        self._ranges = [self._ranges_of(word) for word in self.registers]
        for word in self.services:
            if word not in SERVICES:
                raise ValueError(f"{word!r} is no kind of service\n{closest(word, SERVICES)}")
        self._nodes = {word: None if not word.isdigit() else _number(word, 127, "a node") for word in self.nodes}
        self._seen: dict[str, dict[str, None]] = {"node": {}, "unit": {}}

    @property
    def is_any(self) -> bool:
        """True if something is left out."""
        return bool(self.nodes or self.identifiers or self.units or self.registers or self.services)

    def chosen(self, rows: Iterable[Row]) -> Iterator[Row]:
        """Yield the rows that are chosen.  UsageError at the end for a node or unit of which the log has nothing."""
        if not self.is_any:
            yield from rows
            return
        for row in rows:
            self._note(row)
            if self.takes(row):
                yield row
        self._check_there("node", self.nodes)
        self._check_there("unit", self.units)

    def takes(self, row: Row) -> bool:
        """Return whether a row is chosen."""
        if self.services and not any(word in row.services for word in self.services):
            return False
        if not (self.nodes or self.identifiers or self.units or self.registers):
            return True
        if row.family == "can" and (self.nodes or self.identifiers):
            return self._is_of_nodes(row) and self._has_identifier(row)
        if row.family == "modbus" and (self.units or self.registers):
            return (not self._units or row.unit in self._units) and self._has_register(row)
        return any(number is None and fnmatchcase(row.node, word) for word, number in self._nodes.items())

    def _note(self, row: Row) -> None:
        """Remember what the log has, and which words fit to it."""
        for node_id in row.node_ids:
            self._see("node", str(node_id), row.node)
        if row.unit is not None:
            self._see("unit", str(row.unit), "")
        if row.node and not row.node_ids:
            self._see("node", "", row.node)

    def _see(self, kind: str, number: str, name: str) -> None:
        seen = self._seen[kind]
        for word in (number, name):
            if word and word not in seen and len(seen) < MOST_SEEN:
                seen[word] = None

    def _is_of_nodes(self, row: Row) -> bool:
        return not self._nodes or any(
            number in row.node_ids if number is not None else fnmatchcase(row.node, word)
            for word, number in self._nodes.items()
        )

    def _has_identifier(self, row: Row) -> bool:
        return not self._ids or any(
            first <= key & mask <= last for key in row.identifiers for first, last, mask in self._ids
        )

    def _has_register(self, row: Row) -> bool:
        return not self._ranges or any(
            space == other and first < start + count and start < first + length
            for ranges in self._ranges
            for unit, (space, first, length) in ranges
            if unit is None or unit == row.unit
            for other, start, count in row.registers
        )

    def _ranges_of(self, word: str) -> list[tuple[int | None, Range]]:
        """Return what a word chooses, each with its unit if it is that of one."""
        found = register_range(word)
        if found is not None:
            return [(None, found)]
        named = [
            (unit, place)
            for unit, table in self.tables
            for name, place in table.addresses().items()
            if fnmatchcase(name, word)
        ]
        if not named:
            known = sorted({name for _, table in self.tables for name in table.addresses()})
            remedy = closest(word, known) if known else "expected such as 40001 or holding:0; a name needs --registers"
            raise ValueError(f"there is no register {word!r}\n{remedy}")
        return [(unit, place) for unit, place in named]

    def _check_there(self, kind: str, words: Sequence[str]) -> None:
        seen = list(self._seen[kind])
        for word in words:
            if not any(fnmatchcase(known, word) for known in seen):
                raise UsageError(f"the log has no messages of {kind} {word}", closest(word, seen))


_WORD: Final = re.compile(r"(0x[0-9a-f]+|[0-9]+)(?:([-/])(0x[0-9a-f]+|[0-9]+))?(x?)", re.IGNORECASE)


def identifiers_of(word: str) -> tuple[int, int, int]:
    """Return first, last and mask of identifiers; those above 7FFh, and those with an x behind, have 29 bits.

    ValueError, with what was expected, for any other word.
    """
    match = _WORD.fullmatch(word)
    if match is None:
        raise ValueError(f"{word!r} is no identifier\nexpected such as 0x181, 0x180-0x1FF or 0x180/0x780")
    first, second = int(match[1], 0), int(match[3], 0) if match[3] else None
    highest = max(first, second or 0)
    if highest > EXTENDED_MASK:
        raise ValueError(f"{word!r}: {highest:X}h is too large\nexpected at most 1FFFFFFFh")
    flag = EXTENDED_KEY if highest > 0x7FF or match[4] else 0
    if match[2] == "/" and second is not None:
        return first & second | flag, first & second | flag, second | EXTENDED_KEY
    last = first if second is None else second
    if last < first:
        raise ValueError(f"{word!r}: the last identifier is below the first")
    return first | flag, last | flag, EXTENDED_KEY | EXTENDED_MASK


def register_range(word: str) -> Range | None:
    """Return what `40001`, `40001-40010` or `holding:0-9` choose; None for a name.  ValueError for a wrong number."""
    kind, colon, rest = word.partition(":")
    first, dash, last = (rest if colon else word).partition("-")
    if not first.isdigit() or (dash and not last.isdigit()):
        return None
    if colon:
        space = _ADDRESSES.get(kind)
        if space is None:
            raise ValueError(f"{word!r}: {kind} is no kind of register\n{closest(kind, list(_ADDRESSES))}")
        begin, end = int(first), int(last or first)
    else:
        (space, begin), (_, end) = _reference(first), _reference(last or first)
    if not 0 <= begin <= end <= 0xFFFF:
        raise ValueError(f"{word!r}: expected addresses up to 65535, the lower one first")
    return space, begin, end - begin + 1


def _reference(text: str) -> tuple[str, int]:
    """Return space and address of a number such as 40001 or 400001, whose counting begins at 1."""
    digits = text if len(text) in (5, 6) else text.rjust(5, "0")
    space, number = REFERENCES.get(int(digits[0])), int(digits[1:])
    if space is None or not 1 <= number <= 65536:
        raise ValueError(f"{text} is no register\nexpected such as 40001 (holding), 30001 (input), 10001 or 1 (bits)")
    return space, number - 1


def _number(word: str, highest: int, what: str) -> int:
    if not word.isascii() or not word.isdigit() or int(word) > highest:
        raise ValueError(f"{word!r} is not {what}\nexpected a number up to {highest}")
    return int(word)
