"""The part of the EDS check that looks at each object.

Source: CiA 306-1 4.6, CiA 301 table 44 (data types) and 7.5.2.
"""

import re
from collections.abc import Iterator

from fieldrig_devices.canopen import standard
from fieldrig_devices.canopen.datatypes import DATA_TYPES, DOMAIN, Boolean, DataType, Integer, Real
from fieldrig_devices.canopen.eds_finding import Finding, error, warning
from fieldrig_devices.canopen.eds_source import EdsSource, Section, evaluate, has_node_id
from fieldrig_devices.canopen.eds_text import ARRAY, DEFSTRUCT, RECORD, VAR
from fieldrig_devices.canopen.eds_text import DOMAIN as DOMAIN_OBJECT

OBJECT_TYPES = (0, 2, 5, 6, 7, 8, 9)
ACCESS_TYPES = ("ro", "wo", "rw", "rwr", "rww", "const")
STRUCTURED = (DEFSTRUCT, ARRAY, RECORD)
FIRST_OBJECT = 0x1000
MAX_NAME = 241
HEX_BY_H = re.compile(r"[0-9a-f]+h", re.IGNORECASE)


def check(source: EdsSource) -> Iterator[Finding]:
    for index, sub, section in source.objects():
        if index < FIRST_OBJECT:
            continue
        owner = source.get(f"{index:04X}")
        if owner is None:
            yield error(section.line, section.name, "", "belongs to no object", f"write a section [{index:04X}]")
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
                    f"[{owner.name}] is no ARRAY or RECORD",
                    "set its ObjectType to 0x8 or 0x9",
                )
            yield from _variable(index, sub or 0, section)


def object_type(section: Section) -> int:
    number = section.number("ObjectType")
    return VAR if number is None else number


def _names(section: Section) -> Iterator[Finding]:
    name = section.get("ParameterName")
    if not name:
        yield error(section.line, section.name, "ParameterName", "is missing", "give it the name of the object")
    elif len(name) > MAX_NAME:
        yield error(
            section.line_of("ParameterName"),
            section.name,
            "ParameterName",
            "is too long",
            f"at most {MAX_NAME} characters",
        )
    if re.search(r"sub0[0-9A-F]", section.name, re.IGNORECASE):
        yield warning(section.line, section.name, "", "sub-index with a leading zero", "write it like [1018sub1]")
    if section.get("ObjectType") and section.number("ObjectType") not in OBJECT_TYPES:
        yield error(
            section.line_of("ObjectType"),
            section.name,
            "ObjectType",
            section.get("ObjectType"),
            "0x7 (VAR), 0x8 (ARRAY), 0x9 (RECORD) or 0x2 (DOMAIN)",
        )


def _structured(source: EdsSource, index: int, section: Section) -> Iterator[Finding]:
    if section.number("CompactSubObj"):
        return
    subs = {sub: one for of, sub, one in source.objects() if of == index and sub is not None}
    if section.number("SubNumber") != len(subs):
        yield error(
            section.line_of("SubNumber"),
            section.name,
            "SubNumber",
            section.get("SubNumber") or "is missing",
            f"{len(subs)}, as many sub-indices as are described",
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
            f"{highest}, the highest sub-index",
        )
    elif count is not None and count > highest and count < 0xFE:
        yield error(subs[0].line_of("DefaultValue"), subs[0].name, "DefaultValue", str(count), f"at most {highest}")


