"""When telegrams lie on the fibre.

Source: IEC 61491: a telegram is a delimiter, address, data, 16 bits of FCS and a delimiter; the bytes between are
stuffed like HDLC, at most one bit in five.  Slots are laid out for the worst case, as masters do: the MST at the start
of a cycle (t = 0), then the ATs in the order of the ring (t1), then the MDT (t2).  Ring delay is left out: some bits a
station.
"""

from collections.abc import Iterable
from typing import Final

DELIMITER_BITS: Final = 8
FCS_BITS: Final = 16
GAP_NS: Final = 10_000
"""Between two telegrams: what a receiver needs to be ready again; our choice."""
MST_BYTES: Final = 2


def telegram_ns(length: int, mbaud: int) -> int:
    """How long a telegram of `length` bytes, its address counted, may take."""
    bits = 8 * length + FCS_BITS
    return (bits + bits // 5 + 2 * DELIMITER_BITS) * 1_000 // mbaud


def answers_ns(lengths: Iterable[int], mbaud: int) -> int:
    """From the MST's start to the end of the last AT, of these lengths."""
    return telegram_ns(MST_BYTES, mbaud) + sum(GAP_NS + telegram_ns(length, mbaud) for length in lengths)


def cycle_ns(ats: Iterable[int], mdt: int, mbaud: int) -> int:
    """From the MST's start to the end of the MDT: the least that a cycle takes."""
    return answers_ns(ats, mbaud) + (GAP_NS + telegram_ns(mdt, mbaud) if mdt else 0)
