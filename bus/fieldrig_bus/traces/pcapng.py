"""The format pcapng of Wireshark and tshark, for every family, by python-pcapng.

There is one interface per bus, with its name.  CAN frames are those of SocketCAN (LINKTYPE_CAN_SOCKETCAN); errors and
states are its error frames, and an injected fault is an error frame without a class and with a comment.  Modbus
messages are TCP/IP packets (`modbus_packet`), and all others are the bytes of `Bus.encode` (LINKTYPE_USER0).  A serial
line that carries PPP has a second interface with its frames (LINKTYPE_PPP), which is not read back.  The
comment of a packet is its sender; a second comment has the bytes of the message where the packet does not contain them.
Time stamps are the time of day.  The comment of the section has instant 0, so that files of `fieldrig` are read as they
were written.  In foreign captures CAN and Modbus TCP are read, with the time of day as their instant.
"""

import re
import struct
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, BinaryIO

from pcapng import blocks, scanner, writer
from pcapng.exceptions import PcapngException

from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can import codec as can_codec
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.linux_flags import BIT_RATE_SWITCH, ERROR
from fieldrig_bus.can.notices import BusState, CanError
from fieldrig_bus.can.socketcan_errors import LENGTH, error_frame
from fieldrig_bus.modbus import codec as modbus_codec
from fieldrig_bus.serial import codec as serial_codec
from fieldrig_bus.traces.modbus_packet import PacketMaker, messages_in
from fieldrig_bus.traces.ppp_frames import PppFinder

SUFFIXES = (".pcapng",)
FAMILIES: frozenset[str] = frozenset()  # all

# tcpdump.org/linktypes.html
ETHERNET, PPP, RAW_IP, USER0, CAN_SOCKETCAN, IPV4 = 1, 9, 101, 147, 227, 228
_LINK_TYPES = {"can": CAN_SOCKETCAN, "modbus": IPV4}

# python-pcapng has no annotations
SectionHeader: Any = blocks.SectionHeader
InterfaceDescription: Any = blocks.InterfaceDescription
EnhancedPacket: Any = blocks.EnhancedPacket
FileWriter: Any = writer.FileWriter
FileScanner: Any = scanner.FileScanner

_Packer = Callable[[TraceEntry], tuple[bytes, list[str]]]
"""Returns the packet of an entry, and its comments."""

_CAN = struct.Struct("!IBBxx")  # identifier with flags, length, flags of an FD frame
_FD = 0x04  # CANFD_FDF
_FD_MTU = 72  # bytes of every FD frame from Linux, also where the flag is not set

_INSTANT_0 = re.compile(r"fieldrig: instant 0 is (\d+) ns")
_MESSAGE = re.compile(r"fieldrig: message ([0-9a-f]*)")


def write(entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int, odd: Oddities | None = None) -> int:
    """Write entries; `start_unix_ns` is the time of day at their instant 0.  Returns the number of entries."""
    output = _Output(file, start_unix_ns)
    packers: dict[str, _Packer] = {}
    finders: dict[str, PppFinder] = {}
    written = 0
    for entry in entries:
        number = output.interface(entry.bus, entry.family, _LINK_TYPES.get(entry.family, USER0))
        if entry.bus not in packers:
            packers[entry.bus] = _packer(entry.family, number)
        output.write(number, entry.time_ns, *packers[entry.bus](entry))
        written += 1
        if entry.family == "serial" and isinstance(data := serial_codec.decode(entry.data), bytes):
            for frame in finders.setdefault(entry.bus, PppFinder()).feed(entry.sender, data):
                ppp = output.interface(f"{entry.bus} PPP", "ppp", PPP)
                output.write(ppp, entry.time_ns, frame, [entry.sender])
    return written


class _Output:
    """A file with one section, and its interfaces by name."""

    def __init__(self, file: BinaryIO, start_unix_ns: int) -> None:
        self._start_unix_ns = start_unix_ns
        self._section = SectionHeader(
            options={"opt_comment": f"fieldrig: instant 0 is {start_unix_ns} ns", "shb_userappl": "fieldrig"}
        )
        self._file = FileWriter(file, self._section)
        self._numbers: dict[str, int] = {}

    def interface(self, name: str, about: str, link_type: int) -> int:
        """Return the number of an interface, which is added if there is none of this name."""
        if name not in self._numbers:
            options = {"if_name": name, "if_description": about, "if_tsresol": b"\x09"}
            with _unwarned():
                self._file.write_block(
                    self._section.new_member(InterfaceDescription, link_type=link_type, options=options)
                )
            self._numbers[name] = len(self._numbers)
        return self._numbers[name]

    def write(self, interface: int, time_ns: int, packet: bytes, comments: list[str]) -> None:
        ticks = self._start_unix_ns + time_ns
        block = self._section.new_member(
            EnhancedPacket,
            interface_id=interface,
            timestamp_high=ticks >> 32,
            timestamp_low=ticks & 0xFFFF_FFFF,
            packet_data=packet,
            options={"opt_comment": comments},
        )
        self._file.write_block(block)


def recognises(head: bytes) -> bool:
    return head.startswith(b"\x0a\x0d\x0d\x0a")


