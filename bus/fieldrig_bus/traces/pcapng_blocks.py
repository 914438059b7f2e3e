"""The blocks of a pcapng file (draft-ietf-opsawg-pcapng), one by one, in bounded memory.

They are read and written here: python-pcapng takes 27 us to read a packet and 47 to write one, a twentieth of which is
enough, and allocates what a length says.  Left out: blocks with names, statistics and secrets.
"""

import struct
from collections.abc import Iterable, Iterator, Mapping
from typing import BinaryIO, Final, NamedTuple

from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities

SECTION: Final = 0x0A0D0D0A
INTERFACE, OLD_PACKET, SIMPLE_PACKET, PACKET = 1, 2, 3, 6
BYTE_ORDER: Final = 0x1A2B3C4D
LARGEST: Final = 1 << 24
"""Bytes of a block, at most; a packet has below 262,144."""
MOST_INTERFACES: Final = 10_000
REMEDY: Final = "write traces with `fieldrig trace`, captures with Wireshark or dumpcap"
WRONG: Final = "the file is damaged, or not a pcapng file"

COMMENT = 1  # in all blocks
APPLICATION = 4  # in a section
NAME, DESCRIPTION, RESOLUTION, OFFSET = 2, 3, 9, 14  # in an interface


class Interface(NamedTuple):
    number: int
    link_type: int
    name: str
    about: str
    """Its description."""
    ticks_per_s: int
    offset_s: int


class Packet(NamedTuple):
    interface: Interface
    time_ns: int
    data: bytes
    length: int
    """Bytes of the packet on the line, of which `data` may be only the first."""
    comments: list[str]


class Section(NamedTuple):
    comment: str


def blocks(file: BinaryIO, odd: Oddities) -> Iterator[Section | Packet]:
    """Yield sections and packets.  A cut end is odd; UsageError, with the place, for a damaged file."""
    odd.unit, odd.number = "packet", 0
    order, interfaces, at, time_ns = "<", list[Interface](), 0, 0
    while head := file.read(8):
        if len(head) == 8 and head[:4] == b"\x0a\x0d\x0d\x0a":
            mark = file.read(4)
            order = _order(mark, at)
            head_more = mark
        else:
            head_more = b""
            if at == 0:
                raise UsageError(WRONG, REMEDY)
        if len(head) < 8:
            break
        kind, length = struct.unpack(f"{order}II", head)
        if length < 12 or length % 4 or length > LARGEST:
            raise UsageError(f"{WRONG}: the block at byte {at} claims to have {length} bytes", REMEDY)
        body = head_more + file.read(length - 8 - len(head_more))
        if len(body) < length - 8:
            break
        if struct.unpack(f"{order}I", body[-4:])[0] != length:
            raise UsageError(f"{WRONG}: the block at byte {at} ends with another length than it begins with", REMEDY)
        body = body[:-4]
        try:
            if kind == SECTION:
                interfaces = []
                yield Section(_texts(_options(body, 16, order).get(COMMENT)))
            elif kind == INTERFACE:
                if len(interfaces) >= MOST_INTERFACES:
                    raise ValueError(f"more than {MOST_INTERFACES} interfaces")
                interfaces.append(_interface(len(interfaces), body, order))
            elif kind in _PACKETS:
                odd.number += 1
                packet = _PACKETS[kind](body, order, interfaces, time_ns)
                time_ns = packet.time_ns
                yield packet
        except (struct.error, ValueError, IndexError) as wrong:
            raise UsageError(f"{WRONG}: the block at byte {at}: {wrong}", REMEDY) from wrong
        at += length
    else:
        if at == 0:
            raise UsageError(f"{WRONG}: it is empty", REMEDY)
        return
    if at == 0:
        raise UsageError(WRONG, REMEDY)
    odd.report("the file is cut off", f", at byte {at}")


def _order(mark: bytes, at: int) -> str:
    for order in "<>":
        if mark == struct.pack(f"{order}I", BYTE_ORDER):
            return order
    raise UsageError(f"{WRONG}: the section at byte {at} has no byte order", REMEDY)


def _options(body: bytes, at: int, order: str) -> dict[int, list[bytes]]:
    """Return the options from a place on, by their code."""
    found: dict[int, list[bytes]] = {}
    while at + 4 <= len(body):
        code, size = struct.unpack_from(f"{order}HH", body, at)
        if code == 0:
            break
        if at + 4 + size > len(body):
            raise ValueError(f"an option claims to have {size} bytes")
        found.setdefault(code, []).append(body[at + 4 : at + 4 + size])
        at += 4 + (size + 3) // 4 * 4
    return found


