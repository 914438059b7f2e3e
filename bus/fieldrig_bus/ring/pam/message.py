"""Messages of a PAM's ring, as the interface chips at both ends of the fibre report them.

Source: the manual says what the ring does, but not how its frames look (PAM V2.5, B.2 and B.7), so this form is ours,
and this file is the place for the real one.  In every basic cycle the PAM sends its frames in one go round the ring:
each goes to one node, to a group of nodes, or to all.  The nodes' chips add what is in their buffers, so the reports of
the last cycle come back in the same round.  The chip checks the CRC of every frame: a damaged one does not arrive.
What is in a frame is the business of the programs at the ends.
"""

import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, Final

from fieldrig.bus import words_of
from fieldrig.faults import note
from fieldrig.faults.note import FaultNote

VERSION: Final = 1
"""Version of this form; a message of another one is refused."""
BROADCAST: Final = 0
"""The target of a frame to all nodes."""
MOST_ADDRESS: Final = 0xFF
GROUP: Final = 0x100
"""The target of a frame to group 1 is this plus 1, and so on."""
MOST_GROUP: Final = 15
LONGEST: Final = 0xFF
"""Longest contents of a frame, in bytes."""

Frame = tuple[int, bytes]
"""The target of a frame, or the address of the node that reports, and its contents."""


class Reception(IntEnum):
    """The state of the light and of the frames that a chip receives."""

    GOOD = 0
    NO_CARRIER = 1
    """No light, directly behind an opening of the ring."""
    CRC_ERROR = 2
    """Frames with a wrong CRC, directly behind the place that damages them."""


@dataclass(frozen=True, slots=True)
class Frames:
    """The PAM begins a cycle, and sends these frames."""

    number: int
    """Number of the cycle, which is not on the fibre."""
    frames: tuple[Frame, ...]


@dataclass(frozen=True, slots=True)
class Cycle:
    """One cycle as nodes hear it.  If it does not arrive well, it has no frames."""

    number: int
    frames: tuple[Frame, ...]
    reception: Reception = Reception.GOOD
    by_target: dict[int, list[bytes]] = field(init=False, repr=False, compare=False)
    """Contents of the frames by target; nodes that share a process share it."""
    has_groups: bool = field(init=False, repr=False, compare=False)
    """True if any frame goes to a group."""

    def __post_init__(self) -> None:
        by_target: dict[int, list[bytes]] = {}
        for target, contents in self.frames:
            if target in by_target:
                by_target[target].append(contents)
            else:
                by_target[target] = [contents]
        object.__setattr__(self, "by_target", by_target)
        object.__setattr__(self, "has_groups", bool(by_target) and max(by_target) > GROUP)


@dataclass(frozen=True, slots=True)
class Reports:
    """The answer of the ring to one cycle, as the PAM hears it."""

    number: int
    reports: tuple[Frame, ...]
    """Addresses and what each node had in its buffer, in the order of the ring."""
    addresses: tuple[int, ...]
    """Addresses of the nodes that the cycle went through, in the order of the ring."""
    reception: Reception = Reception.GOOD
    place: int = 0
    """If the reception is not good, the address of the node that noticed it first; 0 is the PAM itself."""
    late: int = 0
    """Nodes that have not reacted in time.  The ring knows them; a real PAM would only see that nothing comes."""


RingMessage = Frames | Cycle | Reports | bytes
"""Bytes are what a node puts into the buffer of its chip."""

_FRAMES, _CYCLE, _REPORTS, _BUFFER = range(4)
_HEAD: Final = struct.Struct("<BBI")  # version, kind, number of the cycle
CRC_BYTES: Final = 2
_FRAME: Final = struct.Struct("<HB")  # target or address, length
_RECEPTION: Final = struct.Struct("<B")
_REPORTS_HEAD: Final = struct.Struct("<BBHB")  # reception, place, late, number of addresses
LONGEST_BUFFER: Final = 512
"""Largest contents of a node's buffer for one cycle, in bytes."""
_REPORT: Final = struct.Struct("<HH")  # address, length


def check_sent(message: Any) -> None:
    """Raise TypeError or ValueError for what no member can send.  Only the ring sends `Cycle` and `Reports`."""
    if type(message) is bytes:
        if len(message) > LONGEST_BUFFER:
            raise ValueError(f"a report of {len(message)} bytes: expected at most {LONGEST_BUFFER}")
        return
    if type(message) is not Frames:
        raise TypeError(f"expected Frames, or the bytes of a report, found {type(message).__name__}")
    if type(message.number) is not int or type(message.frames) is not tuple:
        raise TypeError("expected a number and a tuple of frames")
    if message.number < 0:
        raise ValueError(f"number {message.number}: expected 0 or more")
    for target, contents in message.frames:
        if type(target) is not int or type(contents) is not bytes:
            raise TypeError(f"expected a target and bytes, found {target!r} and {contents!r}")
        if not 0 <= target <= GROUP + MOST_GROUP or target == GROUP:
            raise ValueError(f"target {target}: expected 0 to {MOST_ADDRESS}, or a group of 1 to {MOST_GROUP}")
        if not 0 < len(contents) <= LONGEST:
            raise ValueError(f"a frame of {len(contents)} bytes: expected 1 to {LONGEST}")


