"""Nodes, types, units and values of devices in the terms of OPC UA.

Types follow the PLCopen information model for IEC 61131-3 (OPC 30000): a WORD is a UInt16, a TIME is a Duration in
milliseconds, dates are DateTimes, and an enumeration is an Int32 with EnumValues.  Units are codes of UNECE
recommendation 20 (OPC 10000-8); a unit without such a code has its text only.
"""

from datetime import UTC, datetime, timedelta
from math import isfinite
from typing import Final, NamedTuple

from asyncua import ua

from fieldrig.device import Value
from fieldrig_bus.opcua.message import MOST_ELEMENTS, NODE, VALUE, AnyValue, Argument, Node, Status

_T: Final = ua.VariantType
EPOCH: Final = datetime(1970, 1, 1, tzinfo=UTC)
_UNECE: Final = "http://www.opcfoundation.org/UA/units/un/cefact"


class Mapped(NamedTuple):
    """A type of IEC 61131-3 in OPC UA: how values are transferred, the DataType of the node, and the range."""

    variant: ua.VariantType
    data_type: int
    low: int | None = None
    high: int | None = None


def _integer(variant: ua.VariantType, bits: int, is_signed: bool) -> Mapped:
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if is_signed else (0, (1 << bits) - 1)
    return Mapped(variant, getattr(ua.ObjectIds, variant.name), low, high)


TYPES: Final = {
    "BOOL": Mapped(_T.Boolean, ua.ObjectIds.Boolean),
    "BYTE": _integer(_T.Byte, 8, False),
    "WORD": _integer(_T.UInt16, 16, False),
    "DWORD": _integer(_T.UInt32, 32, False),
    "LWORD": _integer(_T.UInt64, 64, False),
    "SINT": _integer(_T.SByte, 8, True),
    "INT": _integer(_T.Int16, 16, True),
    "DINT": _integer(_T.Int32, 32, True),
    "LINT": _integer(_T.Int64, 64, True),
    "USINT": _integer(_T.Byte, 8, False),
    "UINT": _integer(_T.UInt16, 16, False),
    "UDINT": _integer(_T.UInt32, 32, False),
    "ULINT": _integer(_T.UInt64, 64, False),
    "REAL": Mapped(_T.Float, ua.ObjectIds.Float),
    "LREAL": Mapped(_T.Double, ua.ObjectIds.Double),
    "STRING": Mapped(_T.String, ua.ObjectIds.String),
    "WSTRING": Mapped(_T.String, ua.ObjectIds.String),
    "TIME": Mapped(_T.Double, ua.ObjectIds.Duration, 0, 2**32 - 1),
    "SIGNED_TIME": Mapped(_T.Double, ua.ObjectIds.Duration, -(2**31), 2**31 - 1),
    "DATE": Mapped(_T.DateTime, ua.ObjectIds.DateTime, 0, 2**32 - 1),
    "DT": Mapped(_T.DateTime, ua.ObjectIds.DateTime, 0, 2**32 - 1),
    "TOD": Mapped(_T.DateTime, ua.ObjectIds.DateTime, 0, 86_399_999),
    "LTIME": _integer(_T.Int64, 64, True),
    "LDATE": _integer(_T.Int64, 64, True),
    "LTOD": Mapped(_T.Int64, ua.ObjectIds.Int64, 0, 86_400_000_000_000 - 1),
    "LDT": _integer(_T.Int64, 64, True),
    "CHAR": _integer(_T.Byte, 8, False),
    "WCHAR": _integer(_T.UInt16, 16, False),
    "ENUM": Mapped(_T.Int32, ua.ObjectIds.Int32, -(2**15), 2**15 - 1),
}
"""The mapping of each IEC type; an unknown one is shown as a string."""

UNIT_CODES: Final = {
    "%": "P1", "s": "SEC", "ms": "C26", "us": "B98", "ns": "C47", "min": "MIN", "h": "HUR", "d": "DAY",
    "V": "VLT", "mV": "2Z", "A": "AMP", "mA": "4K", "W": "WTT", "kW": "KWT", "Hz": "HTZ", "kHz": "KHZ", "Ohm": "OHM",
    "m": "MTR", "mm": "MMT", "um": "4H", "m/s": "MTS", "mm/s": "C16", "m/s2": "MSK", "N": "NEW", "Nm": "NU",
    "°C": "CEL", "degC": "CEL", "K": "KEL", "bar": "BAR", "Pa": "PAL", "kg": "KGM", "g": "GRM", "l": "LTR",
    "deg": "DD", "rad": "C81", "rpm": "RPM", "1/min": "RPM", "rad/s": "2A", "B": "AD", "kB": "2P", "bit/s": "B10",
}  # fmt: skip
"""UNECE codes by the text of the unit."""