def _variable(index: int, sub: int, section: Section) -> Iterator[Finding]:
    number = section.number("DataType")
    is_domain = section.number("ObjectType") == DOMAIN_OBJECT and number is None
    data_type = DOMAIN if is_domain else DATA_TYPES.get(number or 0)
    if data_type is None:
        what = section.get("DataType") or "is missing"
        yield error(
            section.line_of("DataType"), section.name, "DataType", what, "a type of CiA 301, such as 0x0005 (UNSIGNED8)"
        )
    access = section.get("AccessType").lower()
    if access not in ACCESS_TYPES and not (is_domain and not access):
        what = section.get("AccessType") or "is missing"
        yield error(
            section.line_of("AccessType"), section.name, "AccessType", what, f"one of {', '.join(ACCESS_TYPES)}"
        )
    if section.get("PDOMapping") and section.number("PDOMapping") not in (0, 1):
        yield error(section.line_of("PDOMapping"), section.name, "PDOMapping", section.get("PDOMapping"), "0 or 1")
    if data_type is None:
        return
    yield from _standard(index, sub, section, data_type)
    if section.number("PDOMapping") == 1 and (data_type.bits or 0) > 64:
        yield error(
            section.line_of("PDOMapping"), section.name, "PDOMapping", "1", f"0: {data_type.name} is longer than a PDO"
        )
    if access == "const" and not section.get("DefaultValue") and data_type is not DOMAIN:
        yield error(section.line, section.name, "DefaultValue", "is missing", "a constant needs its value")
    yield from _values(section, data_type)


def _standard(index: int, sub: int, section: Section, data_type: DataType) -> Iterator[Finding]:
    wanted = standard.wanted(index, sub)
    if wanted is not None and wanted is not data_type:
        number = next(number for number, one in DATA_TYPES.items() if one is wanted)
        remedy = f"0x{number:04X} ({wanted.name}), as CiA 301 has it"
        yield error(section.line_of("DataType"), section.name, "DataType", section.get("DataType"), remedy)


def _values(section: Section, data_type: DataType) -> Iterator[Finding]:
    """Default value and limits, each for itself and against the others."""
    found: dict[str, float] = {}
    for key in ("DefaultValue", "ParameterValue", "LowLimit", "HighLimit"):
        text = section.get(key)
        if not text:
            continue
        if not isinstance(data_type, Integer | Real | Boolean):
            if key in ("LowLimit", "HighLimit"):
                yield warning(
                    section.line_of(key), section.name, key, text, f"{data_type.name} has no limits: leave it out"
                )
            continue
        try:
            found[key] = _number(text, data_type)
        except ValueError as wrong:
            yield error(section.line_of(key), section.name, key, text, str(wrong))
    low, high = found.get("LowLimit"), found.get("HighLimit")
    if low is not None and high is not None and low > high:
        yield error(
            section.line_of("LowLimit"), section.name, "LowLimit", section.get("LowLimit"), "not more than HighLimit"
        )
        return
    for key in ("DefaultValue", "ParameterValue"):
        value = found.get(key)
        is_beyond = value is not None and ((low is not None and value < low) or (high is not None and value > high))
        if is_beyond and not has_node_id(section.get(key)):
            limits = f"{section.get('LowLimit') or 'any'} to {section.get('HighLimit') or 'any'}"
            yield error(section.line_of(key), section.name, key, section.get(key), f"within the limits, {limits}")


def _number(text: str, data_type: DataType) -> float:
    """ValueError with what would be right."""
    if isinstance(data_type, Real):
        try:
            return float(text)
        except ValueError as cause:
            raise ValueError(f"a decimal number for {data_type.name}, such as 0.5") from cause
    if HEX_BY_H.fullmatch(text) and not text.isdigit():
        raise ValueError(f"0x{text[:-1].upper()}: hexadecimal numbers begin with 0x")
    try:
        value = evaluate(text, 127)
    except ValueError as cause:
        raise ValueError("a number, such as 10 or 0x0A, or one with $NODEID, such as $NODEID+0x180") from cause
    if (
        isinstance(data_type, Integer)
        and data_type.is_signed
        and text.lower().startswith("0x")
        and value > data_type.high
    ):
        value -= 1 << data_type.bits  # two's complement
    low, high = data_type.low or 0, data_type.high or 0
    if not low <= value <= high:
        raise ValueError(f"from {low:.0f} to {high:.0f}, what {data_type.name} can hold")
    return value
