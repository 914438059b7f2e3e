"""The part of the EDS check for each single object.

Source: CiA 306-1 4.6, CiA 301 table 44 (data types) and 7.5.2.
"""

import re
from collections.abc import Iterator

from fieldrig_devices.canopen import standard
from fieldrig_devices.canopen.datatypes import DATA_TYPES, DOMAIN
from fieldrig_devices.canopen.eds.finding import Finding, error, warning
from fieldrig_devices.canopen.eds.source import EdsSource, Section
from fieldrig_devices.canopen.eds.text import ARRAY, DEFSTRUCT, FIRST_OBJECT, RECORD, VAR

OBJECT_TYPES = (0, 2, 5, 6, 7, 8, 9)
STRUCTURED = (DEFSTRUCT, ARRAY, RECORD)
MAX_NAME = 241


def check(source: EdsSource) -> Iterator[Finding]:
    for index, sub, section in source.objects():
        if index < FIRST_OBJECT:
            continue
        owner = source.get(f"{index:04X}")
        if owner is None:
            yield error(section.line, section.name, "", "belongs to no object", f"add a section [{index:04X}]")
        elif sub is None and object_type(section) in STRUCTURED:
            yield from _names(section)
            yield from _structured(source, index, section)
        else:
            yield from _names(section)
            if sub is not None and object_type(owner) not in STRUCTURED:
                yield error(
                    section.line,
                    section.name,
                    "",
                    f"[{owner.name}] is not an ARRAY or RECORD",
                    "set its ObjectType to 0x8 or 0x9",
                )
            yield from _variable(section)


def object_type(section: Section) -> int:
    number = section.number("ObjectType")
    return VAR if number is None else number


def _names(section: Section) -> Iterator[Finding]:
    name = section.get("ParameterName")
    if not name:
        yield error(section.line, section.name, "ParameterName", "is missing", "write the name of the object")
    elif len(name) > MAX_NAME:
        yield error(
            section.line_of("ParameterName"),
            section.name,
            "ParameterName",
            "is too long",
            f"at most {MAX_NAME} characters are allowed",
        )
    if re.search(r"sub0[0-9A-F]", section.name, re.IGNORECASE):
        yield warning(
            section.line, section.name, "", "the sub-index has a leading zero", "expected the form [1018sub1]"
        )
    if section.get("ObjectType") and section.number("ObjectType") not in OBJECT_TYPES:
        yield error(
            section.line_of("ObjectType"),
            section.name,
            "ObjectType",
            section.get("ObjectType"),
            "expected 0x7 (VAR), 0x8 (ARRAY), 0x9 (RECORD) or 0x2 (DOMAIN)",
        )


def _structured(source: EdsSource, index: int, section: Section) -> Iterator[Finding]:
    if section.number("CompactSubObj"):
        return
    subs = {sub: member for of, sub, member in source.objects() if of == index and sub is not None}
    if section.number("SubNumber") != len(subs):
        yield error(
            section.line_of("SubNumber"),
            section.name,
            "SubNumber",
            section.get("SubNumber") or "is missing",
            f"expected {len(subs)}, the number of described sub-indices",
        )
    if 0 not in subs:
        yield error(section.line, section.name, "", "has no sub-index 0", f"describe it in [{index:04X}sub0]")
        return
    highest = max((sub for sub in subs if sub < standard.STRUCTURE), default=0)
    count = subs[0].number("DefaultValue")
    is_fixed = subs[0].get("AccessType").lower() in ("ro", "const")
    if is_fixed and subs[0].get("DefaultValue") and count != highest:
        yield error(
            subs[0].line_of("DefaultValue"),
            subs[0].name,
            "DefaultValue",
            subs[0].get("DefaultValue"),
            f"expected {highest}, the highest sub-index",
        )
    elif count is not None and count > highest and count < 0xFE:
        yield error(
            subs[0].line_of("DefaultValue"), subs[0].name, "DefaultValue", str(count), f"expected at most {highest}"
        )


def _variable(section: Section) -> Iterator[Finding]:
    """Check the rules of CiA 306 that the reader doesn't check itself."""
    if section.get("PDOMapping") and section.number("PDOMapping") not in (0, 1):
        yield error(
            section.line_of("PDOMapping"), section.name, "PDOMapping", section.get("PDOMapping"), "expected 0 or 1"
        )
    number, access = section.number("DataType"), section.get("AccessType").lower()
    data_type = DATA_TYPES.get(number or 0)
    if section.number("PDOMapping") == 1 and data_type is not None and (data_type.bits or 0) > 64:
        yield error(
            section.line_of("PDOMapping"),
            section.name,
            "PDOMapping",
            "1",
            f"expected 0: {data_type.name} is longer than a PDO",
        )
    if section.number("PDOMapping") == 1 and access == "rw":
        what = "rw with PDOMapping=1 has no clear mapping direction"
        remedy = "expected rww for an object of an RPDO, rwr for one of a TPDO"
        yield warning(section.line_of("AccessType"), section.name, "AccessType", what, remedy)
    if access == "const" and not section.get("DefaultValue") and data_type not in (None, DOMAIN):
        yield error(section.line, section.name, "DefaultValue", "is missing", "write the value of the constant")
