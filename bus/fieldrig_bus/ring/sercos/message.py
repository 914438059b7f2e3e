"""Telegrams of a SERCOS ring, as the interface chips at both ends of the fibre report them.

Source: IEC 61491 (SERCOS I/II) by its public facts.  Between the fibre and a station's program is a chip (SERCON): it
repeats what passes, checks the FCS, and sends the AT from its buffer in its slot after the next MST.  So a drive has
one event per cycle, and leaves one AT.  Telegrams are bytes as on the fibre, address first.  The chip handles
delimiters, stuffing and FCS: a telegram with a wrong FCS does not arrive.
"""

import struct
from dataclasses import dataclass
from typing import Any, Final

from fieldrig.bus import words_of
from fieldrig.faults import note
from fieldrig.faults.note import FaultNote

BROADCAST: Final = 0xFF
"""Address of every MST, and of the MDT in CP3 and CP4."""


@dataclass(frozen=True, slots=True)
class Mst:
    """The master begins a cycle.  The ATs follow, as `Answers`, and then the master's MDT."""

    number: int
    """Number of the cycle, which is not on the fibre."""
    data: bytes
    """Address FFh and the phase."""


@dataclass(frozen=True, slots=True)
class Mdt:
    """The master sends the MDT of the cycle that it began, after it has heard the ATs; b"" if there is none."""

    data: bytes
    """Address and data records: those of one drive in CP1 and CP2, those of all drives from CP3 on."""


@dataclass(frozen=True, slots=True)
class Cycle:
    """One communication cycle as drives heard it, delivered at the end of the MDT.  A telegram that failed is b""."""

    number: int
    mst: bytes
    mdt: bytes


@dataclass(frozen=True, slots=True)
class Answers:
    """The ATs of one cycle in the order of the ring, for the master.  ATs that failed are missing."""

    number: int
    ats: tuple[bytes, ...]
    ring_closed: bool
    """True if the master's own MST came round."""
    errors: int = 0
    """Telegrams that arrived with a wrong FCS."""
    late: int = 0
    """Stations whose AT was not ready in time.  The ring knows them; a real master would see the ATs missing."""


RingMessage = Mst | Mdt | Cycle | Answers | bytes
"""Every message that a SERCOS ring carries.

Bytes are a drive's AT for its chip: address and data, sent once, after the next MST.
"""

_CYCLE, _ANSWERS, _AT, _MST, _MDT = range(5)
_HEAD: Final = struct.Struct("<BIBH")  # kind, number, length of the MST, length of the MDT
_MST_HEAD: Final = struct.Struct("<BI")  # kind, number
_ANSWERS_HEAD: Final = struct.Struct("<BI?HH")  # kind, number, ring closed, errors, late


LONGEST: Final = 0xFFFF
"""Largest telegram, in bytes: what the length in a record can express, and more than a cycle has time for."""


def check_sent(message: Any) -> None:
    """Raise TypeError or ValueError for what no station can send.  Only the ring sends `Cycle` and `Answers`."""
    if type(message) is bytes:
        data, shortest = message, 0
    elif type(message) is Mdt:
        data, shortest = message.data, 0
    elif type(message) is Mst:
        data, shortest = message.data, 1
        if type(message.number) is not int:
            raise TypeError(f"number: expected int, found {type(message.number).__name__}")
        if message.number < 0:
            raise ValueError(f"number {message.number}: expected 0 or more")
    else:
        raise TypeError(f"expected an Mst, Mdt, or the bytes of an AT, found {type(message).__name__}")
    if type(data) is not bytes:
        raise TypeError(f"data: expected bytes, found {type(data).__name__}")
    if not shortest <= len(data) <= LONGEST:
        raise ValueError(f"a telegram of {len(data)} bytes: expected {shortest} to {LONGEST}")


