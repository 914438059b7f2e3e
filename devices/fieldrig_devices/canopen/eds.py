"""From an EDS or DCF file to the object dictionary of a node, with canopen's reader.

Source: CiA 306-1 4.6.  A DCF's ParameterValue goes before DefaultValue.  canopen's reader passes over what it
can't make out; here that is an error of the configuration, with its section and what would be right.
"""

from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple, TextIO

from canopen.objectdictionary import ObjectDictionary, ODVariable
from canopen.objectdictionary.eds import import_eds

from fieldrig_devices.canopen import emcy, rpdo, standard, tpdo
from fieldrig_devices.canopen.datatypes import DATA_TYPES, DOMAIN, Boolean, DataType, Integer, Octets, Real, Value
from fieldrig_devices.canopen.dictionary import Dictionary, Features
from fieldrig_devices.canopen.eds_text import EdsError, EdsText, Section, name_section, parse_number
from fieldrig_devices.canopen.variable import Access, Variable

ACCESS = {access.value: access for access in Access} | {"r": Access.RO, "w": Access.WO, "constant": Access.CONST}
MAPPINGS = (*range(rpdo.MAPPING, rpdo.MAPPING + 512), *range(tpdo.MAPPING, tpdo.MAPPING + 512))
PARSE: Callable[[TextIO, int], ObjectDictionary] = import_eds
FIRST_OBJECT = 0x1000
UNSIGNED32 = DATA_TYPES[0x07]
FIRST_SERVER = {(0x1200, 1): 0x600, (0x1200, 2): 0x580}
"""COB-IDs without the node-ID, which they always follow (CiA 301 7.5.2.33), whatever node the file was written for."""
"""Below are data types; the ones among the variables are dummies."""


def load(path: Path, node_id: int) -> Dictionary:
    """The dictionary of node `node_id` as the file describes it.  EdsError names everything that is wrong."""
    description = _describe(path, node_id, path.stat().st_mtime_ns)
    return Dictionary(
        (variable.fresh() for variable in description.variables), description.dummies, description.features
    )


class _Description(NamedTuple):
    variables: list[Variable]
    dummies: dict[int, int]
    features: Features


@lru_cache(maxsize=32)
def _describe(path: Path, node_id: int, mtime_ns: int) -> _Description:
    """Read once for all that ask: the check of the settings, the device, its tools."""
    text = EdsText(path)
    if text.problems:
        raise EdsError(path, text.problems)
    parsed = PARSE(text.canonical(), node_id)
    builder = _Builder(text, node_id)
    variables = [builder.build(one) for one in _variables(parsed)]
    problems = builder.problems or list(standard.problems(variables))
    if problems:
        raise EdsError(path, problems)
    dummies = {index: _bits(DATA_TYPES[index]) for index in parsed.indices if index in DATA_TYPES}
    return _Description(variables, dummies, _features(text.device_info))


def _features(device_info: Section) -> Features:
    """Of keys in lower case; a rate is in kbit/s."""

    def is_on(key: str) -> bool:
        try:
            return parse_number(device_info.get(key, "0")) != 0
        except ValueError:
            return False

    rates = tuple(rate for rate in (10, 20, 50, 125, 250, 500, 800, 1000) if is_on(f"baudrate_{rate}"))
    return Features(is_on("lss_supported"), is_on("groupmessaging"), tuple(rate * 1000 for rate in rates))


def _variables(parsed: ObjectDictionary) -> Iterator[ODVariable]:
    for index in sorted(parsed.indices):
        found = parsed.indices[index]
        if index >= FIRST_OBJECT:
            yield from [found] if isinstance(found, ODVariable) else found.subindices.values()


def _bits(data_type: DataType) -> int:
    return data_type.bits or 0


Limits = tuple[float | None, float | None]
"""LowLimit and HighLimit."""


