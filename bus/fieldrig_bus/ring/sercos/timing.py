"""Duration of telegrams and of cycles on the fibre.

Source: IEC 61491: a telegram is a delimiter, address, data, 16 bits of FCS and a delimiter; the bytes between the
delimiters are stuffed as in HDLC, at most one bit in five.  Slots are laid out for the worst case, as masters do: the
MST at the start of a cycle (t = 0), then the ATs in the order of the ring (t1), then the MDT (t2).
Left out: the ring delay, which is some bits per station.
"""

from collections.abc import Iterable
from typing import Final

DELIMITER_BITS: Final = 8
FCS_BITS: Final = 16
GAP_NS: Final = 10_000
"""Gap between two telegrams, in which a receiver becomes ready again.  The value is a choice of this model."""
MST_BYTES: Final = 2


def telegram_ns(length: int, mbaud: int) -> int:
    """The longest duration of a telegram of `length` bytes including its address."""
    bits = 8 * length + FCS_BITS
    return (bits + bits // 5 + 2 * DELIMITER_BITS) * 1_000 // mbaud


def answers_ns(lengths: Iterable[int], mbaud: int) -> int:
    """The time from the start of the MST to the end of the last AT, for ATs of these lengths."""
    return telegram_ns(MST_BYTES, mbaud) + sum(GAP_NS + telegram_ns(length, mbaud) for length in lengths)


def cycle_ns(ats: Iterable[int], mdt: int, mbaud: int) -> int:
    """The time from the start of the MST to the end of the MDT, which is the shortest cycle time."""
    return answers_ns(ats, mbaud) + (GAP_NS + telegram_ns(mdt, mbaud) if mdt else 0)
