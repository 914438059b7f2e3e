"""From an EDS or DCF file to the object dictionary of a node.

Source: CiA 306-1 4.6.  A DCF's ParameterValue goes before DefaultValue.  What can be read is read, whatever tool wrote
it; what is odd is a finding, which the checks name; and a file is refused only for what leaves an object without a
meaning: a data type that can't be told.
"""

import math
import re
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from fieldrig_devices.canopen import emcy, standard
from fieldrig_devices.canopen.datatypes import DATA_TYPES, DOMAIN, DataType, Integer, Real
from fieldrig_devices.canopen.dictionary import Dictionary, Features
from fieldrig_devices.canopen.eds.finding import Finding, error, refusal, warning
from fieldrig_devices.canopen.eds.source import EdsSource, Section, has_node_id
from fieldrig_devices.canopen.eds.text import Described, EdsError, EdsText
from fieldrig_devices.canopen.eds.values import is_one, read_value
from fieldrig_devices.canopen.pdo import rpdo, tpdo
from fieldrig_devices.canopen.variable import Access, Variable

ACCESS = {access.value: access for access in Access}
OTHER_ACCESS = {
    **dict.fromkeys(("r", "read", "readonly", "rd"), Access.RO),
    **dict.fromkeys(("w", "write", "writeonly", "wr"), Access.WO),
    **dict.fromkeys(("rw", "readwrite", "writeread"), Access.RW),
    "constant": Access.CONST,
}
"""By their letters alone."""
MAPPINGS = (*range(rpdo.MAPPING, rpdo.MAPPING + 512), *range(tpdo.MAPPING, tpdo.MAPPING + 512))
UNSIGNED32 = DATA_TYPES[0x07]
FIRST_SERVER = {(0x1200, 1): 0x600, (0x1200, 2): 0x580}
"""COB-IDs without the node-ID, which they always follow (CiA 301 7.5.2.33), whatever node the file was written for."""
LAST_OF_STANDARD = 0x1B
"""Data types above are a maker's own."""
CHECKED_AS = 127
"""The node-ID with which a file is checked."""


class Description(NamedTuple):
    """What a file says of one node."""

    variables: list[Variable]
    given: frozenset[tuple[int, int]]
    """Index and sub-index of the variables whose power-on value is in the file."""
    dummies: dict[int, int]
    features: Features
    findings: list[Finding]


def load(path: Path, node_id: int) -> Dictionary:
    """The dictionary of node `node_id` as the file describes it.  EdsError names everything that stands in the way."""
    description = describe(path, node_id)
    return Dictionary(
        (variable.fresh() for variable in description.variables), description.dummies, description.features
    )


def describe(path: Path, node_id: int) -> Description:
    """What the file says of node `node_id`; its variables belong to the cache.  EdsError as of `load`."""
    description = _describe(path, node_id, path.stat().st_mtime_ns)
    refused = [one for one in description.findings if one.is_refused]
    if refused:
        raise EdsError(path, refused)
    return description


def oddities(path: Path) -> list[Finding]:
    """What is odd or wrong in the file for its reader.  OSError if there is no such file."""
    return _describe(path, CHECKED_AS, path.stat().st_mtime_ns).findings


@lru_cache(maxsize=32)
def _describe(path: Path, node_id: int, mtime_ns: int) -> Description:
    """Read once for all that ask: the check of the settings, the device, its tools."""
    text = EdsText(EdsSource(path))
    builder = _Builder(text, node_id)
    described = list(text.variables())
    highest = {one.object: one.sub for one in described if one.sub < standard.STRUCTURE}
    variables = [builder.build(one, highest.get(one.object, 0)) for one in described]
    dummies = {
        number: DATA_TYPES[number].bits or 0 for number in range(1, 8) if is_one(text.dummies.get(f"Dummy{number:04d}"))
    }
    findings = list(dict.fromkeys([*text.findings, *builder.findings]))
    given = frozenset(builder.given)
    return Description(variables, given, dummies, _features(text.device_info), findings)


def _features(device_info: Section) -> Features:
    """A rate is in kbit/s."""
    rates = tuple(
        rate for rate in (10, 20, 50, 125, 250, 500, 800, 1000) if is_one(device_info.get(f"BaudRate_{rate}"))
    )
    return Features(
        is_one(device_info.get("LSS_Supported")),
        is_one(device_info.get("GroupMessaging")),
        tuple(rate * 1000 for rate in rates),
    )


Limits = tuple[float | None, float | None]
"""LowLimit and HighLimit."""


