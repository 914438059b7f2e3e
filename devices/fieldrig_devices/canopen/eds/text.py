"""The objects of an EDS or DCF file, with everything explicit that the standard leaves implicit.

Source: CiA 306-1 4.6.  Tolerated: sections and keys in any case and order, encodings other than ASCII, repeated
sections and keys (the later one applies), sub-indices without their object, an object type that doesn't fit the
sub-indices.  Compact sub-objects are expanded.  Left out: modules, dynamic channels, `CompactPDO`.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from fieldrig_devices.canopen.eds.finding import NO_OBJECT, Finding, error
from fieldrig_devices.canopen.eds.source import EdsSource, Entry, Section

DOMAIN, DEFTYPE, DEFSTRUCT, VAR, ARRAY, RECORD = 2, 5, 6, 7, 8, 9
"""Object types of CiA 301."""

FIRST_OBJECT = 0x1000
"""Index of the first object; those below are data types."""
LAST_SUB_INDEX = 0xFE
OBJECT = re.compile(r"(?P<index>[0-9A-F]{1,4})(?:SUB(?P<sub>[0-9A-F]{1,2}))?", re.IGNORECASE)
COMPACT = re.compile(r"(?P<index>[0-9A-F]{4})(?P<what>NAME|VALUE)", re.IGNORECASE)

Place = tuple[int, int | None]
"""Index and sub-index; the sub-index is None for the object itself."""


class EdsError(ValueError):
    """An EDS or DCF file is refused; the message has one line for each reason."""

    def __init__(self, path: Path, findings: list[Finding]) -> None:
        super().__init__("\n".join(f"{path.name}:{finding}" for finding in findings))
        self.findings = findings


class Described(NamedTuple):
    """The description of one variable in the file."""

    object: int
    """Index of the object."""
    sub: int
    name: str
    section: Section
    is_member: bool
    """True for a member of an array or record."""
    is_domain: bool


class EdsText:
    def __init__(self, source: EdsSource) -> None:
        self.findings: list[Finding] = []
        self._objects: dict[Place, Section] = {}
        self._compact: dict[tuple[int, str], Section] = {}
        for section in source.every:
            self._take(section)
        self._is_empty = not any(index >= FIRST_OBJECT for index, _ in self._objects)
        if self._is_empty:
            self.findings.append(NO_OBJECT)
        self.dummies = source.get("DummyUsage") or Section("DummyUsage", 1)
        self.device_info = source.get("DeviceInfo") or Section("DeviceInfo", 1)

    def variables(self) -> Iterator[Described]:
        """Yield all variables in order of index and sub-index."""
        for index in sorted({index for index, _ in self._objects if index >= FIRST_OBJECT}):
            subs = {sub: self._objects[index, sub] for i, sub in self._objects if i == index and sub is not None}
            owner = self._objects.get((index, None)) or Section(
                f"{index:04X}", min(section.line for section in subs.values())
            )
            yield from self._object(index, owner, subs)

    def base_type(self, number: int) -> int | None:
        """Return the base of a data type that the file defines as an object of that index, as CANFestival does."""
        described = self._objects.get((number, 1))
        return None if described is None else described.number("DefaultValue")

    def _take(self, section: Section) -> None:
        name = section.name.strip()
        if match := OBJECT.fullmatch(name):
            place = int(match["index"], 16), None if match["sub"] is None else int(match["sub"], 16)
            merged = self._objects.setdefault(place, Section(name, section.line))
            merged.entries |= {entry.key.lower(): entry for entry in section.every if entry.value}
        elif match := COMPACT.fullmatch(name):
            self._compact[int(match["index"], 16), match["what"].lower()] = section

    def _object(self, index: int, owner: Section, subs: dict[int, Section]) -> Iterator[Described]:
        object_type = owner.number("ObjectType")
        if object_type in (DEFTYPE, DEFSTRUCT, 0):  # not an object of the node
            return
        name = owner.get("ParameterName") or f"Object {index:04X}h"
        members = dict(self._expanded(index, owner, name)) | {
            sub: (section.get("ParameterName") or f"{name} {sub}", section) for sub, section in subs.items()
        }
        if 0 not in members and owner.get("DataType") and (not members or object_type not in (ARRAY, RECORD)):
            yield Described(index, 0, name, owner, bool(members), object_type == DOMAIN)
        elif not members and object_type not in (ARRAY, RECORD):
            yield Described(index, 0, name, owner, False, object_type == DOMAIN)
        for sub in sorted(members):
            member, section = members[sub]
            yield Described(index, sub, member, section, True, section.number("ObjectType") == DOMAIN)

    def _expanded(self, index: int, owner: Section, name: str) -> Iterator[tuple[int, tuple[str, Section]]]:
        """Expand a compact description, with its exceptions in [<index>Name] and [<index>Value] (4.6.3.3)."""
        count = owner.number("CompactSubObj")
        if owner.get("CompactSubObj") and (count is None or not 0 <= count <= LAST_SUB_INDEX):
            said = owner.get("CompactSubObj")
            self.findings.append(
                error(
                    owner.line_of("CompactSubObj"), owner.name, "CompactSubObj", said, f"expected 0 to {LAST_SUB_INDEX}"
                )
            )
            count = 0 if count is None else min(max(count, 0), LAST_SUB_INDEX)
        if not count:
            return
        names, values = (self._compact.get((index, what), Section("", 0)) for what in ("name", "value"))
        number_of = {"DataType": "5", "AccessType": "ro", "DefaultValue": str(count)}
        yield 0, ("Number of entries", _made(owner, [Entry(owner.line, *pair) for pair in number_of.items()]))
        template = [entry for entry in owner.every if entry.key.lower() not in ("parametername", "objecttype")]
        for sub in range(1, count + 1):
            own = values.entries.get(str(sub))
            exception = [Entry(own.line, "ParameterValue", own.value)] if own is not None and own.value else []
            yield sub, (names.get(str(sub)) or f"{name} {sub}", _made(owner, [*template, *exception]))


def _made(owner: Section, entries: list[Entry]) -> Section:
    made = Section(owner.name, owner.line)
    made.entries = {entry.key.lower(): entry for entry in entries}
    return made
