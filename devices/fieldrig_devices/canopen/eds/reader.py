"""Reads an EDS or DCF file into the object dictionary of a node.

Source: CiA 306-1 4.6.  ParameterValue of a DCF takes precedence over DefaultValue.  The reader accepts whatever it can
interpret, regardless of the tool that wrote it; oddities become findings, which the checks report.  An object whose
data type is unknown is left out.  A file is refused only if it has no object then.
"""

import math
import re
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from fieldrig_devices.canopen import emcy, standard
from fieldrig_devices.canopen.datatypes import DATA_TYPES, DOMAIN, DataType, Integer, Real
from fieldrig_devices.canopen.dictionary import Dictionary, Features
from fieldrig_devices.canopen.eds.finding import NO_OBJECT, Finding, error, warning
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
"""Other spellings of access types, reduced to their letters."""
MAPPINGS = (*range(rpdo.MAPPING, rpdo.MAPPING + 512), *range(tpdo.MAPPING, tpdo.MAPPING + 512))
UNSIGNED32 = DATA_TYPES[0x07]
FIRST_SERVER = {(0x1200, 1): 0x600, (0x1200, 2): 0x580}
"""COB-IDs of the first SDO server without the node-ID, which is always added (CiA 301 7.5.2.33)."""
LAST_OF_STANDARD = 0x1B
"""Highest data type of the standard; those above are manufacturer-specific."""
CHECKED_AS = 127
"""The node-ID with which a file is checked."""


class Description(NamedTuple):
    """The content of a file for one node."""

    variables: list[Variable]
    given: frozenset[tuple[int, int]]
    """Index and sub-index of the variables whose power-on value the file gives."""
    dummies: dict[int, int]
    features: Features
    findings: list[Finding]


def load(path: Path, node_id: int) -> Dictionary:
    """Return the dictionary of node `node_id`.  Raises EdsError with all reasons for which the file is refused."""
    description = describe(path, node_id)
    return Dictionary(
        (variable.fresh() for variable in description.variables), description.dummies, description.features
    )


def describe(path: Path, node_id: int) -> Description:
    """Return the description of node `node_id`; its variables belong to the cache.  Raises EdsError as `load` does."""
    description = _describe(path, node_id, path.stat().st_mtime_ns)
    refused = [finding for finding in description.findings if finding.is_refused]
    if refused:
        raise EdsError(path, refused)
    return description


def oddities(path: Path) -> list[Finding]:
    """Return the findings of the reader.  Raises OSError if the file cannot be read."""
    return _describe(path, CHECKED_AS, path.stat().st_mtime_ns).findings


@lru_cache(maxsize=32)
def _describe(path: Path, node_id: int, mtime_ns: int) -> Description:
    """Read the file once for all callers: the check of the settings, the device, and its tools."""
    text = EdsText(EdsSource(path))
    builder = _Builder(text, node_id)
    described = list(text.variables())
    highest = {variable.object: variable.sub for variable in described if variable.sub < standard.STRUCTURE}
    built = [builder.build(variable, highest.get(variable.object, 0)) for variable in described]
    variables = [variable for variable in built if variable is not None]
    if described and not variables:
        builder.findings.append(NO_OBJECT)
    dummies = {
        number: DATA_TYPES[number].bits or 0 for number in range(1, 8) if is_one(text.dummies.get(f"Dummy{number:04d}"))
    }
    findings = list(dict.fromkeys([*text.findings, *builder.findings]))
    given = frozenset(builder.given)
    return Description(variables, given, dummies, _features(text.device_info), findings)


