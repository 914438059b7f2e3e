"""Notices: messages between a member and its own CAN controller, beside the frames.

A controller's notices go to members whose interest asks for them: "errors" for `CanError`, "state" for `BusState`.
Both are in the trace in any case, with the controller's member as the sender.  SocketCAN has the same as error frames
(linux/can/error.h; see `socketcan_errors`).

Named after FMI-LS-BUS 1.0 (its network abstraction for CAN):

    Transmit                a CanFrame that is sent
    Confirm                 the own frame that comes back to a member that asks for "own"
    Bus Error               CanError; the codes of ErrorKind are those of the standard
    Arbitration Lost        CanError with ARBITRATION_LOST, for a one-shot member; others try again
    Status                  BusState
    Configuration           the settings of the bus (bit rates), BitRate, CanControl (arbitrationLostBehavior: one-shot)
    Wake-up, Format Error   have no counterpart: no controller sleeps, and a frame is valid once it is constructed
"""

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, ClassVar, Final

from fieldrig.faults.note import FaultNote as FaultNote
from fieldrig.link import Link
from fieldrig_bus.can.bits import Place

NOTICE: Final = 0x6000_0000
"""The flags remote and FD together, which no frame has.  With the number of the notice it is the first word."""


class ErrorKind(IntEnum):
    """The kind of an error that a controller has seen; the codes are those of FMI-LS-BUS 1.0."""

    BIT = 1
    STUFF = 2
    FORM = 3
    CRC = 4
    ACK = 5
    ARBITRATION_LOST = 16


class CanState(IntEnum):
    """State of a controller by its error counters (ISO 11898-1:2015, 12.1.4).  Interface chips have added WARNING."""

    ACTIVE = 1
    WARNING = 2
    PASSIVE = 3
    BUS_OFF = 4


@dataclass(frozen=True, slots=True)
class CanError:
    """A controller has seen an error, or has lost arbitration as a one-shot transmitter.

    `identifier` is that of the frame on the wire, with the flags of `acceptance`; `bit` counts from 0, the start of
    frame; the counters are those after the error.  `is_given_up`: the transmitter will not try this frame again.
    """

    WIRE: ClassVar = struct.Struct("<BBHIBHB")
    kind: ErrorKind
    place: Place
    bit: int
    identifier: int
    is_transmitter: bool
    is_given_up: bool
    tec: int
    rec: int


@dataclass(frozen=True, slots=True)
class BusState:
    """A controller is now in this state."""

    WIRE: ClassVar = struct.Struct("<BHB")
    state: CanState
    tec: int
    rec: int


@dataclass(frozen=True, slots=True)
class CanControl:
    """A member changes the setup of its controller.  None leaves a setting as it is; `recover` ends bus-off."""

    is_one_shot: bool | None = None
    is_listen_only: bool | None = None
    recover: bool = False


@dataclass(frozen=True, slots=True)
class BitRate:
    """A member sets the bit rate of its controller.  Until then a member has the bit rate of the bus.

    On a model bus, a member with a different bit rate receives nothing, and its frames cause errors.  On a direct bus
    the bit rate of the medium applies regardless.
    """

    WIRE: ClassVar = struct.Struct("<I")
    bit_per_s: int


SLOWEST, FASTEST = 1_000, 10_000_000
"""Lowest and highest bit rate, in bit/s."""


def use_bit_rate(can: Link[Any], bit_per_s: int) -> None:
    """Set the bit rate of the controller at this link."""
    can.send(BitRate(bit_per_s))


Notice = CanError | BusState | FaultNote | CanControl | BitRate

_WORD: Final = struct.Struct("<I")
_THREE: Final = (None, False, True)


