"""The number of bits that a frame takes on the wire, including stuff bits and intermission.

Source: ISO 11898-1:2015 (frame formats, CRC, bit stuffing).  The count goes from the start of frame to the last of the
three bits of intermission.  In an FD frame with a switched bit rate, the bits from ESI to the CRC delimiter count at
the data bit rate: the rate switches at the sample points of BRS and CRC delimiter, so with the same sample point in
both rates the surplus and the deficit cancel exactly.

Left out on purpose: suspend transmission of error-passive nodes, error and overload frames.
"""

from functools import lru_cache
from typing import Final

from fieldrig_bus.can.frame import FD_LENGTHS, CanFrame

INTERMISSION_BITS: Final = 3

# CRC delimiter, ACK slot, ACK delimiter, EOF 7, intermission: never stuffed.
_TAIL_BITS: Final = 1 + 1 + 1 + 7 + INTERMISSION_BITS
_CRC15_POLYNOMIAL: Final = 0x4599

# A state of bit stuffing is the last bit on the wire and its number in a row (1 to 4; at 5 the complement is stuffed,
# which is a row of 1): `bit << 2 | row - 1`.
_RECESSIVE_ONCE: Final = 0b1_00
_DOMINANT_TWICE: Final = 0b0_01


def _stuff_bit(state: int, bit: int) -> tuple[int, int]:
    """The state after one more bit, and the stuff bits (0 or 1) that follow it."""
    if state >> 2 != bit:
        return bit << 2, 0
    if state & 0b11 < 3:
        return state + 1, 0
    return (1 - bit) << 2, 1


def _stuff(state: int, bits: int, width: int) -> tuple[int, int]:
    """The state after `width` more bits, highest first, and the number of stuff bits."""
    stuffed = 0
    for position in range(width - 1, -1, -1):
        state, extra = _stuff_bit(state, bits >> position & 1)
        stuffed += extra
    return state, stuffed


def _crc15_of_byte(byte: int) -> int:
    crc = byte << 7
    for _ in range(8):
        crc = crc << 1 ^ (_CRC15_POLYNOMIAL if crc & 0x4000 else 0)
    return crc & 0x7FFF


def _stuff_of_bytes(state: int) -> tuple[tuple[int, int], ...]:
    """The result of `_stuff` for each byte.  It is built bit by bit: the row for n bits is twice that for n - 1."""
    row = [(state, 0)]
    for _ in range(8):
        row = [
            (after, stuffed + extra)
            for before, stuffed in row
            for after, extra in (_stuff_bit(before, 0), _stuff_bit(before, 1))
        ]
    return tuple(row)


_CRC15: Final = tuple(_crc15_of_byte(byte) for byte in range(256))
_STUFF: Final = tuple(_stuff_of_bytes(state) for state in range(8))


@lru_cache(maxsize=8192)
def _head(fields: int, width: int) -> tuple[int, int, int]:
    """CRC-15, state and stuff bits after a start of frame and `width` bits of `fields`."""
    crc = 0
    for byte in fields.to_bytes(5, "big"):  # leading zeros, such as the start of frame, leave the CRC at 0
        crc = (crc << 8 & 0x7FFF) ^ _CRC15[crc >> 7 ^ byte]
    state, stuffed = _stuff(_RECESSIVE_ONCE, fields, width + 1)  # the bus was idle: recessive
    return crc, state, stuffed


def classical_bits(frame: CanFrame) -> int:
    """The number of bits of a frame in classical base or extended format."""
    data = frame.data
    remote, dlc = (1, frame.remote_length) if frame.is_remote else (0, len(data))
    identifier = frame.identifier
    if frame.is_extended:
        # base identifier 11, SRR, IDE, identifier extension 18, RTR, r1, r0, DLC 4
        fields = identifier >> 18 << 27 | 0b11 << 25 | (identifier & 0x3FFFF) << 7 | remote << 6 | dlc
        crc, state, stuffed = _head(fields, 38)
        bits = 1 + 38 + 15 + _TAIL_BITS
    else:
        # identifier 11, RTR, IDE, r0, DLC 4
        crc, state, stuffed = _head(identifier << 7 | remote << 6 | dlc, 18)
        bits = 1 + 18 + 15 + _TAIL_BITS
    crcs, steps = _CRC15, _STUFF
    for byte in data:
        crc = (crc << 8 & 0x7FFF) ^ crcs[crc >> 7 ^ byte]
        state, extra = steps[state][byte]
        stuffed += extra
    # The 15 bits of the CRC in two bytes; the 16th is the complement of the last bit, so it cannot cause a stuff bit.
    state, extra = steps[state][crc >> 7]
    stuffed += extra + steps[state][crc << 1 & 0xFF | ~crc & 1][1]
    return bits + 8 * len(data) + stuffed


@lru_cache(maxsize=32)
def _fd_control(is_switched: bool, length: int) -> tuple[int, int]:
    """State and stuff bits after ESI (dominant) and DLC, which follow BRS; FDF 1 and res 0 precede it."""
    return _stuff(_RECESSIVE_ONCE if is_switched else _DOMINANT_TWICE, FD_LENGTHS.index(length), 1 + 4)


def fd_bits(frame: CanFrame) -> tuple[int, int]:
    """The number of bits of an FD frame at the nominal bit rate, and at the data bit rate (0 unless it switches)."""
    data, identifier, brs = frame.data, frame.identifier, int(frame.is_bit_rate_switched)
    if frame.is_extended:
        # base identifier 11, SRR, IDE, identifier extension 18, RRS, FDF, res, BRS
        fields, width = identifier >> 18 << 24 | 0b11 << 22 | (identifier & 0x3FFFF) << 4 | 0b0100 | brs, 35
    else:
        # identifier 11, RRS, IDE, FDF, res, BRS
        fields, width = identifier << 5 | 0b00100 | brs, 16
    nominal = 1 + width + _head(fields, width)[2]
    state, stuffed = _fd_control(bool(brs), len(data))
    for byte in data:
        state, extra = _STUFF[state][byte]
        stuffed += extra
    last_bit = (data[-1] if data else FD_LENGTHS.index(len(data))) & 1
    if state >> 2 != last_bit:
        stuffed -= 1  # a stuff bit that would be due at the place of the first fixed one is left out
    # ESI, DLC 4, data; stuff count 4 and CRC 17 or 21 with a fixed stuff bit before every 4 bits; CRC delimiter
    switched = 1 + 4 + 8 * len(data) + stuffed + (4 + 17 + 6 if len(data) <= 16 else 4 + 21 + 7) + 1
    nominal += _TAIL_BITS - 1
    return (nominal, switched) if brs else (nominal + switched, 0)
