"""What goes between the star's centre and the processes of its drives: one message each way and cycle.

Out: MST and MDT once; where a fault makes stations hear different things, who hears what.  Back: the ATs that the
process has left, and by `sequence` which cycle it is done with, so that the centre sees who is late and by how much.
"""

import struct
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

from fieldrig_bus.ring.fibre import Heard
from fieldrig_bus.ring.message import Cycle

HEAD: Final = struct.Struct("<IqIHB")
"""Of a cycle: sequence, instant, number, where the MST ends, and 0 if all else is the MDT; so it is in nearly all."""
_MORE: Final = struct.Struct("<HH?")  # lengths of MDT and answers, and whether stations are listed behind them
_LISTED: Final = struct.Struct("<BB")  # what it hears, length of its name
_BACK: Final = struct.Struct("<Iq")  # sequence, instant
_AT: Final = struct.Struct("<BH")  # place of the station in its process, length
_MST, _MDT = 1, 2


class Spread(NamedTuple):
    """One cycle, as it goes to every process."""

    sequence: int
    instant_ns: int
    """When it happened, by the clock of the master's machine."""
    heard: Sequence[Heard]
    """Without names: all stations."""
    answers: bytes
    """The master's, encoded, if anybody observes."""


def encode_spread(sequence: int, instant_ns: int, heard: Sequence[Heard], answers: bytes, stations: int) -> bytes:
    """`stations` is how many there are: where all hear the same, nobody is named."""
    number = heard[0][0].number & 0xFFFF_FFFF
    mst = next((cycle.mst for cycle, _ in heard if cycle.mst), b"")
    mdt = next((cycle.mdt for cycle, _ in heard if cycle.mdt), b"")
    is_listed = len(heard) != 1 or len(heard[0][1]) != stations
    is_more = bool(is_listed or answers)
    head = HEAD.pack(sequence & 0xFFFF_FFFF, instant_ns, number, HEAD.size + len(mst), is_more) + mst
    if not is_more:
        return head + mdt
    return head + _MORE.pack(len(mdt), len(answers), is_listed) + mdt + answers + (_listed(heard) if is_listed else b"")


def _listed(heard: Sequence[Heard]) -> bytes:
    rows = bytearray()
    for cycle, names in heard:
        hears = _MST * bool(cycle.mst) + _MDT * bool(cycle.mdt)
        for name in names:
            text = name.encode()
            rows += _LISTED.pack(hears, len(text)) + text
    return bytes(rows)


def decode_spread(data: bytes) -> Spread:
    """ValueError for anything that `encode_spread` doesn't write."""
    try:
        sequence, instant_ns, number, mst_end, is_more = HEAD.unpack_from(data)
        if not HEAD.size <= mst_end <= len(data):
            raise ValueError(f"a cycle of {len(data)} bytes has an MST that ends at {mst_end}")
        mst = data[HEAD.size : mst_end]
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
    groups: dict[int, list[str]] = {}
    start = 0
    while start < len(rows):
        hears, length = _LISTED.unpack_from(rows, start)
        start += _LISTED.size + length
        if start > len(rows):
            raise ValueError("in a cycle the name of a station is cut short")
        groups.setdefault(hears, []).append(rows[start - length : start].decode())
    return [
        (Cycle(number, mst if hears & _MST else b"", mdt if hears & _MDT else b""), names)
        for hears, names in groups.items()
    ]


Back = tuple[int, int, list[tuple[int, bytes]]]
"""What a process answers: with which cycle it is done, when, by the clock of its machine, and the ATs, with the places
of the stations in their process."""


def encode_back(sequence: int, instant_ns: int, ats: Iterable[tuple[int, bytes]]) -> bytes:
    message = _BACK.pack(sequence, instant_ns)
    for place, at in ats:
        message += _AT.pack(place, len(at)) + at
    return message


def decode_back(data: bytes) -> Back:
    """ValueError for anything that `encode_back` doesn't write."""
    try:
        sequence, instant_ns = _BACK.unpack_from(data)
        ats: list[tuple[int, bytes]] = []
        end, length = _BACK.size, len(data)
        while end < length:
            place, size = _AT.unpack_from(data, end)
            start = end + _AT.size
            end = start + size
            ats.append((place, data[start:end]))
    except struct.error as cause:
        raise ValueError("an answer is cut short") from cause
    if end > length:
        raise ValueError("an AT is cut short")
    return sequence, instant_ns, ats
