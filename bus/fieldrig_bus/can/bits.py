"""A CAN frame bit by bit as it is on the wire, for error handling, where the bits themselves matter.

Source: ISO 11898-1:2015 (frame formats, CRC, bit stuffing).  `length` computes the number of bits without producing
them, which is much faster.  Both agree, except for the three bits of intermission, which are not part of the frame
here.  Places are named as in SocketCAN (linux/can/error.h, CAN_ERR_PROT_LOC_*).
"""

from enum import IntEnum
from functools import lru_cache
from typing import Final, NamedTuple

from fieldrig_bus.can.frame import FD_LENGTHS, CanFrame

DOMINANT: Final = 0
RECESSIVE: Final = 1


class Place(IntEnum):
    """A place in a frame.  The values are CAN_ERR_PROT_LOC_*."""

    UNSPECIFIED = 0x00
    ID_28_21 = 0x02
    START = 0x03
    SUBSTITUTE_RTR = 0x04
    IDE = 0x05
    ID_20_18 = 0x06
    ID_17_13 = 0x07
    CRC = 0x08
    RESERVED_0 = 0x09
    DATA = 0x0A
    DLC = 0x0B
    RTR = 0x0C
    RESERVED_1 = 0x0D
    ID_4_0 = 0x0E
    ID_12_5 = 0x0F
    INTERMISSION = 0x12
    CRC_DELIMITER = 0x18
    ACK = 0x19
    END_OF_FRAME = 0x1A
    ACK_DELIMITER = 0x1B


class Stream(NamedTuple):
    """One frame from the start of frame to the end of frame, stuff bits included."""

    bits: bytes
    """Bits, each 0 (dominant) or 1 (recessive)."""
    places: bytes
    """The place of each bit; a stuff bit has that of the bit before it."""
    arbitration: int
    """The first bit after the arbitration field."""
    stuffed: int
    """The first bit after dynamic stuffing has ended."""
    fixed: frozenset[int]
    """The fixed stuff bits of an FD frame."""
    delimiter: int
    """The CRC delimiter; the ACK slot, its delimiter and the 7 bits of the end of frame follow."""
    fd_format: int
    """The FDF bit of an FD frame; -1 in a classical frame."""
    switched: range
    """The bits that are sent at the data bit rate."""

    @property
    def acknowledge(self) -> int:
        """The ACK slot."""
        return self.delimiter + 1

    def ticks(self, count: int, nominal: int, switched: int) -> int:
        """Duration of the first `count` bits, with bit times of `nominal` and `switched`."""
        fast = min(max(count - self.switched.start, 0), len(self.switched))
        return (count - fast) * nominal + fast * switched


Field = tuple[int, int, Place]
"""The bits as a number, their count, and their place."""

_TAIL: Final[tuple[Field, ...]] = (
    (1, 1, Place.CRC_DELIMITER),
    (1, 1, Place.ACK),
    (1, 1, Place.ACK_DELIMITER),
    (0x7F, 7, Place.END_OF_FRAME),
)
# Stuff bits modulo 8 in Gray code, and even parity over it (ISO 11898-1:2015, 10.4.2.6).
_GRAY: Final = (0b000, 0b001, 0b011, 0b010, 0b110, 0b111, 0b101, 0b100)


class _Wire:
    """Collects the bits of a frame, with dynamic stuffing."""

    def __init__(self) -> None:
        self.raw: list[int] = []  # without stuff bits
        self.bits: list[int] = []
        self.places: list[int] = []
        self.count = 0  # of stuff bits
        self._row = 0

    def put(self, fields: tuple[Field, ...], *, is_stuffed: bool = True) -> None:
        """Append fields, highest bit first."""
        for value, width, place in fields:
            for position in range(width - 1, -1, -1):
                bit = value >> position & 1
                if is_stuffed:
                    self._stuff()
                self.raw.append(bit)
                self._append(bit, place)

    def end_stuffing(self) -> None:
        """End dynamic stuffing, with a last stuff bit if it is due."""
        self._stuff()

    def _stuff(self) -> None:
        if self._row == 5:
            self.count += 1
            self._append(1 - self.bits[-1], self.places[-1])

    def _append(self, bit: int, place: int) -> None:
        self._row = self._row + 1 if self.bits and self.bits[-1] == bit else 1
        self.bits.append(bit)
        self.places.append(place)


@lru_cache(maxsize=256)
def stream(frame: CanFrame) -> Stream:
    """The bits of a frame."""
    return _fd_stream(frame) if frame.is_fd else _classical_stream(frame)