def _features(device_info: Section) -> Features:
    """Return the features of the section DeviceInfo, whose bit rates are in kbit/s."""
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
    """Makes variables from their descriptions, and collects findings and the variables that have values."""

    def __init__(self, text: EdsText, node_id: int) -> None:
        self._text, self._node_id = text, node_id
        self.findings: list[Finding] = []
        self.given: set[tuple[int, int]] = set()

    def build(self, source: Described, highest: int) -> Variable | None:
        """Return the variable, or None if its data type is unknown."""
        data_type, access = self._type(source), self._access(source)
        if data_type is None:
            return None
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

    def _type(self, source: Described) -> DataType | None:
        section, key = source.section, "DataType"
        said, wanted = section.get(key), standard.wanted(source.object, source.sub)
        if not said and source.is_domain:
            return DOMAIN
        number = section.number(key)
        found = self._known_type(section, number)
        if found is None and wanted is None:
            remedy = "expected a data type of CiA 301, such as 0x0005 (UNSIGNED8); the object is left out"
            self._find(error(section.line_of(key), section.name, key, said or "is missing", remedy))
            return None
        if wanted is None or found is wanted:
            return found or DOMAIN
        is_same = found is not None and source.object == standard.STORED_EDS
        right = next(number for number, known in DATA_TYPES.items() if known is wanted)
        remedy = f"expected 0x{right:04X} ({wanted.name}), as in CiA 301"
        how = warning if is_same else error
        self._find(how(section.line_of(key), section.name, key, said or "is missing", remedy))
        return found if is_same and found is not None else wanted

    def _known_type(self, section: Section, number: int | None) -> DataType | None:
        if number is None or number <= LAST_OF_STANDARD:
            return DATA_TYPES.get(number or 0)
        base = self._text.base_type(number)
        if base in DATA_TYPES:
            return DATA_TYPES[base or 0]
        remedy = "expected a data type of CiA 301, such as 0x0005 (UNSIGNED8); it is read as DOMAIN"
        self._find(warning(section.line_of("DataType"), section.name, "DataType", section.get("DataType"), remedy))
        return DOMAIN

    def _access(self, source: Described) -> Access:
        section, key = source.section, "AccessType"
        said = section.get(key)
        access = ACCESS.get(said.lower())
        if access is not None or (source.is_domain and not said):
            return access or Access.RW
        access = OTHER_ACCESS.get(re.sub("[^a-z]", "", said.lower()), Access.RW)
        remedy = f"expected one of {', '.join(ACCESS)}; it is read as {access.value}"
        how = warning if said else error
        self._find(how(section.line_of(key), section.name, key, said or "is missing", remedy))
        return access

    def _start(self, source: Described, data_type: DataType, limits: Limits, highest: int) -> bytes:
        """Return the power-on value: that of the file, or the value nearest to zero within the limits."""
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
        """Return the value of a key, or None if there is none or it cannot be read."""
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
            said = section.get("LowLimit") or ""
            is_no_limit = isinstance(data_type, Integer) and not data_type.is_signed and said.startswith("-")
            ignored = "the limit is ignored" if is_no_limit else "both limits are ignored"
            remedy = f"expected at most HighLimit; {ignored}"
            self._find(error(section.line_of("LowLimit"), section.name, "LowLimit", said, remedy))
            return None, high if is_no_limit else None
        return low, high

    def _limit(self, section: Section, key: str, data_type: DataType) -> float | None:
        text = section.get(key)
        if not text or has_node_id(text):
            return None
        if not isinstance(data_type, Integer | Real):
            if data_type.bits != 1:
                remedy = f"remove it: {data_type.name} has no limits"
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
                limits_text = f"{section.get('LowLimit') or 'any'} to {section.get('HighLimit') or 'any'}"
                remedy = f"expected a value within the limits, {limits_text}"
                self._find(error(section.line_of(key), section.name, key, section.get(key), remedy))


def _count(index: int, highest: int) -> int:
    """Return sub-index 0 if the file gives no value: the highest sub-index, or 0 where it counts valid entries."""
    return 0 if index == emcy.HISTORY or index in MAPPINGS else highest


def _tighter(limit: float | None, of_type: float | None) -> float | None:
    """Return the limit, or None if it is that of the data type."""
    return None if limit == of_type else limit
