"""The part of the EDS check for the presence of objects and for the object lists.

Source: CiA 306-1 4.6.2, CiA 301 7.4.
"""

import re
from collections.abc import Iterator

from fieldrig_devices.canopen.eds.check_objects import object_type
from fieldrig_devices.canopen.eds.finding import Finding, error
from fieldrig_devices.canopen.eds.source import EdsSource, Section
from fieldrig_devices.canopen.eds.text import FIRST_OBJECT

MANDATORY = (0x1000, 0x1001, 0x1018)
MANUFACTURER = range(0x2000, 0x6000)
PLACE = re.compile(r"[0-9]{1,9}")
"""Key of an entry in an object list."""
LISTS = ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects")
ERROR_CONTROL = (0x1017, 0x100C)


def check(source: EdsSource) -> Iterator[Finding]:
    described = {index: section for index, sub, section in source.objects() if sub is None and index >= FIRST_OBJECT}
    yield from _lists(source, described)
    for index in MANDATORY:
        if index not in described:
            yield error(
                1, f"{index:04X}", "", "the object is missing", "describe it: CiA 301 requires 1000h, 1001h and 1018h"
            )
    if not any(index in described for index in ERROR_CONTROL):
        yield error(1, "1017", "", "the file has neither heartbeat nor guarding", "describe 1017h, or 100Ch and 100Dh")


def _lists(source: EdsSource, described: dict[int, Section]) -> Iterator[Finding]:
    listed: dict[int, str] = {}
    for name in LISTS:
        section = source.get(name)
        if section is None:
            yield error(
                1, name, "", "the section is missing", f"write [{name}], with SupportedObjects=0 if it is empty"
            )
            continue
        count = section.number("SupportedObjects")
        entries = {key: entry for key, entry in section.entries.items() if PLACE.fullmatch(key)}
        if count != len(entries):
            yield error(
                section.line_of("SupportedObjects"),
                name,
                "SupportedObjects",
                section.get("SupportedObjects") or "is missing",
                f"expected {len(entries)}, the number of listed objects",
            )
        if sorted(map(int, entries)) != list(range(1, len(entries) + 1)):
            yield error(section.line, name, "", "the numbers have gaps", f"number them from 1 to {len(entries)}")
        for key, entry in entries.items():
            index = section.number(key)
            if index is None:
                yield error(entry.line, name, key, entry.value, "expected an index, such as 0x1018")
                continue
            yield from _listed(entry.line, name, key, index, listed, described)
    for index, section in described.items():
        if index not in listed and object_type(section) != 0:
            yield error(section.line, section.name, "", "is not in any list", f"add it to [{_list_of(index)}]")


def _listed(
    line: int, name: str, key: str, index: int, listed: dict[int, str], described: dict[int, Section]
) -> Iterator[Finding]:
    if index in listed:
        yield error(line, name, key, f"{index:#06x} is already listed in [{listed[index]}]", "list it only once")
    elif index not in described:
        yield error(
            line, name, key, f"{index:#06x} has no section", f"describe it in [{index:04X}], or remove it from the list"
        )
    elif _list_of(index) != name:
        yield error(line, name, key, f"{index:#06x} belongs in another list", f"move it to [{_list_of(index)}]")
    listed.setdefault(index, name)


def _list_of(index: int) -> str:
    if index in MANDATORY:
        return LISTS[0]
    return LISTS[2] if index in MANUFACTURER else LISTS[1]
