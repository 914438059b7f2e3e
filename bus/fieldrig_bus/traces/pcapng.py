"""The format pcapng of Wireshark and tshark, for every family.

There is one interface per bus, with its name.  CAN frames are those of SocketCAN (LINKTYPE_CAN_SOCKETCAN); errors and
states are its error frames, and an injected fault is an error frame without a class and with a comment.  Modbus
messages are TCP/IP packets (`modbus_packet`).  All others have a small head with their family, before the bytes of
`Bus.encode` (LINKTYPE_USER0); the dissector beside this file shows them in Wireshark (`dissector.lua`).  A serial line
that carries PPP has a second interface with its frames (LINKTYPE_PPP), which is not read back.  The comment of a packet
is its sender; a second comment has the bytes of the message where the packet does not contain them.

Time stamps are the time of day.  The comment of the section has instant 0, so that files of `fieldrig` are read as they
were written.  In foreign captures `packets` finds the messages, with the time of day as their instant.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from typing import BinaryIO, Final

from fieldrig.faults.note import FaultNote
from fieldrig.traces.limits import from_1970
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can import codec as can_codec
from fieldrig_bus.can.linux_flags import ERROR
from fieldrig_bus.can.socketcan_errors import LENGTH
from fieldrig_bus.modbus import codec as modbus_codec
from fieldrig_bus.traces import pcapng_blocks as blocks
from fieldrig_bus.traces.ip_packets import IPV4, PPP
from fieldrig_bus.traces.modbus_packet import PacketMaker, messages_in
from fieldrig_bus.traces.packets import CAN, CAN_SOCKETCAN, USER0, Link, PacketReader, can_message
from fieldrig_bus.traces.pcap import can_packet
from fieldrig_bus.traces.ppp_frames import PppFinder

SUFFIXES = (".pcapng", ".ntar")
FAMILIES: frozenset[str] = frozenset()  # all
_LINK_TYPES: Final = {"can": CAN_SOCKETCAN, "modbus": IPV4}

SERIAL_DATA: Final = b"\0"
"""The first byte of a serial message that is data."""
_Packer = Callable[[TraceEntry], tuple[bytes, list[str]]]
"""Returns the packet of an entry, and its comments."""

_INSTANT_0 = re.compile(r"fieldrig: instant 0 is (\d+) ns")
_MESSAGE = re.compile(r"fieldrig: message ((?:[0-9a-f]{2})*)")
_HEAD: Final = b"fieldrig\x01"
"""The head of a message without a standard format, before the length of its family in a byte, and the family."""


def recognises(head: bytes) -> bool:
    return head.startswith(b"\x0a\x0d\x0d\x0a")


def write(entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int, odd: Oddities | None = None) -> int:
    """Write entries; `start_unix_ns` is the time of day at their instant 0.  Returns the number of entries."""
    output = _Output(file, start_unix_ns, Oddities() if odd is None else odd)
    packers: dict[str, tuple[int, _Packer]] = {}
    finders: dict[str, PppFinder] = {}
    written = 0
    for entry in entries:
        known = packers.get(entry.bus)
        if known is None:
            number = output.interface(entry.bus, entry.family, _LINK_TYPES.get(entry.family, USER0))
            known = packers[entry.bus] = number, _packer(entry.family, number)
        number, packer = known
        output.write(number, entry.time_ns, *packer(entry))
        written += 1
        if entry.family == "serial" and entry.data[:1] == SERIAL_DATA:
            for frame in finders.setdefault(entry.bus, PppFinder()).feed(entry.sender, entry.data[1:]):
                ppp = output.interface(f"{entry.bus} PPP", "ppp", PPP)
                output.write(ppp, entry.time_ns, frame, [entry.sender])
    return written


class _Output:
    """A file with one section, and its interfaces by name."""

    def __init__(self, file: BinaryIO, start_unix_ns: int, odd: Oddities) -> None:
        self._file, self._start_unix_ns, self._odd = file, start_unix_ns, odd
        self._numbers: dict[str, int] = {}
        file.write(blocks.section(f"fieldrig: instant 0 is {start_unix_ns} ns", "fieldrig"))

    def interface(self, name: str, about: str, link_type: int) -> int:
        """Return the number of an interface, which is added if there is none of this name."""
        if name not in self._numbers:
            self._file.write(blocks.interface(link_type, name, about))
            self._numbers[name] = len(self._numbers)
        return self._numbers[name]

    def write(self, interface: int, time_ns: int, packet: bytes, comments: list[str]) -> None:
        now_ns = from_1970(self._start_unix_ns + time_ns, self._odd)
        self._file.write(blocks.packet(interface, now_ns, packet, comments))


def _packer(family: str, number: int) -> _Packer:
    if family == "can":
        return _can_packet
    if family == "modbus":
        maker = PacketMaker(number)
        return lambda entry: _modbus_packet(maker, entry)
    head = _HEAD + bytes((len(family.encode()),)) + family.encode()
    return lambda entry: (head + entry.data, [entry.sender])


def _can_packet(entry: TraceEntry) -> tuple[bytes, list[str]]:
    packet = can_packet(entry)
    if packet is not None and not packet[0] & ERROR >> 24:
        return packet, [entry.sender]
    try:
        shown = can_codec.show(can_codec.decode(entry.data))
    except ValueError as wrong:
        shown = f"{wrong}"
    comments = [entry.sender, f"fieldrig: message {entry.data.hex()}", shown]
    return packet or CAN.pack(ERROR, LENGTH, 0) + bytes(LENGTH), comments


def _modbus_packet(maker: PacketMaker, entry: TraceEntry) -> tuple[bytes, list[str]]:
    try:
        packet = maker.make(entry.sender, modbus_codec.decode(entry.data))
    except ValueError:  # bytes of a file that are no message
        packet = maker.make(entry.sender, FaultNote(0, ""))
    is_plain = [modbus_codec.encode(message) for _, message in messages_in(packet)] == [entry.data]
    return packet, [entry.sender] if is_plain else [entry.sender, f"fieldrig: message {entry.data.hex()}"]


def read(file: BinaryIO, odd: Oddities | None = None) -> Iterator[TraceEntry]:
    """Yield the entries.  A cut end is odd; UsageError, with the place, for a file that is damaged or not pcapng."""
    odd = Oddities() if odd is None else odd
    start_unix_ns, reader = None, PacketReader(odd)
    for block in blocks.blocks(file, odd):
        if isinstance(block, blocks.Section):
            match = _INSTANT_0.fullmatch(block.comment)
            start_unix_ns = int(match[1]) if match else None
        elif start_unix_ns is None:
            link = Link(block.interface.link_type, block.interface.name)
            yield from reader.take(link, block.time_ns, block.data)
        else:
            yield from _own(block, start_unix_ns, odd)
    yield from reader.end()


def _own(packet: blocks.Packet, start_unix_ns: int, odd: Oddities) -> Iterator[TraceEntry]:
    """Yield the message of a packet that `write` has written."""
    (_, link_type, bus, family, _, _), _, data, _, comments = packet
    time_ns, sender = packet.time_ns - start_unix_ns, comments[0] if comments else ""
    match = next(filter(None, map(_MESSAGE.fullmatch, comments[1:])), None)
    if match is not None:
        yield TraceEntry(time_ns, bus, family, sender, bytes.fromhex(match[1]))
    elif link_type == CAN_SOCKETCAN:
        message = can_message(data)
        if message is not None:
            yield TraceEntry(time_ns, bus, "can", sender, message)
    elif link_type == USER0:
        named, message = _without_head(data)
        yield TraceEntry(time_ns, bus, named or family, sender, message)
    elif link_type == IPV4:
        for address, modbus in messages_in(data):
            yield TraceEntry(time_ns, bus, "modbus", sender if comments else address, modbus_codec.encode(modbus))
    elif link_type != PPP:
        odd.report("packets of link types that are not known are left out", f", of type {link_type}")


def _without_head(data: bytes) -> tuple[str, bytes]:
    """Return the family and the message; a file of an older version has no head, and no family there."""
    at = len(_HEAD)
    if not data.startswith(_HEAD) or len(data) <= at or len(data) <= at + data[at]:
        return "", data
    end = at + 1 + data[at]
    return data[at + 1 : end].decode("utf-8", "replace"), data[end:]