STATUS_CODES: Final[dict[Status, int]] = {
    Status.GOOD: ua.StatusCodes.Good,
    Status.UNKNOWN: ua.StatusCodes.BadNodeIdUnknown,
    Status.NOT_WRITABLE: ua.StatusCodes.BadNotWritable,
    Status.TYPE_MISMATCH: ua.StatusCodes.BadTypeMismatch,
    Status.OUT_OF_RANGE: ua.StatusCodes.BadOutOfRange,
    Status.REFUSED: ua.StatusCodes.BadInvalidState,
    Status.NOT_SUPPORTED: ua.StatusCodes.BadNotSupported,
    Status.WRONG_ARGUMENTS: ua.StatusCodes.BadInvalidArgument,
    Status.TOO_LARGE: ua.StatusCodes.BadEncodingLimitsExceeded,
    Status.BAD: ua.StatusCodes.Bad,
    Status.SENSOR_FAILURE: ua.StatusCodes.BadSensorFailure,
    Status.DEVICE_FAILURE: ua.StatusCodes.BadDeviceFailure,
    Status.NO_ANSWER: ua.StatusCodes.BadNoCommunication,
}


class WrongValueError(Exception):
    """A value that a node cannot have; `status` says why."""

    def __init__(self, status: Status) -> None:
        super().__init__(status.value)
        self.status = status


def mapped(node: Node) -> Mapped:
    return TYPES["ENUM"] if node.choices else TYPES.get(node.type, TYPES["STRING"])


def described(argument: Argument) -> ua.Argument:
    """Return an argument as the properties InputArguments and OutputArguments have it."""
    data_types = {NODE: ua.ObjectIds.NodeId, VALUE: ua.ObjectIds.BaseDataType}
    return ua.Argument(
        Name=argument.name,
        DataType=ua.NodeId(data_types.get(argument.type) or TYPES[argument.type].data_type),
        ValueRank=1 if argument.is_array else -2 if argument.type == VALUE else -1,  # 1 array, -2 any, -1 scalar
        ArrayDimensions=[0] if argument.is_array else [],
        Description=ua.LocalizedText(argument.about),
    )


def engineering_units(unit: str) -> ua.EUInformation:
    """Return the unit of a node; the number of a UNECE code consists of its letters as octets."""
    code = UNIT_CODES.get(unit)
    number = -1 if code is None else int.from_bytes(code.encode(), "big")
    text = ua.LocalizedText(unit)
    return ua.EUInformation(NamespaceUri=_UNECE, UnitId=number, DisplayName=text, Description=text)


def value_range(node: Node) -> ua.Range | None:
    """Return the InstrumentRange of a node whose values are limited beyond its type."""
    return None if node.low is None or node.high is None else ua.Range(Low=node.low, High=node.high)


def to_variant(node: Node, value: AnyValue) -> ua.Variant:
    """Return a value of the device for a client."""
    ua_type = mapped(node)
    if isinstance(value, list):
        return ua.Variant([_to_client(node, ua_type, element) for element in value], ua_type.variant, is_array=True)
    return ua.Variant(_to_client(node, ua_type, value), ua_type.variant)


def from_variant(node: Node, variant: ua.Variant) -> AnyValue:
    """Return a client's value for the device.  WrongValueError for another type, or one that is out of range."""
    ua_type, value = mapped(node), variant.Value
    if variant.VariantType != ua_type.variant or isinstance(value, list) != (node.length is not None):
        raise WrongValueError(Status.TYPE_MISMATCH)
    if isinstance(value, list):
        if len(value) != node.length or len(value) > MOST_ELEMENTS:
            raise WrongValueError(Status.OUT_OF_RANGE)
        return [_from_client(node, ua_type, element) for element in value]
    return _from_client(node, ua_type, value)


def _to_client(node: Node, ua_type: Mapped, value: Value) -> object:
    if ua_type.variant is _T.DateTime:
        return EPOCH + (timedelta(milliseconds=int(value)) if node.type == "TOD" else timedelta(seconds=int(value)))
    if ua_type.variant is _T.String:
        return str(value)
    if ua_type.variant is _T.Boolean:
        return bool(value)
    if ua_type.variant in (_T.Float, _T.Double):
        return float(value)
    return int(value)


def _from_client(node: Node, ua_type: Mapped, value: object) -> Value:
    converted: Value
    if isinstance(value, datetime):
        since = (value if value.tzinfo is not None else value.replace(tzinfo=UTC)) - EPOCH
        converted = since // (timedelta(milliseconds=1) if node.type == "TOD" else timedelta(seconds=1))
    elif ua_type.data_type == ua.ObjectIds.Duration and isinstance(value, float):
        if not isfinite(value):
            raise WrongValueError(Status.OUT_OF_RANGE)
        converted = round(value)
    elif isinstance(value, bool | int | float | str):
        converted = value
    elif value is None and ua_type.variant is _T.String:
        converted = ""
    else:
        raise WrongValueError(Status.TYPE_MISMATCH)
    _check_range(node, ua_type, converted)
    return converted


def _check_range(node: Node, ua_type: Mapped, value: Value) -> None:
    if isinstance(value, str):
        return
    low = ua_type.low if node.low is None else node.low
    high = ua_type.high if node.high is None else node.high
    is_outside = (low is not None and not value >= low) or (high is not None and not value <= high)
    if is_outside or (node.choices and value not in {number for _, number in node.choices}):
        raise WrongValueError(Status.OUT_OF_RANGE)
