"""One SERCOS cycle on its way from the centre to the processes of the drives.

MST and MDT go out once; where a fault makes stations hear different things, the message lists what each one hears.
"""

import struct
from collections.abc import Sequence
from typing import Final

from fieldrig_bus.ring.sercos.fibre import Heard
from fieldrig_bus.ring.sercos.message import Cycle
from fieldrig_bus.ring.transport.spread import Spread, decode_rows, encode_rows
from fieldrig_bus.ring.transport.wire import HEAD, SEQUENCES

CYCLE_HEAD: Final = struct.Struct("<IHB")
"""After the head of every ring: number, where the MST ends in the message, and 0 if the MDT is all that follows."""
_MORE: Final = struct.Struct("<HH?")  # lengths of MDT and answers, and whether a list of stations follows
_START: Final = HEAD.size + CYCLE_HEAD.size
_MST, _MDT = 1, 2


def encode_spread(sequence: int, instant_ns: int, heard: Sequence[Heard], answers: bytes, stations: int) -> bytes:
    """`stations` is their number: where all of them hear the same, none is named."""
    number = heard[0][0].number & 0xFFFF_FFFF
    mst = next((cycle.mst for cycle, _ in heard if cycle.mst), b"")
    mdt = next((cycle.mdt for cycle, _ in heard if cycle.mdt), b"")
    is_listed = len(heard) != 1 or len(heard[0][1]) != stations
    is_more = bool(is_listed or answers)
    head = HEAD.pack(sequence % SEQUENCES, instant_ns) + CYCLE_HEAD.pack(number, _START + len(mst), is_more) + mst
    if not is_more:
        return head + mdt
    return head + _MORE.pack(len(mdt), len(answers), is_listed) + mdt + answers + (_listed(heard) if is_listed else b"")


def _listed(heard: Sequence[Heard]) -> bytes:
    return encode_rows((_MST * bool(cycle.mst) + _MDT * bool(cycle.mdt), names) for cycle, names in heard)


def decode_spread(data: bytes) -> Spread[Cycle]:
    """The inverse of `encode_spread`.  ValueError for anything else."""
    try:
        sequence, instant_ns = HEAD.unpack_from(data)
        number, mst_end, is_more = CYCLE_HEAD.unpack_from(data, HEAD.size)
        if not _START <= mst_end <= len(data):
            raise ValueError(f"a cycle of {len(data)} bytes has an MST that ends at {mst_end}")
        mst = data[_START:mst_end]
        if not is_more:
            return Spread(sequence, instant_ns, [(Cycle(number, mst, data[mst_end:]), ())], b"")
        mdt_length, answers_length, is_listed = _MORE.unpack_from(data, mst_end)
        mdt_end = mst_end + _MORE.size + mdt_length
        answers_end = mdt_end + answers_length
        if answers_end > len(data) or (answers_end < len(data) and not is_listed):
            raise ValueError(f"a cycle of {len(data)} bytes has an MDT of {mdt_length} and answers of {answers_length}")
        mdt = data[mdt_end - mdt_length : mdt_end]
        heard = _heard(number, mst, mdt, data[answers_end:]) if is_listed else [(Cycle(number, mst, mdt), ())]
        return Spread(sequence, instant_ns, heard, data[mdt_end:answers_end])
    except struct.error as cause:
        raise ValueError("a cycle is cut short") from cause


def _heard(number: int, mst: bytes, mdt: bytes, rows: bytes) -> list[Heard]:
    return [
        (Cycle(number, mst if hears & _MST else b"", mdt if hears & _MDT else b""), names)
        for hears, names in decode_rows(rows).items()
    ]
