"""The object dictionary that a recording shows of a node, as rows of an EDS."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

from fieldrig_devices.canopen.cob_id import INVALID
from fieldrig_devices.canopen.datatypes import DATA_TYPES, Boolean, Integer
from fieldrig_devices.canopen.eds.source import NODE_ID
from fieldrig_devices.canopen.emcy import COB_ID as EMCY_COB_ID
from fieldrig_devices.canopen.io_names import io_name, io_variable
from fieldrig_devices.canopen.pdo import rpdo, tpdo
from fieldrig_devices.canopen.pdo.mapping import MAX_BITS
from fieldrig_devices.canopen.pdo_maps import TO_MAPPING
from fieldrig_devices.canopen.standard import STRUCTURE
from fieldrig_devices.canopen.variable import FIRST_APPLICATION_INDEX, Access
from fieldrig_devices.cia402.objects import Row
from fieldrig_devices.from_recording.known_objects import (
    BOOLEAN,
    OCTETS,
    TEXT,
    UNSIGNED,
    names_of_drives,
    of_drives,
    standard_variable,
    type_number,
)
from fieldrig_devices.from_recording.layout import BYTES, DUMMIES, Layout, Part, free_index, part_of, with_bytes
from fieldrig_devices.from_recording.object_rules import Value, access_of, limits_of, mapped_access
from fieldrig_devices.from_recording.objects import Key, ObjectLog, ObjectLogs
from fieldrig_devices.from_recording.pdos import MOST, Pdo, is_mapping
from fieldrig_devices.from_recording.rhythm import Rhythm

LONGEST_KEPT: Final = 4_096
"""Bytes of a value of variable length that the rig file gets."""
COMMANDS: Final = {0x1003: 0, 0x1010: 1, 0x1011: 1}
"""Objects whose written values are commands, with what they hold at the start."""
MANDATORY: Final = ((0x1000, 0), (0x1001, 0), (0x1018, 1))


class DescribedNode:
    """Rows by index and sub-index, names of the objects with sub-indices, and values that no EDS can hold."""

    def __init__(self, node_id: int, *, is_drive: bool, is_io: bool = False) -> None:
        """`is_io` says that the node is an I/O module of CiA 401."""
        self.node_id, self.is_drive, self.is_io = node_id, is_drive, is_io
        self.rows: dict[Key, Row] = {}
        self.names: dict[int, str] = {}
        self.values: dict[Key, str] = {}
        """Values for the rig file: texts and bytes that an EDS has no notation for."""
        self.written: dict[Key, int] = {}
        """Last numbers of the parameters."""
        self.unread_mappings: dict[int, str] = {}
        """Mapping parameters whose objects are not all known, with what they map here."""
        self.too_long: dict[Key, int] = {}
        """Sizes of the values that are left out."""

    # ---- what an SDO client has seen

    def take(self, logs: ObjectLogs) -> None:
        """Take the objects that were read or written."""
        for key, log in logs.there().items():
            self.rows[key] = self._row(key, log)
            if key[0] < FIRST_APPLICATION_INDEX and log.last is not None:
                self.written[key] = int.from_bytes(log.last, "little")

        for index in {index for index, _ in self.rows if is_mapping(index)}:
            self._settle_mapping(index, logs)

    def _settle_mapping(self, index: int, logs: ObjectLogs) -> None:
        """Let a mapping begin with what was written last, if not all of what it was before has been read."""
        rows = {subindex: row for (of, subindex), row in self.rows.items() if of == index}
        written = {subindex for subindex in rows if logs.by_key[index, subindex].first is None}
        if written and len(written) < len(rows):
            for subindex in rows:
                self.rows[index, subindex] = replace(rows[subindex], start=self.written[index, subindex])

    def _row(self, key: Key, log: ObjectLog) -> Row:
        index, subindex = key
        known = standard_variable(index, subindex, self.is_drive)
        data = log.start or b""
        size = next(iter(log.sizes)) if len(log.sizes) == 1 else len(data) if not log.sizes else None
        type = type_number(index, subindex, size, data, self.is_drive)
        access = access_of(log, "ro" if known is None else known.access.value)
        name = (known.name if known is not None else "") or self._plain_name(index, subindex)
        start: Value = self._start(key, type, data)
        if isinstance(start, int) and start & 0x7F == self.node_id and self._is_own_cob_id(index, subindex, start):
            start = f"{NODE_ID}+{start - self.node_id:#x}"
        if self.is_drive and log.first is None and known is not None and known.access is Access.RWW:
            start = int(known.value)  # an order of the master, which says nothing of the value at power-on
        if index in COMMANDS and log.first is None and (subindex or index == 0x1003):
            start = COMMANDS[index]
        if access == "const" and start == "":
            access = "ro"  # a constant has its value in the file
        has_rules = index < FIRST_APPLICATION_INDEX or (self.is_drive and known is not None)
        low, high = (None, None) if has_rules else limits_of(log, DATA_TYPES[type], start)
        return Row(index, subindex, name, type, access, start, known is not None and known.is_mappable, low, high)

    def _plain_name(self, index: int, subindex: int) -> str:
        """Return the name of an object that is not one of CiA 301 or of a drive."""
        known = io_variable(index, subindex) if self.is_io else None
        return f"Object {index:04X}h" + (f", sub-index {subindex}" if subindex else "") if known is None else known.name

    def _is_own_cob_id(self, index: int, subindex: int, cob_id: int) -> bool:
        """True for a COB-ID of the predefined connection set, which follows the node-ID."""
        if index == EMCY_COB_ID:
            return cob_id & 0x780 == 0x080
        if subindex != 1 or not (0x1400 <= index < 0x1600 or 0x1800 <= index < 0x1A00):
            return False
        is_transmitted = index >= tpdo.COMMUNICATION
        first = tpdo.COMMUNICATION if is_transmitted else rpdo.COMMUNICATION
        return Pdo(is_transmitted, index - first + 1).predefined(self.node_id) == cob_id & 0x7FF

    def _start(self, key: Key, type: int, data: bytes) -> Value:
        data_type = DATA_TYPES[type]
        if isinstance(data_type, Integer | Boolean):
            size = data_type.size or 1
            return int(data_type.decode(data[:size].ljust(size, b"\0")))
        text = str(data_type.decode(data))
        is_plain = text.isascii() and text.isprintable() and text == text.strip() and ";" not in text
        if type == TEXT and is_plain and not text.startswith(NODE_ID):
            return text
        if len(data) <= LONGEST_KEPT:
            self.values[key] = text
        else:
            self.too_long[key] = len(data)
        return ""

    # ---- what everyone on the bus has seen

    def take_pdo(self, pdo: Pdo, identifier: int, layout: Layout, rhythm: Rhythm | None, data: int) -> None:
        """Take a PDO with its identifier and its first data; a node receives PDOs at any time, without a rhythm."""
        self.names.setdefault(pdo.parameter, f"{pdo.name} parameter")
        self.names.setdefault(pdo.mapping, f"{pdo.name} mapping")
        cob_id: Value = identifier
        if identifier == pdo.predefined(self.node_id):
            cob_id = f"{NODE_ID}+{identifier - self.node_id:#x}"
        self._own(pdo.parameter, 1, "COB-ID", UNSIGNED[4], cob_id)
        self._own(pdo.parameter, 2, "Transmission type", UNSIGNED[1], 255 if rhythm is None else rhythm.type)
        if rhythm is not None:
            self._own(pdo.parameter, 3, "Inhibit time", UNSIGNED[2], rhythm.inhibit_100us)
            self._own(pdo.parameter, 5, "Event timer", UNSIGNED[2], rhythm.event_ms)
        self._own(pdo.mapping, 0, "Number of mapped objects", UNSIGNED[1], len(layout.parts))
        firsts = layout.values(data if pdo.is_transmitted else 0)
        for place, (part, first) in enumerate(zip(layout.parts, firsts, strict=True), 1):
            self._own(pdo.mapping, place, f"Mapped object {place}", UNSIGNED[4], part.entry)
            if part.object not in DUMMIES:
                self._map(pdo, part, first, layout.is_known)
        if not self._agrees(pdo, layout):  # the parameter was read, and does not fit the frames
            self.put(pdo.mapping, 0, "Number of mapped objects", UNSIGNED[1], "rw", len(layout.parts))
            for place, part in enumerate(layout.parts, 1):
                self.put(pdo.mapping, place, f"Mapped object {place}", UNSIGNED[4], "rw", part.entry)

    def _agrees(self, pdo: Pdo, layout: Layout) -> bool:
        """True if the node begins without a mapping, as its master gives it one, or with this layout."""
        starts = [self.rows[pdo.mapping, place].start for place in range(len(layout.parts) + 1)]
        if starts[0] == 0:
            return True
        return starts == [len(layout.parts), *(part.entry for part in layout.parts)]

    def _own(self, index: int, subindex: int, name: str, type: int, start: Value) -> None:
        """Add a parameter, unless an SDO client has seen it."""
        row = self.rows.get((index, subindex))
        if row is None:
            self.rows[index, subindex] = Row(index, subindex, name, type, "rw", start)
        else:
            self.rows[index, subindex] = replace(row, name=name, access="rw")

    def _map(self, pdo: Pdo, part: Part, first: int, is_known: bool) -> None:
        """Add an object that a PDO carries, or let the one that is there be mapped."""
        index, subindex, bits = part
        row = self.rows.get((index, subindex))
        if row is None:
            known = standard_variable(index, subindex, self.is_drive)
            size = (bits + 7) // 8
            type = BOOLEAN if bits == 1 else UNSIGNED.get(size, OCTETS)
            name = self._plain_name(index, subindex)
            if known is not None and known.type.bits == bits:
                type, name = type_number(index, subindex, size, b"", self.is_drive), known.name
            if not is_known and index in BYTES:
                self.names[index] = f"{pdo.name}, bytes"
                name = f"{pdo.name}, {'byte' if size == 1 else 'part'} {subindex}"
            start = self._start((index, subindex), type, first.to_bytes(size, "little"))
            row = Row(index, subindex, name, type, "ro" if pdo.is_transmitted else "rww", start)
        self.rows[index, subindex] = replace(row, is_mappable=True, access=mapped_access(row.access, pdo))

    def add(self, index: int, subindex: int, name: str, type: int, access: str, start: Value = 0) -> None:
        """Add an object that the node must have for what the recording shows, unless it is there."""
        self.rows.setdefault((index, subindex), Row(index, subindex, name, type, access, start))

    def put(self, index: int, subindex: int, name: str, type: int, access: str, start: Value) -> None:
        """Add an object, or give the one that is there this value."""
        self.add(index, subindex, name, type, access)
        self.rows[index, subindex] = replace(self.rows[index, subindex], start=start)

    def complete(self) -> None:
        """Add what every node has."""
        for index, subindex in MANDATORY:
            variable = of_drives().get(index, subindex)
            assert variable is not None, "our own EDS has the mandatory objects"
            type = type_number(index, subindex, None, b"", False)
            self.add(index, subindex, variable.name, type, "ro")
        for index in sorted({index for index, _ in self.rows}):
            self._complete_record(index)
            self._complete_pdo(index)
            if is_mapping(index) and not self._has_room(index):
                self._settle_unread(index)
        for (index, subindex), row in list(self.rows.items()):
            if subindex and is_mapping(index) and isinstance(row.start, int):
                self._complete_mapping(index, {row.start, self.written.get((index, subindex), 0)})

    def _complete_record(self, index: int) -> None:
        """Add the highest sub-index that the node itself names in sub-index 0, if no master has asked for it."""
        rows = {subindex: row for (of, subindex), row in self.rows.items() if of == index}
        highest = rows[0].start if 0 in rows and not is_mapping(index) else 0
        if not isinstance(highest, int) or not (len(rows) > 1 or self._has_subindices(index)):
            return
        if highest >= STRUCTURE:
            self.rows[index, 0] = replace(rows[0], start=max(rows))
        elif max(rows) < highest:
            alike = rows[max(rows)].type if max(rows) else UNSIGNED[4]
            type = type_number(index, highest, DATA_TYPES[alike].size, b"", self.is_drive)
            self.add(index, highest, self._plain_name(index, highest), type, "ro")

    def _has_room(self, index: int) -> bool:
        """True if what a mapping begins with fits into a PDO."""
        bits = [entry & 0xFF if entry else 0 for entry in self._entries(index)]
        return all(bits) and sum(bits) <= MAX_BITS

    def _entries(self, index: int) -> list[int | None]:
        """Return what a mapping begins with; None for an entry that was not read."""
        count = self.rows[index, 0].start if (index, 0) in self.rows else 0
        rows = [self.rows.get((index, place)) for place in range(1, int(count) + 1)]
        return [row.start if row is not None and isinstance(row.start, int) and row.start else None for row in rows]

    def _settle_unread(self, index: int) -> None:
        """Let a mapping of which not all was read have a byte for each other object; it maps none if that is too much.

        So it has the number of objects that a master has read, and the master may write it.
        """
        entries = self._entries(index)
        pdo = _pdo_of(index)
        parts = (
            with_bytes(entries, free_index(pdo, {index for index, _ in self.rows})) if len(entries) <= MAX_BITS else []
        )
        if (index, 0) in self.rows:
            self.unread_mappings[index] = "a byte for each of the others here" if parts else "it maps none at power-on"
        if not parts:
            self.put(index, 0, "Number of mapped objects", UNSIGNED[1], "rw", 0)
        for place, part in enumerate(parts, 1):
            if entries[place - 1] is None:
                self.put(index, place, f"Mapped object {place}", UNSIGNED[4], "rw", part.entry)
                self._map(pdo, part, 0, False)

    def _complete_mapping(self, index: int, entries: set[int]) -> None:
        """Add the mapped objects that no master has read, as they can be mapped only if they exist."""
        for entry in sorted(entries):
            part = part_of(entry)
            if entry and part.bits and part.object not in DUMMIES:
                self._map(_pdo_of(index), part, 0, True)

    def _complete_pdo(self, index: int) -> None:
        """Give a PDO of which only one parameter was seen the other one: without mapping, or switched off."""
        for first, word in ((tpdo.COMMUNICATION, "TPDO"), (rpdo.COMMUNICATION, "RPDO")):
            number = index - first + 1
            if 0 < number <= MOST:
                self.names.setdefault(index, f"{word} {number} parameter")
                self.names.setdefault(index + TO_MAPPING, f"{word} {number} mapping")
                self.add(index, 1, "COB-ID", UNSIGNED[4], "rw", INVALID)
                self.add(index + TO_MAPPING, 0, "Number of mapped objects", UNSIGNED[1], "rw")
            elif 0 < number - TO_MAPPING <= MOST:
                self._complete_pdo(index - TO_MAPPING)

    # ---- for the file

    def listed(self) -> Iterator[Row]:
        """Yield the rows as an EDS has them: the only row of an object without sub-indices has none."""
        by_index: dict[int, list[Row]] = {}
        for key in sorted(self.rows):
            by_index.setdefault(key[0], []).append(self.rows[key])
        for index, rows in by_index.items():
            is_single = [row.subindex for row in rows] == [0] and not self._has_subindices(index)
            yield from (replace(row, subindex=None) if is_single else row for row in rows)

    def _has_subindices(self, index: int) -> bool:
        return index in self.names or (self._is_standard(index) and of_drives().get(index, 1) is not None)

    def _is_standard(self, index: int) -> bool:
        return index < FIRST_APPLICATION_INDEX or self.is_drive

    def names_of_all(self) -> Mapping[int, str]:
        standard = names_of_drives()
        return {
            index: self.names.get(index)
            or (standard.get(index, "") if self._is_standard(index) else "")
            or (io_name(index) if self.is_io else "")
            or f"Object {index:04X}h"
            for index, _ in self.rows
        }


def _pdo_of(mapping: int) -> Pdo:
    """Return the PDO of a mapping parameter."""
    is_transmitted = mapping >= tpdo.COMMUNICATION
    first = (tpdo.COMMUNICATION if is_transmitted else rpdo.COMMUNICATION) + TO_MAPPING
    return Pdo(is_transmitted, mapping - first + 1)
