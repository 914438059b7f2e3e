"""A PPP frame in words: its protocol, and what it asks, answers or carries.

Source: RFC 1661 chapters 5 and 6 (LCP), RFC 1332 and 1877 (IPCP), RFC 1334 (PAP), and the PPP DLL protocol numbers of
IANA.  A password is not shown.
"""

from ipaddress import IPv4Address
from typing import Final

from fieldrig_devices.ip.ipv4 import Packet as IpPacket
from fieldrig_devices.ip.ipv4 import Protocol
from fieldrig_devices.ip.tcp.segment import Segment
from fieldrig_devices.ppp.framing import unpacked
from fieldrig_devices.ppp.packets import Code, Packet, decode_options
from fieldrig_devices.ppp.pap import PapCode, decode_login
from fieldrig_devices.ppp.protocols import ProtocolNumber

PROTOCOLS: Final = {
    0x0021: "IP", 0x002D: "VJ compressed TCP", 0x002F: "VJ uncompressed TCP", 0x0057: "IPv6", 0x8021: "IPCP",
    0x8057: "IPV6CP", 0x80FD: "CCP", 0xC021: "LCP", 0xC023: "PAP", 0xC025: "LQR", 0xC223: "CHAP",
}  # fmt: skip
LCP_OPTIONS: Final = {
    1: "MRU", 2: "ACCM", 3: "authentication protocol", 4: "quality protocol", 5: "magic number",
    7: "protocol field compression", 8: "address and control field compression",
}  # fmt: skip
IPCP_OPTIONS: Final = {2: "compression protocol", 3: "IP address", 129: "primary DNS", 131: "secondary DNS"}
OPTIONS: Final = {ProtocolNumber.LCP: LCP_OPTIONS, ProtocolNumber.IPCP: IPCP_OPTIONS}
NEGOTIATION: Final = (Code.CONFIGURE_REQUEST, Code.CONFIGURE_ACK, Code.CONFIGURE_NAK, Code.CONFIGURE_REJECT)
CODES: Final = {int(code): code.name.title().replace("_", "-") for code in Code}
TRANSPORTS: Final = {int(protocol): protocol.name for protocol in Protocol}
_NUMBER: Final = 1
"""The option of LCP whose value is a decimal number."""


def frame_words(frame: bytes) -> tuple[str, str]:
    """Return kind and text of a frame without flags, escapes and check sequence."""
    try:
        protocol, payload = unpacked(frame)
    except ValueError:
        return "PPP", frame.hex(" ").upper()
    kind = f"PPP {PROTOCOLS.get(protocol, f'{protocol:04X}h')}"
    try:
        return kind, _payload(protocol, payload)
    except ValueError:  # a damaged packet in a frame that arrived whole
        return kind, payload.hex(" ").upper()


def _payload(protocol: int, payload: bytes) -> str:
    if protocol in OPTIONS:
        return _control(ProtocolNumber(protocol), Packet.decode(payload))
    if protocol == ProtocolNumber.PAP:
        return _login(Packet.decode(payload))
    if protocol == ProtocolNumber.IP:
        return ip_words(payload)
    return f"{len(payload)} bytes"


def _control(protocol: ProtocolNumber, packet: Packet) -> str:
    name = CODES.get(packet.code, f"code {packet.code}")
    head = f"{name} {packet.identifier}"
    if packet.code not in NEGOTIATION:
        return head
    options = (_option(protocol, kind, data) for kind, data in decode_options(packet.data))
    return ": ".join(filter(None, (head, ", ".join(options))))


def _option(protocol: ProtocolNumber, kind: int, data: bytes) -> str:
    name = OPTIONS[protocol].get(kind, f"option {kind}")
    if not data:
        return name
    if protocol is ProtocolNumber.LCP:
        return f"{name} {int.from_bytes(data, 'big')}" if kind == _NUMBER else f"{name} {data.hex().upper()}h"
    is_address = kind != ProtocolNumber.IPCP and len(data) == 4 and "compression" not in name
    return f"{name} {IPv4Address(data) if is_address else data.hex().upper() + 'h'}"


def _login(packet: Packet) -> str:
    match packet.code:
        case PapCode.REQUEST:
            return (
                f"Authenticate-Request {packet.identifier}: user {decode_login(packet.data).name.decode('latin-1')!r}"
            )
        case PapCode.ACK:
            return f"Authenticate-Ack {packet.identifier}"
        case PapCode.NAK:
            return f"Authenticate-Nak {packet.identifier}"
    return f"code {packet.code} {packet.identifier}"


def ip_words(data: bytes) -> str:
    """Return addresses, ports and flags of an IPv4 packet.  ValueError for a damaged one."""
    packet = IpPacket.decode(data)
    ends = f"{packet.source} to {packet.destination}"
    if packet.protocol != Protocol.TCP or packet.is_fragment:
        name = TRANSPORTS.get(packet.protocol, f"protocol {packet.protocol}")
        return f"{ends} {name}, {len(packet.payload)} bytes"
    segment = Segment.decode(packet.payload, packet.source, packet.destination)
    flags = " ".join(flag.name for flag in segment.flags if flag.name)
    ports = f"port {segment.source_port} to {segment.destination_port}"
    return f"{ends} TCP {ports} {flags}, {len(segment.data)} bytes"