class _Builder:
    """Makes our variables from canopen's, and remembers what was wrong."""

    def __init__(self, text: EdsText, node_id: int) -> None:
        self._text, self._node_id = text, node_id
        self.problems: list[str] = []

    def build(self, source: ODVariable) -> Variable:
        where, section = self._section(source)
        data_type = DATA_TYPES.get(source.data_type or 0)
        if data_type is None:
            wrong = f"{section['DataType']}: no data type; right would be, for example, 0x0005 (UNSIGNED8)"
            self._problem(where, "DataType", wrong)
            data_type = DOMAIN
        access = ACCESS.get(source.access_type)
        if access is None:
            self._problem(
                where, "AccessType", f"{source.access_type}: right would be {', '.join(a.value for a in Access)}"
            )
        low = self._limit(where, section, "LowLimit", data_type, source.min)
        high = self._limit(where, section, "HighLimit", data_type, source.max)
        if low is not None and high is not None and low > high:
            self._problem(where, "LowLimit", f"{low}: not above HighLimit, which is {high}, would be right")
        return Variable(
            source.index,
            source.subindex,
            source.name,
            data_type,
            access or Access.RW,
            start=self._start(where, section, source, data_type, (low, high)),
            low=_tighter(low, data_type.low),
            high=_tighter(high, data_type.high),
            is_mappable=source.pdo_mappable,
        )

    def _section(self, source: ODVariable) -> tuple[str, Section]:
        sections = self._text.objects
        where: tuple[int, int | None] = (source.index, source.subindex)
        if where not in sections or int(sections[source.index, None].get("ObjectType", "7")) in (2, 7):
            where = (source.index, None)
        return name_section(*where), sections[where]

    def _start(self, where: str, section: Section, source: ODVariable, data_type: DataType, limits: Limits) -> bytes:
        """The power-on value: from the file, or the nearest to zero that the limits allow."""
        key, value = (
            ("ParameterValue", source.value) if "ParameterValue" in section else ("DefaultValue", source.default)
        )
        if (source.index, source.subindex) in FIRST_SERVER and data_type is UNSIGNED32:
            return data_type.encode(FIRST_SERVER[source.index, source.subindex] + self._node_id)
        if key in section and data_type is not DOMAIN:
            try:
                return data_type.encode(_value(data_type, section[key], value))
            except ValueError as wrong:
                self._problem(where, key, str(wrong))
        if source.subindex == 0 and not isinstance(source.parent, ObjectDictionary):
            return data_type.encode(_count(source)) if isinstance(data_type, Integer) else b""
        if data_type.size is None:
            return b""
        low, high = limits
        return data_type.encode(
            int(low if low is not None and low > 0 else high if high is not None and high < 0 else 0)
        )

    def _limit(self, where: str, section: Section, key: str, data_type: DataType, found: int | None) -> float | None:
        text = section.get(key)
        if text is None or "$NODEID" in text.upper() or not isinstance(data_type, Integer | Real):
            return None
        try:
            value = _value(data_type, text, found)
            data_type.encode(value)
        except ValueError as wrong:
            self._problem(where, key, str(wrong))
            return None
        return float(value) if isinstance(data_type, Real) else int(value)

    def _problem(self, where: str, key: str, wrong: str) -> None:
        self.problems.append(f"[{where}] {key} = {wrong}")


def _value(data_type: DataType, text: str, found: Any) -> Value:
    """What canopen made of `text`, put right where it passes over something or knows no sign."""
    if isinstance(data_type, Real):
        return _real(data_type, text)
    if isinstance(data_type, Octets):
        return text.removeprefix("0x")
    if not isinstance(data_type, Integer | Boolean):
        return text
    number = found if isinstance(found, int) else _whole(data_type, text)
    if isinstance(data_type, Integer) and data_type.is_signed and text.lower().startswith("0x"):
        number -= (number > data_type.high) << data_type.bits  # two's complement
    return number


def _whole(data_type: DataType, text: str) -> int:
    try:
        return parse_number(text)
    except ValueError as cause:
        raise ValueError(
            f"{text}: a number that {data_type.name} can hold would be right, such as 1 or 0x01"
        ) from cause


def _real(data_type: DataType, text: str) -> float:
    try:
        return float(text)
    except ValueError as cause:
        if text.strip("0xX") == "":
            return 0.0
        raise ValueError(f"{text}: a decimal number would be right for {data_type.name}, such as 0.5") from cause


def _count(source: ODVariable) -> int:
    """Sub-index 0 without a value: the highest sub-index, except where it counts what is there for now."""
    parent: Any = source.parent
    return (
        0
        if source.index == emcy.HISTORY or source.index in MAPPINGS
        else max(sub for sub in parent.subindices if sub < standard.STRUCTURE)
    )


def _tighter(limit: float | None, of_type: float | None) -> float | None:
    """A limit that the type doesn't set anyway."""
    return None if limit == of_type else limit
