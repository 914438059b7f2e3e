"""The part of the EDS check for PDO mappings and COB-IDs.

Source: CiA 301 7.5.2.35 to 7.5.2.38, table 40 (pre-defined connection set), table 41 (restricted CAN-IDs).
"""

from collections.abc import Iterator

from fieldrig_devices.canopen.cob_id import INVALID, is_restricted, is_well_formed
from fieldrig_devices.canopen.datatypes import DATA_TYPES
from fieldrig_devices.canopen.eds.finding import Finding, error, warning
from fieldrig_devices.canopen.eds.source import EdsSource, Section, evaluate, has_node_id

MAX_BITS = 64
RPDO, TPDO = 0x1400, 0x1800
MAPPING = 0x200
MULTIPLEXED = (0xFE, 0xFF)

# COB-IDs of the pre-defined connection set by section, for node-ID 0.
PREDEFINED = (
    {"1014": 0x080, "1200sub1": 0x600, "1200sub2": 0x580}
    | {f"{RPDO + number:04x}sub1": 0x200 + 0x100 * number for number in range(4)}
    | {f"{TPDO + number:04x}sub1": 0x180 + 0x100 * number for number in range(4)}
)


def check(source: EdsSource) -> Iterator[Finding]:
    for index, sub, section in source.objects():
        if sub == 1 and _is_pdo(index):
            yield from _cob_id(section)
        if sub is None and _is_pdo(index) and source.get(f"{index + MAPPING:04X}") is None:
            yield error(section.line, section.name, "", "has no mapping", f"describe [{index + MAPPING:04X}]")
        if sub is None and _is_pdo(index - MAPPING):
            if source.get(f"{index - MAPPING:04X}") is None:
                yield error(
                    section.line,
                    section.name,
                    "",
                    "has no communication parameter",
                    f"describe [{index - MAPPING:04X}]",
                )
            yield from _mapping(source, index)
    for name in ("1005", "1012", "1014", "1200sub1", "1200sub2"):
        named = source.get(name)
        if named is not None:
            yield from _cob_id(named)


def _is_pdo(index: int) -> bool:
    return RPDO <= index < RPDO + 512 or TPDO <= index < TPDO + 512


def _cob_id(section: Section) -> Iterator[Finding]:
    key = "DefaultValue"
    text = section.get(key)
    try:
        cob_id = evaluate(text, 1)
    except ValueError:
        return
    if cob_id & INVALID and not has_node_id(text):
        return
    predefined = PREDEFINED.get(section.name.lower())
    if predefined is None:
        if is_restricted(cob_id) or not is_well_formed(cob_id):
            yield error(
                section.line_of(key),
                section.name,
                key,
                text,
                "expected a CAN-ID that CiA 301 doesn't restrict, such as 0x80",
            )
        return
    if not has_node_id(text) and cob_id != 0:
        yield warning(
            section.line_of(key),
            section.name,
            key,
            f"{text} is the same for all nodes made from this file",
            f"expected $NODEID+{predefined:#x}",
        )
    elif cob_id & 0x7FF != predefined + 1:
        yield warning(section.line_of(key), section.name, key, text, f"expected $NODEID+{predefined:#x}, as in CiA 301")


def _mapping(source: EdsSource, index: int) -> Iterator[Finding]:
    count_section = source.get(f"{index:04X}sub0")
    count = None if count_section is None else count_section.number("DefaultValue")
    if count is None or count in MULTIPLEXED:
        return
    is_received = index < TPDO
    total = 0
    for sub in range(1, min(count, MULTIPLEXED[0]) + 1):  # sub-indices are 8 bits wide
        section = source.get(f"{index:04X}sub{sub:X}")
        entry = None if section is None else section.number("DefaultValue")
        if section is None or entry is None:
            continue
        total += entry & 0xFF
        wrong = _wrong_entry(source, entry, is_received)
        if wrong:
            yield error(
                section.line_of("DefaultValue"), section.name, "DefaultValue", section.get("DefaultValue"), wrong
            )
    if total > MAX_BITS and count_section is not None:
        line = count_section.line_of("DefaultValue")
        yield error(
            line, count_section.name, "DefaultValue", f"{count} entries with {total} bits", "at most 64 bits fit"
        )


def _wrong_entry(source: EdsSource, entry: int, is_received: bool) -> str:
    """Return the remedy for a mapping entry, or "" if it is right."""
    index, sub, bits = entry >> 16, entry >> 8 & 0xFF, entry & 0xFF
    if index < 0x20:
        return _wrong_dummy(source, index, bits, is_received)
    target = source.get(f"{index:04X}sub{sub:X}") or _described_by_object(source, index, sub)
    if target is None:
        return f"expected an existing object: {index:04X}h sub-index {sub} is not described"
    if target.number("PDOMapping") != 1:
        return f"expected an object with PDOMapping=1, which [{target.name}] doesn't have"
    access = target.get("AccessType").lower()
    if access in (("ro", "const", "rwr") if is_received else ("wo", "rww")):
        pdo = "an RPDO" if is_received else "a TPDO"
        return f"expected another object: {pdo} cannot carry [{target.name}], AccessType={access}"
    data_type = DATA_TYPES.get(target.number("DataType") or 0)
    lengths = () if data_type is None or data_type.bits is None else (data_type.bits, (data_type.size or 0) * 8)
    if lengths and bits not in lengths:
        return f"expected 0x{entry >> 8:06X}{lengths[0]:02X}: [{target.name}] has {lengths[0]} bits"
    return ""


def _described_by_object(source: EdsSource, index: int, sub: int) -> Section | None:
    """Return the section of the object if it describes this sub-index: a single variable, or a compact array."""
    section = source.get(f"{index:04X}")
    members = 0 if section is None else section.number("CompactSubObj") or 0
    is_described = 1 <= sub <= members if members else sub == 0
    return section if is_described else None


def _wrong_dummy(source: EdsSource, index: int, bits: int, is_received: bool) -> str:
    usage = source.get("DummyUsage")
    if not is_received:
        return "expected an object: dummies are for RPDOs only"
    if usage is None or usage.number(f"Dummy{index:04d}") != 1:
        return f"expected a dummy that [DummyUsage] allows: write Dummy{index:04d}=1 there"
    data_type = DATA_TYPES.get(index)
    if data_type is None or data_type.bits != bits:
        return "expected the length of the dummy's data type"
    return ""
