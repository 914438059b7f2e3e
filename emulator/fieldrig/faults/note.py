"""The line of the trace that says that an injected fault was applied, on a bus of any family."""

import struct
from dataclasses import dataclass
from typing import ClassVar, Final

LONGEST: Final = 200
"""Longest text, in characters."""
LEAD: Final = b"\xff"
"""First byte of an encoded note; no message of a family with such notes begins with it."""


@dataclass(frozen=True, slots=True)
class FaultNote:
    """An injected fault was applied; the sender of its line in the trace is the member that was affected."""

    WIRE: ClassVar = struct.Struct("<I")
    fault: int
    what: str


def encode(note: FaultNote) -> bytes:
    return LEAD + FaultNote.WIRE.pack(note.fault) + note.what.encode()


def decode(data: bytes) -> FaultNote:
    """The inverse of `encode`.  ValueError for anything else."""
    start = len(LEAD) + FaultNote.WIRE.size
    if not data.startswith(LEAD) or len(data) < start:
        raise ValueError(f"not a note of a fault: {data[:80].hex(' ')}")
    (number,) = FaultNote.WIRE.unpack(data[len(LEAD) : start])
    return FaultNote(number, data[start:].decode()[:LONGEST])


def show(note: FaultNote) -> str:
    return f"fault {note.fault}: {note.what}"