def _classical_stream(frame: CanFrame) -> Stream:
    wire = _Wire()
    wire.put(_arbitration(frame, int(frame.is_remote)))
    arbitration = len(wire.bits)
    length = frame.remote_length if frame.is_remote else len(frame.data)
    if frame.is_extended:
        wire.put(((0, 1, Place.RESERVED_1), (0, 1, Place.RESERVED_0), (length, 4, Place.DLC)))
    else:
        wire.put(((0, 1, Place.IDE), (0, 1, Place.RESERVED_0), (length, 4, Place.DLC)))
    wire.put(tuple((byte, 8, Place.DATA) for byte in frame.data))
    wire.put(((_crc(wire.raw, 0x4599, 15, 0), 15, Place.CRC),))
    wire.end_stuffing()
    return _with_tail(wire, arbitration, len(wire.bits), frozenset(), -1, range(0))


def _fd_stream(frame: CanFrame) -> Stream:
    wire = _Wire()
    wire.put(_arbitration(frame, 0))
    arbitration = len(wire.bits)
    if not frame.is_extended:
        wire.put(((0, 1, Place.IDE),))
    wire.put(((1, 1, Place.RESERVED_1),))
    fd_format = len(wire.bits) - 1
    wire.put(((0, 1, Place.RESERVED_0), (int(frame.is_bit_rate_switched), 1, Place.RESERVED_0)))
    wire.put(((0, 1, Place.RESERVED_0),))  # ESI: error active
    # a stuff bit between BRS and ESI is still sent at the nominal bit rate
    switch = len(wire.bits) - 1
    wire.put(((FD_LENGTHS.index(len(frame.data)), 4, Place.DLC),))
    wire.put(tuple((byte, 8, Place.DATA) for byte in frame.data))
    stuffed = len(wire.bits)
    fixed = _put_fd_crc(wire, len(frame.data))
    last = len(wire.bits)  # the CRC delimiter
    switched = range(switch, last + 1) if frame.is_bit_rate_switched else range(0)
    return _with_tail(wire, arbitration, stuffed, fixed, fd_format, switched)


def _put_fd_crc(wire: _Wire, length: int) -> frozenset[int]:
    gray = _GRAY[wire.count % 8]
    counted = gray << 1 | gray.bit_count() & 1
    width, polynomial = (17, 0x1685B) if length <= 16 else (21, 0x102899)
    covered = wire.bits + [counted >> position & 1 for position in (3, 2, 1, 0)]
    checked = counted << width | _crc(covered, polynomial, width, 1 << width - 1)
    fixed: set[int] = set()
    for position in range(width + 3, -1, -1):
        if (width + 3 - position) % 4 == 0:
            fixed.add(len(wire.bits))
            wire.put(((1 - wire.bits[-1], 1, Place.CRC),), is_stuffed=False)
        wire.put(((checked >> position, 1, Place.CRC),), is_stuffed=False)
    return frozenset(fixed)


def _arbitration(frame: CanFrame, remote: int) -> tuple[Field, ...]:
    identifier = frame.identifier
    base = identifier >> 18 if frame.is_extended else identifier
    head: tuple[Field, ...] = (
        (0, 1, Place.START),
        (base >> 3, 8, Place.ID_28_21),
        (base & 7, 3, Place.ID_20_18),
    )
    if not frame.is_extended:
        return (*head, (remote, 1, Place.RTR))
    return (
        *head,
        (1, 1, Place.SUBSTITUTE_RTR),
        (1, 1, Place.IDE),
        (identifier >> 13 & 0x1F, 5, Place.ID_17_13),
        (identifier >> 5 & 0xFF, 8, Place.ID_12_5),
        (identifier & 0x1F, 5, Place.ID_4_0),
        (remote, 1, Place.RTR),
    )


def _with_tail(
    wire: _Wire, arbitration: int, stuffed: int, fixed: frozenset[int], fd_format: int, switched: range
) -> Stream:
    delimiter = len(wire.bits)
    wire.put(_TAIL, is_stuffed=False)
    return Stream(bytes(wire.bits), bytes(wire.places), arbitration, stuffed, fixed, delimiter, fd_format, switched)


def _crc(bits: list[int], polynomial: int, width: int, start: int) -> int:
    crc, top = start, 1 << width - 1
    for bit in bits:
        feedback = bool(crc & top) ^ bit
        crc = (crc << 1 ^ polynomial * feedback) & (top << 1) - 1
    return crc