def check_interest(interest: Any) -> None:
    """Raise TypeError or ValueError for any interest but `["master"]`, `[["node", ADDRESS]]` and None."""
    for word in words_of(interest):
        match word:
            case "master":
                continue
            case ["node", int(address)] if type(address) is int and 0 < address <= MOST_ADDRESS:
                continue
        raise ValueError(f'{word!r}: expected "master", or ["node", ADDRESS] with an address of 1 to {MOST_ADDRESS}')


def encode_frames(frames: Iterable[Frame]) -> bytes:
    return b"".join([_FRAME.pack(target, len(contents)) + contents for target, contents in frames])


def decode_frames(data: bytes, start: int = 0) -> tuple[Frame, ...]:
    """The inverse of `encode_frames`, from `start` on.  ValueError for anything else."""
    return _decoded(_FRAME, data, start)


def _decoded(head: struct.Struct, data: bytes, start: int) -> tuple[Frame, ...]:
    frames, end, size = [], len(data), head.size
    while start < end:
        try:
            number, length = head.unpack_from(data, start)
        except struct.error as cause:
            raise ValueError("the head of a frame is cut short") from cause
        start += size + length
        frames.append((number, data[start - length : start]))
    if start > end:
        raise ValueError("a frame is cut short")
    return tuple(frames)


def encode(message: RingMessage | FaultNote) -> bytes:
    if isinstance(message, bytes):
        return _HEAD.pack(VERSION, _BUFFER, 0) + message
    if isinstance(message, FaultNote):
        return note.encode(message)
    number = message.number & 0xFFFF_FFFF
    if isinstance(message, Frames):
        return _HEAD.pack(VERSION, _FRAMES, number) + encode_frames(message.frames)
    if isinstance(message, Cycle):
        head = _HEAD.pack(VERSION, _CYCLE, number) + _RECEPTION.pack(message.reception)
        return head + encode_frames(message.frames)
    counts = _REPORTS_HEAD.pack(message.reception, message.place, message.late, len(message.addresses))
    reports = b"".join(_REPORT.pack(address, len(buffer)) + buffer for address, buffer in message.reports)
    return _HEAD.pack(VERSION, _REPORTS, number) + counts + bytes(message.addresses) + reports


def decode(data: bytes) -> Any:
    """The inverse of `encode`.  ValueError for anything else."""
    try:
        if data.startswith(note.LEAD):
            return note.decode(data)
        version, tag, number = _HEAD.unpack_from(data)
        if version != VERSION:
            raise ValueError(f"a ring message of version {version}: expected {VERSION}")
        if tag == _BUFFER:
            return data[_HEAD.size :]
        if tag == _FRAMES:
            return Frames(number, decode_frames(data, _HEAD.size))
        if tag == _CYCLE:
            (reception,) = _RECEPTION.unpack_from(data, _HEAD.size)
            return Cycle(number, decode_frames(data, _HEAD.size + _RECEPTION.size), Reception(reception))
        if tag == _REPORTS:
            return _decoded_reports(number, data)
    except struct.error as cause:
        raise ValueError(f"a ring message is cut short: {data.hex(' ')}") from cause
    raise ValueError(f"not a ring message: {data[:20].hex(' ')}")


def _decoded_reports(number: int, data: bytes) -> Reports:
    reception, place, late, count = _REPORTS_HEAD.unpack_from(data, _HEAD.size)
    start = _HEAD.size + _REPORTS_HEAD.size
    addresses = tuple(data[start : start + count])
    if len(addresses) != count:
        raise ValueError(f"{len(addresses)} addresses: expected {count}")
    return Reports(number, _decoded(_REPORT, data, start + count), addresses, Reception(reception), place, late)


def show(message: RingMessage | FaultNote) -> str:
    if isinstance(message, FaultNote):
        return note.show(message)
    if isinstance(message, bytes):
        return f"report {message.hex(' ')}"
    if isinstance(message, Reports):
        return _shown_reports(message)
    frames = "; ".join(f"{_target(target)} {contents.hex(' ')}" for target, contents in message.frames)
    if isinstance(message, Cycle) and message.reception != Reception.GOOD:
        return f"{message.number} {_WORDS[message.reception]}"
    return f"{message.number} {frames or 'no frames'}"


_WORDS: Final = {Reception.NO_CARRIER: "no carrier", Reception.CRC_ERROR: "wrong CRC"}


def _target(target: int) -> str:
    if target == BROADCAST:
        return "to all:"
    return f"to group {target - GROUP}:" if target > GROUP else f"to {target}:"


def _shown_reports(message: Reports) -> str:
    reports = "; ".join(f"from {address}: {buffer.hex(' ')}" for address, buffer in message.reports) or "no reports"
    late = f", {message.late} late" if message.late else ""
    if message.reception == Reception.GOOD:
        return f"{message.number} {reports}{late}"
    noticed = f"node {message.place}" if message.place else "the PAM"
    return f"{message.number} {reports}, {_WORDS[message.reception]} at {noticed}{late}"


def span_bytes(frames: Sequence[Frame]) -> int:
    """Number of bytes that frames or reports take on the fibre: target, length, contents, and 16 bits of CRC."""
    lengths = [len(contents) for _, contents in frames]
    return sum(lengths) + len(frames) * (_FRAME.size + CRC_BYTES)