def read(file: BinaryIO, odd: Oddities | None = None) -> Iterator[TraceEntry]:
    """Entries of a file.  UsageError for a file that is damaged or not pcapng, after everything that could be read."""
    start_unix_ns = 0
    try:
        for block in _blocks(file):
            if isinstance(block, SectionHeader):
                start_unix_ns = _instant_0(block)
            elif isinstance(block, EnhancedPacket):
                yield from _entries(block, start_unix_ns)
    except (
        PcapngException,
        ValueError,
        LookupError,
        TypeError,
        struct.error,
    ) as cause:  # raised by the scanner for invalid bytes
        what = f"the file is damaged, or not a pcapng file: {cause}"
        raise UsageError(what, "write traces with `fieldrig trace`, captures with Wireshark or dumpcap") from cause


def _blocks(file: BinaryIO) -> Iterator[Any]:
    blocks = iter(FileScanner(file))
    while True:
        with _unwarned():
            try:
                block = next(blocks, None)
            except OSError as cause:
                if cause.errno is None:  # raised by the scanner, for an address option that is too short
                    raise ValueError(f"{cause}") from cause
                raise
        if block is None:
            return
        yield block


@contextmanager
def _unwarned() -> Iterator[None]:
    """Silence python-pcapng, which warns of a type in its own table (if_tsresol) and of oddities in readable files."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def _packer(family: str, number: int) -> _Packer:
    if family == "can":
        return _can_packet
    if family == "modbus":
        maker = PacketMaker(number)
        return lambda entry: _modbus_packet(maker, entry)
    return lambda entry: (entry.data, [entry.sender])


def _can_packet(entry: TraceEntry) -> tuple[bytes, list[str]]:
    message = can_codec.decode(entry.data)
    if isinstance(message, CanFrame):
        word = message.identifier | message.is_extended * EXTENDED | message.is_remote * REMOTE
        flags = message.is_fd * _FD | message.is_bit_rate_switched * BIT_RATE_SWITCH
        length = message.remote_length if message.is_remote else len(message.data)
        return _CAN.pack(word, length, flags) + message.data, [entry.sender]
    error_class, data = error_frame(message) if isinstance(message, CanError | BusState) else (0, bytes(LENGTH))
    packet = _CAN.pack(error_class | ERROR, len(data), 0) + data
    return packet, [entry.sender, f"fieldrig: message {entry.data.hex()}", can_codec.show(message)]


def _modbus_packet(maker: PacketMaker, entry: TraceEntry) -> tuple[bytes, list[str]]:
    packet = maker.make(entry.sender, modbus_codec.decode(entry.data))
    is_plain = [modbus_codec.encode(message) for _, message in messages_in(packet)] == [entry.data]
    return packet, [entry.sender] if is_plain else [entry.sender, f"fieldrig: message {entry.data.hex()}"]


def _instant_0(section: Any) -> int:
    match = _INSTANT_0.fullmatch(section.options.get("opt_comment", ""))
    return int(match[1]) if match else 0


def _entries(block: Any, start_unix_ns: int) -> Iterator[TraceEntry]:
    options, packet = block.interface.options, block.packet_data
    bus = options.get("if_name", f"interface{block.interface_id}")
    time_ns = _time_ns(block, options.get("if_tsresol", b"\x06")) - start_unix_ns
    comments = block.options.get_all("opt_comment") if "opt_comment" in block.options else []
    sender = comments[0] if comments else ""
    message = next((match[1] for comment in comments[1:] if (match := _MESSAGE.fullmatch(comment))), None)
    link_type = block.interface.link_type
    if message is not None:
        yield TraceEntry(time_ns, bus, options.get("if_description", ""), sender, bytes.fromhex(message))
    elif link_type == CAN_SOCKETCAN:
        frame = _can_frame(packet)
        if frame is not None:
            yield TraceEntry(time_ns, bus, "can", sender, can_codec.encode(frame))
    elif link_type == USER0:
        yield TraceEntry(time_ns, bus, options.get("if_description", ""), sender, packet)
    elif link_type in (IPV4, RAW_IP, ETHERNET):
        for address, modbus in messages_in(packet[14:] if link_type == ETHERNET else packet):
            yield TraceEntry(time_ns, bus, "modbus", sender or address, modbus_codec.encode(modbus))


def _can_frame(packet: bytes) -> CanFrame | None:
    """The frame in a packet; None for an error frame, and for a frame that no bus carries."""
    if len(packet) < _CAN.size:
        return None
    word, length, flags = _CAN.unpack_from(packet)
    is_remote = bool(word & REMOTE)
    if word & ERROR or not (is_remote or len(packet) >= _CAN.size + length):
        return None
    is_fd = bool(flags & _FD) or len(packet) == _FD_MTU
    try:
        return CanFrame(
            word & 0x1FFF_FFFF,
            b"" if is_remote else packet[_CAN.size : _CAN.size + length],
            is_extended=bool(word & EXTENDED),
            is_remote=is_remote,
            remote_length=length if is_remote else 0,
            is_fd=is_fd,
            is_bit_rate_switched=is_fd and bool(flags & BIT_RATE_SWITCH),
        )
    except ValueError:
        return None


def _time_ns(block: Any, resolution: bytes) -> int:
    """Ticks per second by `if_tsresol`: a power of ten, or with the top bit a power of two (pcapng, 4.2)."""
    ticks: int = block.timestamp_high << 32 | block.timestamp_low
    power = resolution[0]
    per_second: int = 2 ** (power & 0x7F) if power & 0x80 else 10**power
    return ticks * 1_000_000_000 // per_second
