"""The classic capture files of tcpdump, dumpcap and Wireshark: both byte orders, microseconds and nanoseconds.

Source: draft-ietf-opsawg-pcap.  A file has one link type, so one that is written has the messages of the first bus
family that comes: CAN frames of SocketCAN, or Modbus messages as TCP/IP packets (`modbus_packet`); others are left out.
It has neither the names of buses nor senders; pcapng has both.
"""

import struct
from collections.abc import Callable, Iterable, Iterator
from typing import BinaryIO, Final

from fieldrig.clock import S
from fieldrig.errors import UsageError
from fieldrig.traces.limits import from_1970
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.linux_flags import BIT_RATE_SWITCH
from fieldrig_bus.modbus import codec as modbus_codec
from fieldrig_bus.traces.can_fields import fields_of
from fieldrig_bus.traces.ip_packets import IPV4
from fieldrig_bus.traces.modbus_packet import PacketMaker
from fieldrig_bus.traces.packets import CAN, CAN_SOCKETCAN, FD, RTAC_SERIAL, USER0, USER15, Link, PacketReader

SUFFIXES = (".pcap", ".cap")
FAMILIES = frozenset({"can", "modbus"})
REMEDY: Final = "expected a capture of tcpdump, Wireshark or `fieldrig trace`"
LARGEST: Final = 1 << 18
"""Bytes of a packet, at most: MAXIMUM_SNAPLEN of libpcap."""
_MODIFIED: Final = 0xA1B2CD34
"""The first word of a file of a patched libpcap, whose packets have 8 bytes more in their heads."""
_MAGIC: Final = {0xA1B2C3D4: 1000, 0xA1B23C4D: 1, _MODIFIED: 1000}
"""The first word of a file, and its unit of time in nanoseconds."""
_HEAD_SIZE, _PACKET_SIZE = 24, 16
_LAST_S: Final = 0xFFFF_FFFF
_ZEROS: Final = bytes(_PACKET_SIZE)
_MOST_ZEROS: Final = 1_000
"""Empty packets at instant 0 in a row, which are no packets: room on a disk that was never written."""
_LARGEST_WRITTEN: Final = 65_535


def recognises(head: bytes) -> bool:
    return len(head) >= 4 and any(int.from_bytes(head[:4], order) in _MAGIC for order in ("little", "big"))


def read(file: BinaryIO, odd: Oddities | None = None) -> Iterator[TraceEntry]:
    """Yield the entries.  A cut end is odd; UsageError, with the place, for a damaged file."""
    odd = Oddities() if odd is None else odd
    order, unit_ns, link_type, further = _head(file.read(_HEAD_SIZE))
    link, reader = Link(link_type, _bus_of(link_type)), PacketReader(odd)
    odd.unit, odd.number = "packet", 0
    at, unpack, zeros = _HEAD_SIZE, struct.Struct(f"{order}IIII").unpack, 0
    while head := file.read(_PACKET_SIZE):
        odd.number += 1
        zeros = zeros + 1 if head == _ZEROS else 0
        if zeros > _MOST_ZEROS:
            odd.report("the rest of the file is zeros", f", from byte {at - _MOST_ZEROS * _PACKET_SIZE} on")
            break
        seconds, rest, captured, _ = unpack(head) if len(head) == _PACKET_SIZE else (0, 0, 0, 0)
        if captured > LARGEST:
            raise UsageError(f"packet {odd.number} at byte {at} claims to have {captured} bytes", REMEDY)
        packet = file.read(further + captured)[further:]
        if len(head) < _PACKET_SIZE or len(packet) < captured:
            odd.report("the file is cut off", f", at byte {at}")
            break
        yield from reader.take(link, seconds * S + rest * unit_ns, packet)
        at += _PACKET_SIZE + further + captured
    yield from reader.end()


def _head(head: bytes) -> tuple[str, int, int, int]:
    """Return the byte order, the unit of time, the link type, and the further bytes in the head of a packet."""
    if len(head) == _HEAD_SIZE:
        for order in "<>":
            magic, link_type = struct.unpack(f"{order}I16xI", head)
            if magic in _MAGIC:
                return order, _MAGIC[magic], link_type & 0x0FFF_FFFF, 8 if magic == _MODIFIED else 0
    raise UsageError("the file is empty" if not head else "the file does not begin with the head of a capture", REMEDY)


def _bus_of(link_type: int) -> str:
    if link_type == CAN_SOCKETCAN:
        return "can0"
    return "serial" if link_type == RTAC_SERIAL or USER0 <= link_type <= USER15 else "modbus"


def write(entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int, odd: Oddities | None = None) -> int:
    """Write entries; `start_unix_ns` is the time of day at their instant 0.  Returns the number of messages."""
    odd = Oddities() if odd is None else odd
    family, buses, written = "", dict[str, Callable[[TraceEntry], bytes | None]](), 0
    for entry in entries:
        if not family and entry.family in FAMILIES:
            family = entry.family
            file.write(_file_head(CAN_SOCKETCAN if family == "can" else IPV4))
        if entry.family != family:
            continue
        if entry.bus not in buses:
            if buses:
                odd.report("the format has no buses, so their messages are not kept apart")
            buses[entry.bus] = can_packet if family == "can" else _modbus_packets(len(buses))
        packet = buses[entry.bus](entry)
        if packet is not None:
            seconds, rest_ns = divmod(from_1970(start_unix_ns + entry.time_ns, odd), S)
            if seconds > _LAST_S:
                odd.report("times beyond 2106 become its last second, as the format has no later")
            file.write(struct.pack("<IIII", min(seconds, _LAST_S), rest_ns, len(packet), len(packet)) + packet)
            written += 1
    if not family:
        file.write(_file_head(CAN_SOCKETCAN))
    return written


def _file_head(link_type: int) -> bytes:
    return struct.pack("<IHHIIII", 0xA1B23C4D, 2, 4, 0, 0, _LARGEST_WRITTEN, link_type)


def can_packet(entry: TraceEntry) -> bytes | None:
    """Return a CAN message as a packet of SocketCAN; None for a notice that it does not have."""
    fields = fields_of(entry.data)
    if fields is None:
        return None
    word, data, length, is_fd, is_switched = fields
    return CAN.pack(word, length, is_fd * FD | is_switched * BIT_RATE_SWITCH) + data


def _modbus_packets(bus_number: int) -> Callable[[TraceEntry], bytes | None]:
    maker = PacketMaker(bus_number)

    def packet(entry: TraceEntry) -> bytes | None:
        try:
            return maker.make(entry.sender, modbus_codec.decode(entry.data))
        except ValueError:  # bytes of a file that are no message
            return None

    return packet
