"""One cycle on its way from the centre to the processes of the nodes; `transport/spread` has the rows."""

import struct
from collections.abc import Sequence
from typing import Final

from fieldrig_bus.ring.pam.medium import Heard
from fieldrig_bus.ring.pam.message import VERSION, Cycle, Frame, Reception, decode_frames, encode_frames
from fieldrig_bus.ring.transport.spread import Spread, decode_rows, encode_rows
from fieldrig_bus.ring.transport.wire import HEAD, SEQUENCES

_CYCLE: Final = struct.Struct("<BBI")  # version, what follows the frames, number
_ALIKE, _OBSERVED, _LISTED = 0, 1, 2
_MORE: Final = struct.Struct("<HH")  # lengths of the frames, and of the reports for observers
START: Final = HEAD.size + _CYCLE.size


def encode_spread(sequence: int, instant_ns: int, heard: Sequence[Heard], reports: bytes, stations: int) -> bytes:
    """`heard` begins with the frames; `stations` is their number: where all of them hear the frames, none is named."""
    cycle = heard[0][0]
    is_listed = len(heard) != 1 or len(heard[0][1]) != stations
    more = _OBSERVED * bool(reports) + _LISTED * is_listed
    frames = encode_frames(cycle.frames)
    head = HEAD.pack(sequence % SEQUENCES, instant_ns) + _CYCLE.pack(VERSION, more, cycle.number & 0xFFFF_FFFF)
    if not more:
        return head + frames
    rows = encode_rows((cycle.reception, names) for cycle, names in heard) if is_listed else b""
    return head + _MORE.pack(len(frames), len(reports)) + frames + reports + rows


def decode_alike(data: bytes) -> Cycle | None:
    """The cycle that all nodes hear; None if more follows.  ValueError for anything else."""
    more, number = _head(data)
    return Cycle(number, decode_frames(data, START)) if more == _ALIKE else None


def _head(data: bytes) -> tuple[int, int]:
    """Return what follows the frames, and the number of the cycle.  ValueError for anything else."""
    if len(data) < START:
        raise ValueError("a cycle is cut short")
    version, more, number = _CYCLE.unpack_from(data, HEAD.size)
    if version != VERSION:
        raise ValueError(f"a cycle of version {version}: expected {VERSION}")
    return more, number


def decode_spread(data: bytes) -> Spread[Cycle]:
    """Return what each node hears.  ValueError for anything else."""
    try:
        more, number = _head(data)
        sequence, instant_ns = HEAD.unpack_from(data)
        if more == _ALIKE:
            return Spread(sequence, instant_ns, [(Cycle(number, decode_frames(data, START)), ())], b"")
        frames_length, reports_length = _MORE.unpack_from(data, START)
        frames_start = START + _MORE.size
        reports_start = frames_start + frames_length
        rows_start = reports_start + reports_length
        if rows_start > len(data):
            raise ValueError("a cycle is cut short")
        frames = decode_frames(data[frames_start:reports_start])
        heard = _heard(number, frames, data[rows_start:]) if more & _LISTED else [(Cycle(number, frames), ())]
        return Spread(sequence, instant_ns, heard, data[reports_start:rows_start])
    except struct.error as cause:
        raise ValueError("a cycle is cut short") from cause


def _heard(number: int, frames: tuple[Frame, ...], rows: bytes) -> list[Heard]:
    return [
        (Cycle(number, () if hears else frames, Reception(hears)), names) for hears, names in decode_rows(rows).items()
    ]
