"""Words of a DualPort memory: 2048 words of 16 bits, shared by a controller and a master."""

import struct
from dataclasses import dataclass
from typing import Any, Final

from fieldrig.bus import words_of
from fieldrig.faults import note
from fieldrig.faults.note import FaultNote

WORDS: Final = 2048
_HEAD: Final = struct.Struct(">H")


@dataclass(frozen=True, slots=True)
class Words:
    """Words to write, one after another."""

    first: int
    """Number of the first word."""
    values: tuple[int, ...]


OnMemory = Words | FaultNote
"""The lines of a trace of the memory."""


def encode(message: OnMemory) -> bytes:
    if isinstance(message, FaultNote):
        return note.encode(message)
    return _HEAD.pack(message.first) + struct.pack(f">{len(message.values)}H", *message.values)


def decode(data: bytes) -> Any:
    """Return the message of `encode`'s bytes.  ValueError for anything else."""
    if data.startswith(note.LEAD):
        return note.decode(data)
    if len(data) < _HEAD.size or len(data) % 2:
        raise ValueError(f"not words of a memory: {data[:40].hex(' ')}")
    first, *values = struct.unpack(f">{len(data) // 2}H", data)
    words = Words(first, tuple(values))
    check_sent(words)
    return words


def show(message: OnMemory) -> str:
    if isinstance(message, FaultNote):
        return note.show(message)
    return f"word {message.first}: {' '.join(f'{value:04X}' for value in message.values)}"


def check_sent(message: Any) -> None:
    """Raise TypeError or ValueError for words that the memory cannot have."""
    if type(message) is not Words:
        raise TypeError(f"expected Words, found {type(message).__name__}")
    for value in (message.first, *message.values):
        if type(value) is not int:
            raise TypeError(f"expected integers, found {type(value).__name__}")
        if not 0 <= value <= 0xFFFF:
            raise ValueError(f"{value}: expected 0 to 65535")
    if message.first + len(message.values) > WORDS:
        raise ValueError(f"words {message.first} to {message.first + len(message.values) - 1}, expected 0 to 2047")


def check_interest(interest: Any) -> None:
    """Raise TypeError or ValueError for any interest but none, as a memory reports nothing."""
    if len(words_of(interest)):
        raise ValueError("a memory reports nothing: expected no interest")
