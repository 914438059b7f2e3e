"""The messages in the packets of captures, by the link type: CAN, Modbus TCP, serial lines and PPP.

Link types are those of tcpdump.org/linktypes.html.

| link type | messages |
|---|---|
| CAN_SOCKETCAN, and CAN in LINUX_SLL and LINUX_SLL2 | CAN frames, errors and states |
| Ethernet, with VLAN tags, LINUX_SLL, NULL, RAW, PPP, ... | Modbus TCP, by `tcp_streams` |
| RTAC_SERIAL | the bytes of a serial line, by their direction |
| PPP, PPP_HDLC, PPP_WITH_DIR | frames of PPP without Modbus, as the bytes of a serial line (RFC 1662) |
| USER0 to USER15 | the bytes of a serial line, as most tools use them |

What is in none of them is left out and counted.
"""

import struct
from binascii import crc_hqx
from collections.abc import Iterator
from typing import Final, NamedTuple

from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.linux_flags import BIT_RATE_SWITCH
from fieldrig_bus.modbus import codec as modbus_codec
from fieldrig_bus.serial import codec as serial_codec
from fieldrig_bus.serial.message import Break
from fieldrig_bus.traces import ip_packets
from fieldrig_bus.traces.can_fields import message_of, plain_message
from fieldrig_bus.traces.ip_packets import PPP, PPP_HDLC, PPP_WITH_DIRECTION, SLL, SLL2
from fieldrig_bus.traces.ppp_frames import BITS_REVERSED
from fieldrig_bus.traces.tcp_streams import TcpStreams

USER0, USER15, CAN_SOCKETCAN, RTAC_SERIAL = 147, 162, 227, 250
CAN: Final = struct.Struct("!IBBxx")
"""Identifier with flags, length, flags of an FD frame."""
FD: Final = 0x04
"""CANFD_FDF."""
_FD_MTU: Final = 72
"""Bytes of every FD frame from Linux, also where the flag is not set."""
_HIGHEST: Final = 0x1FFF_FFFF
_LINUX_CAN: Final = frozenset({0x000C, 0x000D})
"""LINUX_SLL_P_CAN and LINUX_SLL_P_CANFD."""
_RTAC: Final = struct.Struct("!IIBBH")
"""Time in seconds and microseconds, event, states of the lines, footer."""
_RTAC_SENDERS: Final = {1: "tx", 2: "rx", 3: "tx", 4: "rx"}
_RTAC_BREAK: Final = 9
_NO_BREAK_TIME_MS: Final = 0
_ESCAPED: Final = [
    bytes((0x7D, byte ^ 0x20)) if byte < 0x20 or byte in b"\x7d\x7e" else bytes((byte,)) for byte in range(256)
]
MOST_BUSES: Final = 255
"""Interfaces of a cooked capture that have a bus of their own."""
PPP_LINE: Final = "-ppp"
"""The end of the name of the line below a network of PPP, because a bus has messages of one family."""
LEFT_OUT: Final = "packets without messages of a bus that is known are left out"


class Link(NamedTuple):
    """The interface of a capture: its link type, and the name of its bus."""

    link_type: int
    bus: str


