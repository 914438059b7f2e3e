"""The contents of frames on a PAM's ring, as bytes.

The manual gives no layout, so this one is ours (docs/devices/pam/pam-ring.md), and this module is the place for the
real one: nothing else knows a byte of it.  A frame begins with the number of its kind; its fields follow in the order
of `frames`, little endian.  What a node reports in one cycle is a row of reports, each after its length.
"""

import struct
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields
from enum import IntEnum
from operator import attrgetter
from typing import Any, Final, NamedTuple, cast

from fieldrig_devices.pamring import frames
from fieldrig_devices.pamring.messages import LARGEST_NUMBER

_VALUE: Final = struct.Struct("<q")


class Row(NamedTuple):
    """One kind of frame with fields of fixed length; `enums` names those whose values are a type of their own."""

    kind: int
    form: type[Any]
    layout: str
    """A letter of `struct` for each field."""
    enums: Mapping[str, type[IntEnum]] = {}


ORDERS: Final = (
    Row(0x01, frames.Identify, ""),
    Row(0x02, frames.Run, ""),
    Row(0x03, frames.Group, "B"),
    Row(0x04, frames.SetOutput, "HqI"),
    Row(0x05, frames.Blink, "H?"),
    Row(0x06, frames.Display, "HI"),
    Row(0x08, frames.AxisOrder, "IBqqqq", {"move": frames.Move}),
    Row(0x0A, frames.EndOfPipe, "B", {"mode": frames.SetPointMode}),
    Row(0x0B, frames.Read, "IH"),
    Row(0x10, frames.InputItem, "HHB?II"),
    Row(0x11, frames.CounterItem, "HH?II"),
    Row(0x12, frames.KeyItem, "HH?BIII?I", {"mode": frames.KeyMode}),
    Row(0x13, frames.OutputItem, "HHB?"),
    Row(0x14, frames.AnalogItem, "HH"),
    Row(0x15, frames.LedItem, "HH"),
    Row(0x16, frames.SevenSegmentItem, "HHB"),
    Row(0x17, frames.MotorItem, "HHHHHII"),
    Row(0x18, frames.AxisItem, "Hqq"),
)
MOTOR_ORDER: Final = 0x07
"""The kind of a `MotorOrder`: item, order, number, and any number of values of 64 bits."""
SET_POINT: Final = 0x09
"""The kind of a `SetPoint`: mode, value."""

REPORTS: Final = (
    Row(0x81, frames.Identity, "BH", {"node_type": frames.NodeType}),
    Row(0x82, frames.Accepted, "H"),
    Row(0x83, frames.Refused, "H"),
    Row(0x84, frames.Running, ""),
    Row(0x85, frames.InputChanged, "HqII"),
    Row(0x87, frames.AxisReport, "IIIq"),
    Row(0x88, frames.MotorReport, "H?II"),
)
ANSWER: Final = 0x86
"""The kind of an `Answer`: request, whether there is a value, value."""
TROUBLE: Final = 0x89
"""The kind of a `Trouble`: severity, code, D2, D3, error word."""

_MOTOR_ORDER: Final = struct.Struct("<BHBI")
_ANSWER: Final = struct.Struct("<BI?q")
_TROUBLE: Final = struct.Struct("<BBHIII")
_SET_POINT: Final = struct.Struct("<BBq")
_NO_FRAME: Final = (IndexError, KeyError, struct.error)
_MODES: Final = {int(mode): mode for mode in frames.SetPointMode}

# ---- the common way, by the tables


def _encoder(row: Row) -> Callable[[Any], bytes]:
    names = [each.name for each in fields(row.form)]
    pack, kind = struct.Struct("<B" + row.layout).pack, row.kind
    if not names:
        return lambda _frame: pack(kind)
    if len(names) == 1:
        of_one = attrgetter(names[0])
        return lambda frame: pack(kind, of_one(frame))
    of_all = attrgetter(*names)
    return lambda frame: pack(kind, *of_all(frame))


def _decoder(row: Row) -> Callable[[bytes], Any]:
    unpack, form = struct.Struct("<x" + row.layout).unpack, row.form
    if not row.enums:
        return lambda data: form(*unpack(data))
    makes = [row.enums.get(each.name) for each in fields(form)]

    def decode(data: bytes) -> Any:
        return form(*[value if make is None else make(value) for make, value in zip(makes, unpack(data), strict=True)])

    return decode


