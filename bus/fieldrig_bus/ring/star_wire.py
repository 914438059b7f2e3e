"""What goes between the star's centre and the processes of its drives: one message each way and cycle.

Out: MST and MDT once; where a fault makes stations hear different things, who hears what.  Back: the ATs that the
process has left, and by `sequence` which cycle it is done with, so that the centre sees who is late and by how much.
"""

import struct
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

from fieldrig_bus.ring.fibre import Heard
from fieldrig_bus.ring.message import Cycle

_OUT: Final = struct.Struct("<IqIBHHBH")
"""Sequence, instant, number, lengths of MST, MDT and answers, whether stations are listed, and their length."""
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
    listed = _listed(heard) if is_listed else b""
    lengths = len(mst), len(mdt), len(answers), is_listed, len(listed)
    return _OUT.pack(sequence & 0xFFFF_FFFF, instant_ns, number, *lengths) + mst + mdt + answers + listed


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
        sequence, instant_ns, number, mst_length, mdt_length, answers_length, is_listed, listed_length = (
            _OUT.unpack_from(data)
        )
        mdt_start = _OUT.size + mst_length
        answers_start = mdt_start + mdt_length
        listed_start = answers_start + answers_length
        if listed_start + listed_length != len(data):
            raise ValueError(f"a cycle of {len(data)} bytes says it has {listed_start + listed_length}")
        mst, mdt = data[_OUT.size : mdt_start], data[mdt_start:answers_start]
        heard = _heard(number, mst, mdt, data[listed_start:]) if is_listed else [(Cycle(number, mst, mdt), ())]
        return Spread(sequence, instant_ns, heard, data[answers_start:listed_start])
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


class Back(NamedTuple):
    """What a process answers."""

    sequence: int
    instant_ns: int
    """When it was done, by the clock of its machine."""
    ats: list[tuple[int, bytes]]
    """With the place of the station in its process."""


def encode_back(sequence: int, instant_ns: int, ats: Iterable[tuple[int, bytes]]) -> bytes:
    return _BACK.pack(sequence, instant_ns) + b"".join(_AT.pack(place, len(at)) + at for place, at in ats)


def decode_back(data: bytes) -> Back:
    """ValueError for anything that `encode_back` doesn't write."""
    try:
        sequence, instant_ns = _BACK.unpack_from(data)
        ats: list[tuple[int, bytes]] = []
        start = _BACK.size
        while start < len(data):
            place, length = _AT.unpack_from(data, start)
            end = start + _AT.size + length
            if end > len(data):
                raise ValueError("an AT is cut short")
            ats.append((place, data[start + _AT.size : end]))
            start = end
    except struct.error as cause:
        raise ValueError("an answer is cut short") from cause
    return Back(sequence, instant_ns, ats)