def _texts(values: list[bytes] | None) -> str:
    return values[0].decode("utf-8", "replace").rstrip("\0") if values else ""


def _interface(number: int, body: bytes, order: str) -> Interface:
    (link_type,) = struct.unpack_from(f"{order}H", body)
    options = _options(body, 8, order)
    resolution = options.get(RESOLUTION, [b"\x06"])[0][0]
    offset = options.get(OFFSET)
    offset_s = struct.unpack(f"{order}q", offset[0])[0] if offset else 0
    ticks = 2 ** (resolution & 0x7F) if resolution & 0x80 else 10**resolution
    name = _texts(options.get(NAME)) or f"interface{number}"
    return Interface(number, link_type, name, _texts(options.get(DESCRIPTION)), ticks, offset_s)


def _enhanced(body: bytes, order: str, interfaces: list[Interface], time_ns: int) -> Packet:
    number, high, low, captured, length = struct.unpack_from(f"{order}IIIII", body)
    return _packet(body, 20, order, _of(interfaces, number), (high << 32 | low), captured, length)


def _old(body: bytes, order: str, interfaces: list[Interface], time_ns: int) -> Packet:
    number, _, high, low, captured, length = struct.unpack_from(f"{order}HHIIII", body)
    return _packet(body, 20, order, _of(interfaces, number), (high << 32 | low), captured, length)


def _packet(body: bytes, at: int, order: str, interface: Interface, ticks: int, captured: int, length: int) -> Packet:
    if at + captured > len(body):
        raise ValueError(f"a packet claims to have {captured} bytes")
    time_ns = ticks * 1_000_000_000 // interface.ticks_per_s + interface.offset_s * 1_000_000_000
    end = at + (captured + 3) // 4 * 4
    comments = _options(body, end, order).get(COMMENT, ()) if len(body) > end else ()
    texts = [comment.decode("utf-8", "replace") for comment in comments]
    return Packet(interface, time_ns, body[at : at + captured], length, texts)


def _of(interfaces: list[Interface], number: int) -> Interface:
    """Return an interface.  ValueError for one that the section does not describe before."""
    if number >= len(interfaces):
        raise ValueError(f"a packet of interface {number}, of which there are {len(interfaces)}")
    return interfaces[number]


def _simple(body: bytes, order: str, interfaces: list[Interface], time_ns: int) -> Packet:
    """A packet of the first interface.  The block is without a time, so it has that of the packet before it."""
    (length,) = struct.unpack_from(f"{order}I", body)
    return Packet(_of(interfaces, 0), time_ns, body[4 : 4 + length], length, [])


_PACKETS: Final = {PACKET: _enhanced, OLD_PACKET: _old, SIMPLE_PACKET: _simple}


# ---- writing


def section(comment: str, application: str) -> bytes:
    head = struct.pack("<IHHq", BYTE_ORDER, 1, 0, -1)
    return _block(SECTION, head, {COMMENT: [comment.encode()], APPLICATION: [application.encode()]})


def interface(link_type: int, name: str, about: str) -> bytes:
    """Return an interface whose times are in nanoseconds."""
    options = {NAME: [name.encode()], DESCRIPTION: [about.encode()], RESOLUTION: [b"\x09"]}
    return _block(INTERFACE, struct.pack("<HHI", link_type, 0, 0), options)


def packet(number: int, time_ns: int, data: bytes, comments: Iterable[str]) -> bytes:
    """Return a packet of an interface; a comment has at most 65,535 bytes."""
    size = len(data)
    head = struct.pack("<IIIII", number, time_ns >> 32 & 0xFFFF_FFFF, time_ns & 0xFFFF_FFFF, size, size)
    padded = data + bytes(-size % 4)
    return _block(PACKET, head + padded, {COMMENT: [comment.encode()[:0xFFFF] for comment in comments]})


def _block(kind: int, body: bytes, options: Mapping[int, list[bytes]]) -> bytes:
    for code, values in options.items():
        for value in values:
            body += struct.pack("<HH", code, len(value)) + value + bytes(-len(value) % 4)
    body += bytes(4)  # the end of the options
    length = 12 + len(body)
    return struct.pack("<II", kind, length) + body + struct.pack("<I", length)