class _Builder:
    """Makes variables from their descriptions, and remembers what was odd and which values were given."""

    def __init__(self, text: EdsText, node_id: int) -> None:
        self._text, self._node_id = text, node_id
        self.findings: list[Finding] = []
        self.given: set[tuple[int, int]] = set()

    def build(self, source: Described, highest: int) -> Variable:
        data_type, access = self._type(source), self._access(source)
        low, high = self._limits(source.section, data_type)
        return Variable(
            source.object,
            source.sub,
            source.name,
            data_type,
            access,
            start=self._start(source, data_type, (low, high), highest),
            low=_tighter(low, data_type.low),
            high=_tighter(high, data_type.high),
            is_mappable=is_one(source.section.get("PDOMapping")),
        )

    def _find(self, found: Finding) -> None:
        self.findings.append(found)

    def _type(self, source: Described) -> DataType:
        section, key = source.section, "DataType"
        said, wanted = section.get(key), standard.wanted(source.object, source.sub)
        if not said and source.is_domain:
            return DOMAIN
        number = section.number(key)
        found = self._known_type(section, number)
        if found is None and wanted is None:
            remedy = "a type of CiA 301, such as 0x0005 (UNSIGNED8)"
            self._find(refusal(section.line_of(key), section.name, key, said or "is missing", remedy))
            return DOMAIN
        if wanted is None or found is wanted:
            return found or DOMAIN
        is_same = found is not None and source.object == standard.STORED_EDS
        right = next(number for number, one in DATA_TYPES.items() if one is wanted)
        remedy = f"0x{right:04X} ({wanted.name}), as CiA 301 has it"
        how = warning if is_same else error
        self._find(how(section.line_of(key), section.name, key, said or "is missing", remedy))
        return found if is_same and found is not None else wanted

    def _known_type(self, section: Section, number: int | None) -> DataType | None:
        if number is None or number <= LAST_OF_STANDARD:
            return DATA_TYPES.get(number or 0)
        base = self._text.base_type(number)
        if base in DATA_TYPES:
            return DATA_TYPES[base or 0]
        remedy = "a type of CiA 301, such as 0x0005 (UNSIGNED8); it is read as DOMAIN"
        self._find(warning(section.line_of("DataType"), section.name, "DataType", section.get("DataType"), remedy))
        return DOMAIN

    def _access(self, source: Described) -> Access:
        section, key = source.section, "AccessType"
        said = section.get(key)
        access = ACCESS.get(said.lower())
        if access is not None or (source.is_domain and not said):
            return access or Access.RW
        access = OTHER_ACCESS.get(re.sub("[^a-z]", "", said.lower()), Access.RW)
        remedy = f"one of {', '.join(ACCESS)}; it is read as {access.value}"
        how = warning if said else error
        self._find(how(section.line_of(key), section.name, key, said or "is missing", remedy))
        return access

    def _start(self, source: Described, data_type: DataType, limits: Limits, highest: int) -> bytes:
        """The power-on value: from the file, or the nearest to zero that the limits allow."""
        if (source.object, source.sub) in FIRST_SERVER and data_type is UNSIGNED32:
            return data_type.encode(FIRST_SERVER[source.object, source.sub] + self._node_id)
        values = [self._value(source.section, key, data_type) for key in ("ParameterValue", "DefaultValue")]
        self._check_within(source.section, data_type, limits, values)
        found = next((value for value in values if value is not None), None)
        if found is not None:
            self.given.add((source.object, source.sub))
            return found
        if source.sub == 0 and source.is_member:
            return data_type.encode(_count(source.object, highest)) if isinstance(data_type, Integer) else b""
        if data_type.size is None:
            return b""
        low, high = limits
        nearest = low if low is not None and low > 0 else high if high is not None and high < 0 else 0
        return data_type.encode(nearest if isinstance(data_type, Real) else int(nearest))

    def _value(self, section: Section, key: str, data_type: DataType) -> bytes | None:
        """None if there is none that can be read."""
        text = section.get(key)
        if not text or data_type is DOMAIN:
            return None
        try:
            value, remedy = read_value(data_type, text, self._node_id)
        except ValueError as wrong:
            self._find(error(section.line_of(key), section.name, key, text, str(wrong)))
            return None
        if remedy:
            self._find(warning(section.line_of(key), section.name, key, text, remedy))
        return value

    def _limits(self, section: Section, data_type: DataType) -> Limits:
        low, high = (self._limit(section, key, data_type) for key in ("LowLimit", "HighLimit"))
        if low is not None and high is not None and low > high:
            said = section.get("LowLimit")
            remedy = "not more than HighLimit; both are ignored"
            self._find(error(section.line_of("LowLimit"), section.name, "LowLimit", said, remedy))
            return None, None
        return low, high

    def _limit(self, section: Section, key: str, data_type: DataType) -> float | None:
        text = section.get(key)
        if not text or has_node_id(text):
            return None
        if not isinstance(data_type, Integer | Real):
            if data_type.bits != 1:
                remedy = f"{data_type.name} has no limits: leave it out"
                self._find(warning(section.line_of(key), section.name, key, text, remedy))
            return None
        value = self._value(section, key, data_type)
        limit = None if value is None else data_type.decode(value)
        return limit if isinstance(limit, int | float) and not math.isnan(limit) else None

    def _check_within(self, section: Section, data_type: DataType, limits: Limits, values: list[bytes | None]) -> None:
        low, high = limits
        for key, data in zip(("ParameterValue", "DefaultValue"), values, strict=True):
            value = None if data is None else data_type.decode(data)
            if not isinstance(value, int | float) or has_node_id(section.get(key)):
                continue
            if (low is not None and value < low) or (high is not None and value > high):
                remedy = f"within the limits, {section.get('LowLimit') or 'any'} to {section.get('HighLimit') or 'any'}"
                self._find(error(section.line_of(key), section.name, key, section.get(key), remedy))


def _count(index: int, highest: int) -> int:
    """Sub-index 0 without a value: the highest sub-index, except where it counts what is there for now."""
    return 0 if index == emcy.HISTORY or index in MAPPINGS else highest


def _tighter(limit: float | None, of_type: float | None) -> float | None:
    """A limit that the type doesn't set anyway."""
    return None if limit == of_type else limit