# ---- frames that have a way of their own


def _encode_motor_order(order: frames.MotorOrder) -> bytes:
    head = _MOTOR_ORDER.pack(MOTOR_ORDER, order.item, order.order, order.number)
    return head + b"".join(map(_VALUE.pack, order.values))


def _decode_motor_order(data: bytes) -> frames.MotorOrder:
    _, item, order, number = _MOTOR_ORDER.unpack_from(data)
    values = tuple(value for (value,) in _VALUE.iter_unpack(data[_MOTOR_ORDER.size :]))
    return frames.MotorOrder(item, frames.Motor(order), values, number)


def _encode_set_point(order: frames.SetPoint) -> bytes:
    return _SET_POINT.pack(SET_POINT, order.mode, order.value)


def _decode_set_point(data: bytes) -> frames.SetPoint:
    """Every axis takes one in every cycle, so this way is short."""
    _, mode, value = _SET_POINT.unpack(data)
    return frames.SetPoint(_MODES[mode], value)


def _encode_answer(answer: frames.Answer) -> bytes:
    return _ANSWER.pack(ANSWER, answer.request, answer.value is not None, answer.value or 0)


def _decode_answer(data: bytes) -> frames.Answer:
    _, request, is_there, value = _ANSWER.unpack(data)
    return frames.Answer(request, value if is_there else None)


def _encode_trouble(trouble: frames.Trouble) -> bytes:
    code = trouble.code & LARGEST_NUMBER  # a device of a user may have any number
    return _TROUBLE.pack(TROUBLE, trouble.severity, code, *trouble.details, trouble.word)


def _decode_trouble(data: bytes) -> frames.Trouble:
    _, severity, code, second, third, word = _TROUBLE.unpack(data)
    return frames.Trouble(frames.Severity(severity), code, (second, third), word)


ENCODERS: Final[Mapping[type[Any], Callable[[Any], bytes]]] = {
    **{row.form: _encoder(row) for row in (*ORDERS, *REPORTS)},
    frames.MotorOrder: _encode_motor_order,
    frames.SetPoint: _encode_set_point,
    frames.Answer: _encode_answer,
    frames.Trouble: _encode_trouble,
}
"""How frames become bytes, by their class."""
_ORDER_DECODERS: Final[dict[int, Callable[[bytes], Any]]] = {
    **{row.kind: _decoder(row) for row in ORDERS},
    MOTOR_ORDER: _decode_motor_order,
    SET_POINT: _decode_set_point,
}
_REPORT_DECODERS: Final[dict[int, Callable[[bytes], Any]]] = {
    **{row.kind: _decoder(row) for row in REPORTS},
    ANSWER: _decode_answer,
    TROUBLE: _decode_trouble,
}


def encode(frame: frames.Order | frames.Report) -> bytes:
    """The contents of a frame.  struct.error for a value that no frame can carry."""
    return ENCODERS[frame.__class__](frame)


def decode_order(data: bytes) -> frames.Order:
    """Return what the PAM sent.  ValueError for bytes that are no order."""
    try:
        return cast(frames.Order, _ORDER_DECODERS[data[0]](data))
    except _NO_FRAME as cause:
        raise ValueError(f"not an order: {data.hex(' ')}") from cause


def decode_report(data: bytes) -> frames.Report:
    """Return what a node reports.  ValueError for bytes that are no report."""
    try:
        return cast(frames.Report, _REPORT_DECODERS[data[0]](data))
    except _NO_FRAME as cause:
        raise ValueError(f"not a report: {data.hex(' ')}") from cause


# ---- the reports of one cycle


def join(reports: Iterable[bytes]) -> bytes:
    """Reports of one node, as they are in the buffer of its chip."""
    return b"".join([bytes((len(report),)) + report for report in reports])


def split(buffer: bytes) -> list[bytes]:
    """The inverse of `join`.  ValueError for anything else."""
    reports, start, end = [], 0, len(buffer)
    while start < end:
        following = start + 1 + buffer[start]
        reports.append(buffer[start + 1 : following])
        start = following
    if start > end:
        raise ValueError(f"a report is cut short: {buffer.hex(' ')}")
    return reports