def encode(notice: Notice) -> bytes:
    match notice:
        case CanError(kind, place, bit, identifier, is_transmitter, is_given_up, tec, rec):
            flags = is_transmitter | is_given_up << 1
            return _word(1) + CanError.WIRE.pack(kind, place, bit, identifier, flags, tec, rec)
        case BusState(state, tec, rec):
            return _word(2) + BusState.WIRE.pack(state, tec, rec)
        case FaultNote(fault, what):
            return _word(3) + FaultNote.WIRE.pack(fault) + what.encode()
        case CanControl(is_one_shot, is_listen_only, recover):
            choices = (_THREE.index(is_one_shot), _THREE.index(is_listen_only), int(recover))
            return _word(4) + bytes(choices)
        case BitRate(bit_per_s):
            return _word(5) + BitRate.WIRE.pack(bit_per_s)


def check_sent(notice: Any) -> None:
    """Raise TypeError or ValueError for a notice that a member cannot send to its controller."""
    match notice:
        case CanControl():
            for name in ("is_one_shot", "is_listen_only", "recover"):
                value = getattr(notice, name)
                if value is None and name != "recover":
                    continue
                if type(value) is not bool:
                    raise TypeError(f"{name}: expected bool, found {type(value).__name__}")
        case BitRate(bit_per_s):
            if type(bit_per_s) is not int:
                raise TypeError(f"bit_per_s: expected int, found {type(bit_per_s).__name__}")
            if not SLOWEST <= bit_per_s <= FASTEST:
                raise ValueError(f"{bit_per_s} bit/s: expected {SLOWEST} to {FASTEST}")
        case _:
            raise TypeError(f"expected a CanFrame, CanControl or BitRate, found {type(notice).__name__}")


def decode(data: bytes) -> Notice:
    """The inverse of `encode`.  ValueError for anything else."""
    try:
        return _decode(_WORD.unpack_from(data)[0] & ~NOTICE, data[_WORD.size :])
    except (struct.error, IndexError, KeyError) as cause:
        raise ValueError(f"not a CAN notice: {data.hex(' ')}") from cause


def _decode(number: int, body: bytes) -> Notice:
    match number:
        case 1:
            kind, place, bit, identifier, flags, tec, rec = CanError.WIRE.unpack(body)
            if flags > 3:
                raise ValueError(f"flags of a CAN error {flags:#x}: expected 0 to 3")
            return CanError(ErrorKind(kind), Place(place), bit, identifier, bool(flags & 1), bool(flags & 2), tec, rec)
        case 2:
            state, tec, rec = BusState.WIRE.unpack(body)
            return BusState(CanState(state), tec, rec)
        case 3:
            size = FaultNote.WIRE.size
            return FaultNote(FaultNote.WIRE.unpack(body[:size])[0], body[size:].decode())
        case 4 if len(body) == 3:
            return CanControl(_THREE[body[0]], _THREE[body[1]], {0: False, 1: True}[body[2]])
        case 5:
            (bit_per_s,) = BitRate.WIRE.unpack(body)
            if SLOWEST <= bit_per_s <= FASTEST:
                return BitRate(bit_per_s)
    raise ValueError(f"there is no CAN notice {number} of {len(body)} bytes")


def show(notice: Notice) -> str:
    match notice:
        case CanError(kind, place, bit, _, is_transmitter, is_given_up, tec, rec):
            way = "sending" if is_transmitter else "receiving"
            where = f"in {_words(place)}, bit {bit}"
            end = ", given up" if is_given_up else ""
            return f"{_words(kind)} error {where}, {way}; TEC {tec} REC {rec}{end}"
        case BusState(state, tec, rec):
            return f"now {_words(state)}; TEC {tec} REC {rec}"
        case FaultNote(fault, what):
            return f"fault {fault}: {what}"
        case CanControl():
            return f"control: {notice.is_one_shot=}, {notice.is_listen_only=}, {notice.recover=}".replace("notice.", "")
        case BitRate(bit_per_s):
            return f"bit rate {bit_per_s} bit/s"


def _word(number: int) -> bytes:
    return _WORD.pack(NOTICE | number)


def _words(name: IntEnum) -> str:
    return name.name.lower().replace("_", " ")