class PacketReader:
    """The messages of one capture, whose packets are given in their order."""

    def __init__(self, odd: Oddities) -> None:
        self._odd = odd
        self._streams: dict[str, TcpStreams] = {}
        self._last_ns: dict[str, int] = {}
        self._cooked: dict[int, str] = {}
        """The buses of cooked captures by the numbers of their interfaces."""

    def take(self, link: Link, time_ns: int, packet: bytes) -> Iterator[TraceEntry]:
        """Yield the messages that are complete with a packet."""
        link_type, bus = link
        if link_type == CAN_SOCKETCAN:
            yield from self._can(bus, time_ns, packet)
        elif link_type in (SLL, SLL2) and _protocol(link_type, packet) in _LINUX_CAN:
            yield from self._can(self._cooked_bus(link_type, packet), time_ns, packet[16 if link_type == SLL else 20 :])
        elif link_type == RTAC_SERIAL:
            yield from self._rtac(bus, time_ns, packet)
        elif USER0 <= link_type <= USER15:
            yield TraceEntry(time_ns, bus, "serial", "", b"\0" + packet)
        elif link_type in ip_packets.IP_OF:
            yield from self._ip(link, time_ns, packet)
        else:
            self._odd.report("packets of link types that are not known are left out", f", of type {link_type}")

    def end(self) -> Iterator[TraceEntry]:
        """Yield what waits for TCP segments that never came."""
        for bus, streams in self._streams.items():
            for sender, message in streams.end():
                yield TraceEntry(self._last_ns[bus], bus, "modbus", sender, modbus_codec.encode(message))

    def _can(self, bus: str, time_ns: int, packet: bytes) -> Iterator[TraceEntry]:
        message = can_message(packet)
        if message is None:
            self._odd.report("CAN packets that are no frame, error or state are left out")
        else:
            yield TraceEntry(time_ns, bus, "can", "", message)

    def _cooked_bus(self, link_type: int, packet: bytes) -> str:
        """Return the bus of a cooked capture, which is of many interfaces and has, in version 2, their numbers."""
        index = int.from_bytes(packet[4:8], "big") if link_type == SLL2 else 0
        bus = self._cooked.get(index)
        if bus is None:
            bus = f"can{len(self._cooked)}"
            if len(self._cooked) < MOST_BUSES:
                self._cooked[index] = bus
                if index:
                    self._odd.report("interfaces of a cooked capture have only numbers", f": {bus} is {index}")
        return bus

    def _ip(self, link: Link, time_ns: int, packet: bytes) -> Iterator[TraceEntry]:
        ip = ip_packets.IP_OF[link.link_type](packet)
        segment = None if ip is None else ip_packets.segment_of(ip)
        bus = link.bus
        if segment is None:
            if link.link_type in (PPP, PPP_HDLC, PPP_WITH_DIRECTION):
                yield _ppp_entry(link, time_ns, packet)
            else:
                self._odd.report(LEFT_OUT)
            return
        self._last_ns[bus] = time_ns
        streams = self._streams.get(bus)
        if streams is None:
            streams = self._streams[bus] = TcpStreams(self._odd)
        for sender, message in streams.take(segment):
            yield TraceEntry(time_ns, bus, "modbus", sender, modbus_codec.encode(message))

    def _rtac(self, bus: str, time_ns: int, packet: bytes) -> Iterator[TraceEntry]:
        if len(packet) < _RTAC.size:
            self._odd.report(LEFT_OUT)
            return
        event, data = _RTAC.unpack_from(packet)[2], packet[_RTAC.size :]
        sender = _RTAC_SENDERS.get(event, "")
        if event == _RTAC_BREAK:
            yield TraceEntry(time_ns, bus, "serial", sender, serial_codec.encode(Break(_NO_BREAK_TIME_MS)))
        elif event == 5:
            self._odd.report("the capture has lost bytes of a serial line")
        elif data:
            yield TraceEntry(time_ns, bus, "serial", sender, b"\0" + data)


def can_message(packet: bytes) -> bytes | None:
    """Return the encoded message in a packet of SocketCAN; None for a frame that no bus carries."""
    if len(packet) < CAN.size:
        return None
    word, length, flags = CAN.unpack_from(packet)
    data = packet[CAN.size : CAN.size + length]
    if word & REMOTE:
        data = b""
    elif len(data) < length:
        return None
    is_fd = bool(flags & FD) or len(packet) == _FD_MTU
    if not is_fd and length <= 8 and (word <= 0x7FF or word >> 29 == EXTENDED >> 29):
        return plain_message(word, data)
    try:
        return message_of(word, data, length, is_fd, is_fd and bool(flags & BIT_RATE_SWITCH))
    except ValueError:
        return None


def _protocol(link_type: int, packet: bytes) -> int:
    at = 14 if link_type == SLL else 0
    return int.from_bytes(packet[at : at + 2], "big")


def _ppp_entry(link: Link, time_ns: int, packet: bytes) -> TraceEntry:
    """A frame of PPP as it is on the line: with its check sequence, escaped, between flags (RFC 1662, 4 and C.1)."""
    sender = ""
    if link.link_type == PPP_WITH_DIRECTION:
        sender, packet = ("rx", "tx")[packet[:1] == b"\x01"], packet[1:]
    frame = packet if packet[:2] == b"\xff\x03" else b"\xff\x03" + packet
    check = crc_hqx(frame.translate(BITS_REVERSED), 0xFFFF) ^ 0xFFFF
    whole = frame + check.to_bytes(2, "big").translate(BITS_REVERSED)
    escaped = b"".join(map(_ESCAPED.__getitem__, whole))
    return TraceEntry(time_ns, f"{link.bus}{PPP_LINE}", "serial", sender, b"\0\x7e" + escaped + b"\x7e")