def check_interest(interest: Any) -> None:
    """Raise TypeError or ValueError for any interest but `["master"]`, `[["drive", ADDRESS], ...]` and None."""
    for word in words_of(interest):
        match word:
            case "master":
                continue
            case ["drive", int(address)] if type(address) is int and 0 <= address < BROADCAST:
                continue
        raise ValueError(f'{word!r}: expected "master", or ["drive", ADDRESS] with an address of 0 to 254')


def encode(message: RingMessage | FaultNote) -> bytes:
    if isinstance(message, bytes):
        return bytes((_AT,)) + message
    if isinstance(message, Mdt):
        return bytes((_MDT,)) + message.data
    if isinstance(message, Mst):
        return _MST_HEAD.pack(_MST, message.number & 0xFFFF_FFFF) + message.data
    if isinstance(message, Cycle):
        head = _HEAD.pack(_CYCLE, message.number & 0xFFFF_FFFF, len(message.mst), len(message.mdt))
        return head + message.mst + message.mdt
    if isinstance(message, FaultNote):
        return note.encode(message)
    head = _ANSWERS_HEAD.pack(_ANSWERS, message.number & 0xFFFF_FFFF, message.ring_closed, message.errors, message.late)
    return head + b"".join(len(at).to_bytes(2, "little") + at for at in message.ats)


def decode(data: bytes) -> Any:
    """The inverse of `encode`.  ValueError for anything else."""
    tag = data[:1]
    try:
        if tag == bytes((_AT,)):
            return data[1:]
        if tag == bytes((_MDT,)):
            return Mdt(data[1:])
        if tag == bytes((_MST,)):
            return Mst(_MST_HEAD.unpack_from(data)[1], data[_MST_HEAD.size :])
        if tag == bytes((_CYCLE,)):
            return _decoded_cycle(data)
        if tag == bytes((_ANSWERS,)):
            return _decoded_answers(data)
        if tag == note.LEAD:
            return note.decode(data)
    except struct.error as cause:
        raise ValueError(f"a ring message is cut short: {data.hex(' ')}") from cause
    raise ValueError(f"not a ring message: {data[:20].hex(' ')}")


def _decoded_cycle(data: bytes) -> Cycle:
    _, number, mst, mdt = _HEAD.unpack_from(data)
    start = _HEAD.size
    if len(data) != start + mst + mdt:
        raise ValueError(f"a cycle of {len(data)} bytes: expected {start + mst + mdt}, as its lengths say")
    return Cycle(number, data[start : start + mst], data[start + mst :])


def _decoded_answers(data: bytes) -> Answers:
    _, number, is_closed, errors, late = _ANSWERS_HEAD.unpack_from(data)
    ats, start = [], _ANSWERS_HEAD.size
    while start < len(data):
        end = start + 2 + int.from_bytes(data[start : start + 2], "little")
        if end > len(data) or end < start + 3:
            raise ValueError("an AT is cut short, or has no address")
        ats.append(data[start + 2 : end])
        start = end
    return Answers(number, tuple(ats), is_closed, errors, late)


def show(message: RingMessage | FaultNote) -> str:
    if isinstance(message, FaultNote):
        return note.show(message)
    if isinstance(message, bytes):
        return f"AT {message.hex(' ')}"
    if isinstance(message, Mdt):
        return f"MDT {message.data.hex(' ') or 'none'}"
    if isinstance(message, Mst):
        return f"{message.number} MST {message.data.hex(' ')}"
    if isinstance(message, Cycle):
        return f"{message.number} MST {message.mst.hex(' ') or 'failed'} MDT {message.mdt.hex(' ') or 'none'}"
    ats = "; ".join(at.hex(" ") for at in message.ats) or "none"
    closed = "" if message.ring_closed else ", ring open"
    errors = f", {message.errors} with a wrong FCS" if message.errors else ""
    late = f", {message.late} late" if message.late else ""
    return f"{message.number} ATs {ats}{closed}{errors}{late}"
