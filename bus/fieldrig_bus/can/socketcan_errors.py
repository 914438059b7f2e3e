"""Notices of a controller as error frames of SocketCAN, and back.

Source: Linux, include/uapi/linux/can/error.h.  An error frame has a class instead of the identifier, and eight bytes of
data; the last two are the error counters (CAN_ERR_CNT).
Left out: the bits that correspond to no notice here (time-outs, transceiver status).
"""

from enum import IntFlag
from typing import Final

from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.notices import BusState, CanError, CanState, ErrorKind

LENGTH: Final = 8  # CAN_ERR_DLC


class Class(IntFlag):
    """The class of an error frame, CAN_ERR_*."""

    LOST_ARBITRATION = 0x002
    CONTROLLER = 0x004
    PROTOCOL = 0x008
    ACK = 0x020
    BUS_OFF = 0x040
    BUS_ERROR = 0x080
    RESTARTED = 0x100
    COUNTERS = 0x200


ERRORS: Final = Class.LOST_ARBITRATION | Class.PROTOCOL | Class.ACK | Class.BUS_ERROR
STATES: Final = Class.CONTROLLER | Class.BUS_OFF | Class.RESTARTED

SENDING: Final = 0x80  # CAN_ERR_PROT_TX
PROTOCOL: Final = {ErrorKind.BIT: 0x01, ErrorKind.FORM: 0x02, ErrorKind.STUFF: 0x04}
"""CAN_ERR_PROT_* in byte 2.  A CRC error is identified by its place in byte 3."""
# CAN_ERR_CRTL_*, in byte 1: by state for the receive and for the transmit counter
CONTROLLER: Final = {CanState.WARNING: (0x04, 0x08), CanState.PASSIVE: (0x10, 0x20)}
ACTIVE: Final = 0x40


def error_frame(notice: CanError | BusState) -> tuple[int, bytes]:
    """The class (without CAN_ERR_FLAG) and the data of the error frame for a notice."""
    error_class, head = _error(notice) if isinstance(notice, CanError) else _state(notice)
    return error_class | Class.COUNTERS, head.ljust(6, b"\0") + bytes([min(notice.tec, 255), min(notice.rec, 255)])


def _error(error: CanError) -> tuple[Class, bytes]:
    if error.kind is ErrorKind.ARBITRATION_LOST:
        return Class.LOST_ARBITRATION, bytes([min(error.bit, 255)])
    way = SENDING if error.is_transmitter else 0
    if error.kind is ErrorKind.ACK:
        return Class.ACK | Class.BUS_ERROR, bytes([0, 0, way, error.place])
    return Class.PROTOCOL | Class.BUS_ERROR, bytes([0, 0, way | PROTOCOL.get(error.kind, 0), error.place])


def _state(notice: BusState) -> tuple[Class, bytes]:
    if notice.state is CanState.BUS_OFF:
        return Class.BUS_OFF, b""
    if notice.state is CanState.ACTIVE:
        return Class.CONTROLLER, bytes([0, ACTIVE])
    receiving, sending = CONTROLLER[notice.state]
    return Class.CONTROLLER, bytes([0, receiving if notice.rec > notice.tec else sending])


def notice_of(word: int, data: bytes) -> CanError | BusState | None:
    """The notice for an error frame; None if there is none.  Data may have any length; missing bytes are 0."""
    data = data.ljust(LENGTH, b"\0")
    tec, rec = (data[6], data[7]) if word & Class.COUNTERS else (0, 0)
    if word & Class.BUS_OFF:
        return BusState(CanState.BUS_OFF, 256, rec)
    if word & Class.RESTARTED:
        return BusState(CanState.ACTIVE, tec, rec)
    if word & Class.CONTROLLER and (state := _state_of(data[1])) is not None:
        return BusState(state, tec, rec)
    if word & Class.LOST_ARBITRATION:
        return CanError(ErrorKind.ARBITRATION_LOST, Place.UNSPECIFIED, data[0], 0, True, False, tec, rec)
    if word & (Class.ACK | Class.PROTOCOL):
        way, place = bool(data[2] & SENDING), place_of(data[3])
        return CanError(_kind_of(word, data[2], place), place, 0, 0, way, False, tec, rec)
    return None


def _state_of(controller: int) -> CanState | None:
    for state in (CanState.PASSIVE, CanState.WARNING):
        if any(controller & bit for bit in CONTROLLER[state]):
            return state
    return CanState.ACTIVE if controller & ACTIVE else None


def _kind_of(word: int, protocol: int, place: Place) -> ErrorKind:
    if word & Class.ACK:
        return ErrorKind.ACK
    kind_of_error = next((kind for kind, bit in PROTOCOL.items() if protocol & bit), None)
    if kind_of_error is not None:
        return kind_of_error
    return ErrorKind.CRC if place in (Place.CRC, Place.CRC_DELIMITER, Place.ACK_DELIMITER) else ErrorKind.BIT


def place_of(location: int) -> Place:
    """Return the place of a code; one that no place has is unspecified."""
    try:
        return Place(location)
    except ValueError:
        return Place.UNSPECIFIED
