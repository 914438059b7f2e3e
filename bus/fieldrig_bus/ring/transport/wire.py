"""Messages between the centre of a ring and the processes of its stations: one each way per cycle.

Out: `HEAD`, and then the cycle in the words of the kind of ring.  Back: the telegrams that the process has left, and by
`sequence` the cycle that it is done with, so that the centre sees which process is late and by how much.
"""

import struct
from collections.abc import Iterable, Sequence
from typing import Final

HEAD: Final = struct.Struct("<Iq")
"""Head of a cycle: sequence, and the instant by the clock of the master's machine in nanoseconds."""
SEQUENCES: Final = 1 << 32
"""Sequence numbers, after which they begin again at 0."""
_BACK: Final = struct.Struct("<Iq")  # sequence, instant
_TELEGRAM: Final = struct.Struct("<BH")  # place of the station in its process, length

Stations = Sequence[tuple[str, Sequence[int] | None]]
"""Names and addresses, in the order in which a process counts its stations; None for an observer."""
Back = tuple[int, int, list[tuple[int, bytes]]]
"""A process's answer: the sequence that it is done with, the instant by the clock of its machine, and the telegrams
with the places of the stations in their process."""


def encode_back(sequence: int, instant_ns: int, telegrams: Iterable[tuple[int, bytes]]) -> bytes:
    """The answer of a process, as bytes."""
    message = _BACK.pack(sequence, instant_ns)
    for number, telegram in telegrams:
        message += _TELEGRAM.pack(number, len(telegram)) + telegram
    return message


def decode_back(data: bytes) -> Back:
    """The inverse of `encode_back`.  ValueError for anything else."""
    try:
        sequence, instant_ns = _BACK.unpack_from(data)
        telegrams: list[tuple[int, bytes]] = []
        end, length = _BACK.size, len(data)
        while end < length:
            number, size = _TELEGRAM.unpack_from(data, end)
            start = end + _TELEGRAM.size
            end = start + size
            telegrams.append((number, data[start:end]))
    except struct.error as cause:
        raise ValueError("an answer is cut short") from cause
    if end > length:
        raise ValueError("a telegram is cut short")
    return sequence, instant_ns, telegrams
