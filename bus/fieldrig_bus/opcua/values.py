"""Parts, time stamps and checks of values that a client reads or subscribes to.

Source: OPC 10000-4, 5.11.2 (Read), 5.11.4 (Write), 7.27 (NumericRange), 7.29 (ReadValueId), 7.40 (TimestampsToReturn).
"""

import re
from collections import OrderedDict
from dataclasses import replace
from datetime import datetime
from typing import Any, Final

from asyncua import ua

GOOD: Final[int] = ua.StatusCodes.Good
_RANGE: Final = re.compile(r"(\d{1,10})(?::(\d{1,10}))?", re.ASCII)


def wrong_read(read: ua.ReadValueId) -> int:
    """Return Good, or the status code of a ReadValueId that says something impossible."""
    if read.IndexRange:
        if read.AttributeId != ua.AttributeIds.Value:
            return int(ua.StatusCodes.BadIndexRangeNoData)
        dimensions = [bounds(part) for part in read.IndexRange.split(",")]
        if None in dimensions:
            return int(ua.StatusCodes.BadIndexRangeInvalid)
    if read.DataEncoding.Name:  # only structures have encodings, and no variable is one
        return int(ua.StatusCodes.BadDataEncodingInvalid)
    return GOOD


def bounds(text: str) -> tuple[int, int] | None:
    """Return the first and the last index of a dimension of a NumericRange, or None if it is none."""
    match = _RANGE.fullmatch(text)
    if match is None:
        return None
    first, last = int(match[1]), int(match[2] or match[1])
    return (first, last) if first < last or match[2] is None else None


def part_of(read: ua.ReadValueId, value: ua.DataValue) -> ua.DataValue:
    """Return the elements that the index range names; the range is one that `wrong_read` lets pass."""
    if not read.IndexRange or value.Value is None or value.Value.Value is None or not value.StatusCode.is_good():
        return value
    whole = value.Value.Value
    dimensions = [bounds(part) for part in read.IndexRange.split(",")]
    if len(dimensions) != 1 or dimensions[0] is None or not isinstance(whole, list | str | bytes):
        return _without_data(value)
    first, last = dimensions[0]
    piece = whole[first : last + 1]
    return replace(value, Value=_like(value.Value, piece)) if piece else _without_data(value)


def _like(variant: ua.Variant, value: Any) -> ua.Variant:
    return ua.Variant(value, variant.VariantType, is_array=isinstance(value, list))


def _without_data(value: ua.DataValue) -> ua.DataValue:
    return replace(value, Value=ua.Variant(None), StatusCode=ua.StatusCode(ua.StatusCodes.BadIndexRangeNoData))


def stamped(value: ua.DataValue, timestamps: ua.TimestampsToReturn) -> ua.DataValue:
    """Return the value with the time stamps that the client wants."""
    wants = ua.TimestampsToReturn
    if timestamps not in (wants.Source, wants.Both):
        value = replace(value, SourceTimestamp=None, SourcePicoseconds=None)
    if timestamps not in (wants.Server, wants.Both):
        value = replace(value, ServerTimestamp=None, ServerPicoseconds=None)
    return value


MOST_SOURCE_TIMES: Final = 10_000
"""Variables whose written source time is remembered."""


class SourceTimes:
    """Source times that clients have written with a value; each is that of the variable as long as it has the value.

    Many clients write one with every value, such as asyncua, so refusing them would refuse these clients.
    """

    def __init__(self) -> None:
        self._written: OrderedDict[ua.NodeId, tuple[ua.Variant, datetime, int | None]] = OrderedDict()

    def note(self, node_id: ua.NodeId, written: ua.DataValue) -> None:
        self._written.pop(node_id, None)
        if written.SourceTimestamp is not None:
            self._written[node_id] = written.Value, written.SourceTimestamp, written.SourcePicoseconds
            if len(self._written) > MOST_SOURCE_TIMES:
                self._written.popitem(last=False)

    def applied(self, node_id: ua.NodeId, value: ua.DataValue) -> ua.DataValue:
        """Return the value with the source time that belongs to it."""
        written = self._written.get(node_id)
        if written is None:
            return value
        if value.Value is None or value.Value.Value != written[0].Value:
            del self._written[node_id]  # the device has another value, which is of its own time
            return value
        return replace(value, SourceTimestamp=written[1], SourcePicoseconds=written[2])
