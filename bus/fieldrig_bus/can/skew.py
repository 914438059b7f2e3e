"""The bits of a node as other nodes see them when one of them has a wrong bit rate.

A node samples each of its own bits at three quarters.  Resynchronisation is left out: it compensates deviations of
about one per cent, and a wrong bit rate deviates more.
"""

from fractions import Fraction
from functools import lru_cache

from fieldrig_bus.can.bits import Stream
from fieldrig_bus.can.notices import ErrorKind

NEVER_STUFFED = 1 << 40  # bits


@lru_cache(maxsize=256)
def seen_of(wire: Stream, bit_time: Fraction) -> Stream:
    """The bits that the bus sees from a sender whose bit time is `bit_time` times that of the bus.

    Only six equal bits in a row are wrong in it.
    """

    def at(bit: int) -> int:
        return min(int((bit + Fraction(3, 4)) / bit_time), len(wire.bits) - 1)

    length = max(int(len(wire.bits) * bit_time), 2)
    acknowledge = min(int((wire.acknowledge + 1) * bit_time), length - 1)
    return Stream(
        bytes(wire.bits[at(bit)] for bit in range(length)),
        bytes(wire.places[at(bit)] for bit in range(length)),
        int(wire.arbitration * bit_time),
        NEVER_STUFFED,
        frozenset(),
        acknowledge - 1,
        -1,
        range(0),
    )


@lru_cache(maxsize=256)
def blind_at(wire: Stream, bit_time: Fraction) -> tuple[int, ErrorKind]:
    """The bit of `wire` in which a receiver with a bit time of `bit_time` times that of the bus sees an error."""
    last, row, own_bit = 1, 0, 0
    while (bit := int((own_bit + Fraction(3, 4)) * bit_time)) < wire.delimiter:
        row = row + 1 if wire.bits[bit] == last else 1
        last = wire.bits[bit]
        if row == 6:
            return bit, ErrorKind.STUFF
        own_bit += 1
    return wire.acknowledge + 1, ErrorKind.CRC
