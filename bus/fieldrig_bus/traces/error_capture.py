"""An error as the error code capture register of a CAN controller has it, which logs of Vector's tools contain.

Source: Philips SJA1000 data sheet, 6.4.9: bits 7 and 6 the type, bit 5 the direction (1: receiving), bits 4 to 0 the
segment of the frame.  `Place` has the codes of the segments.
"""

from typing import Final

from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.notices import CanError, ErrorKind
from fieldrig_bus.can.socketcan_errors import place_of

TYPES: Final = (ErrorKind.BIT, ErrorKind.FORM, ErrorKind.STUFF)
OTHER: Final = 3
RECEIVING: Final = 0x20
SEGMENT: Final = 0x1F


def error_of(code: int) -> CanError:
    """Return the error of a register; a type other than bit, form and stuff follows from the segment."""
    kind, place = code >> 6 & 3, place_of(code & SEGMENT)
    error = TYPES[kind] if kind < OTHER else ErrorKind.ACK if place is Place.ACK else ErrorKind.CRC
    return CanError(error, place, 0, 0, not code & RECEIVING, False, 0, 0)


def code_of(error: CanError) -> int:
    """Return the register for an error; one that has no type of its own is of another type."""
    kind = TYPES.index(error.kind) if error.kind in TYPES else OTHER
    return kind << 6 | (0 if error.is_transmitter else RECEIVING) | error.place


def unknown_error() -> CanError:
    """Return the error of a log that does not say which it was."""
    return CanError(ErrorKind.BIT, Place.UNSPECIFIED, 0, 0, False, False, 0, 0)
