"""The rows of python-can's tables of messages, CSV and SQLite: what they have, and what they cannot say.

A row has the seconds of the time of day, the identifier, three flags (extended, remote, error), the length, and the
data.  It does not say which bus a frame is of, nor that it is an FD frame; one with more than 8 bytes can be nothing
else.  An error frame has its class instead of an identifier, as python-can logs it from SocketCAN.
"""

from typing import Final, NamedTuple

from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import EXTENDED_MASK
from fieldrig_bus.can.linux_flags import ERROR
from fieldrig_bus.traces.can_fields import Fields, fields_of, message_of
from fieldrig_bus.traces.error_capture import unknown_error

BUS: Final = "can0"
"""The name of the bus of a table."""


class Row(NamedTuple):
    identifier: int
    is_extended: bool
    is_remote: bool
    is_error: bool
    length: int
    data: bytes


class Columns:
    """Gives the fields of messages that a table can have, and reports what it cannot say."""

    def __init__(self, odd: Oddities) -> None:
        self._odd = odd
        self.bus: str | None = None
        """The first bus; None before the first message."""

    def fields(self, entry: TraceEntry) -> Fields | None:
        """Return the fields of an entry; None for one that has no row."""
        _, bus, family, _, message = entry
        fields = fields_of(message) if family == "can" else None
        if fields is None:
            return None
        if bus != self.bus:
            if self.bus is not None:
                self._odd.report("the format has no buses, so their frames are mixed")
            self.bus = self.bus or bus
        if fields[3]:
            self._report_fd(fields, fields.is_switched)
        return fields

    def _report_fd(self, fields: Fields, is_switched: bool) -> None:
        if fields.length <= 8:
            self._odd.report("the format has no FD frames, so those of at most 8 bytes become classical ones")
        elif is_switched:
            self._odd.report("the format does not say which FD frames switch the bit rate")


def row_of(fields: Fields) -> Row:
    """Return the row of a message."""
    word, data, length, _, _ = fields
    return Row(word & EXTENDED_MASK, bool(word & EXTENDED), bool(word & REMOTE), bool(word & ERROR), length, data)


def message_of_row(row: Row) -> bytes:
    """Return the encoded message of a row.  ValueError for a frame that no bus can carry."""
    identifier, is_extended, is_remote, is_error, length, data = row
    if not 0 <= identifier <= EXTENDED_MASK:
        raise ValueError(f"identifier {identifier}: expected 0 to {EXTENDED_MASK:#x}")
    if is_error:
        return message_of(identifier | ERROR, data) or encode(unknown_error())
    word = identifier | is_extended * EXTENDED | is_remote * REMOTE
    message = message_of(word, b"" if is_remote else data, length, is_fd=len(data) > 8)
    assert message is not None  # only error frames can be nothing
    return message
