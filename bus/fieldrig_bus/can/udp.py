"""`can.udp`: a CAN bus over UDP multicast, for rigs and tests that already use python-can's `udp_multicast`.

Source: python-can 4.6, can/interfaces/udp_multicast: a datagram is one message as a msgpack map.  As there, neither
order nor delivery is guaranteed, and there is no bit rate and no arbitration.  Traffic stays on the loopback interface
unless `interface` names another one.  python-can itself joins on the default interface, so a route must lead the group
to `lo` before it meets this bus there (see `tools`).
Left out: IPv6 groups, error frames, filters in the kernel (every member pays for every frame; can.hub avoids that).
"""

import errno
import logging
import socket
import sys
import time
from ipaddress import AddressValueError, IPv4Address
from pathlib import Path
from typing import Annotated, ClassVar, Final

import msgpack
from pydantic import AfterValidator, Field

from fieldrig.bus import Attachment
from fieldrig.device import Tool, WayIn
from fieldrig.errors import BusError
from fieldrig_bus.can.acceptance import Filters, passes, received
from fieldrig_bus.can.direct import CanDirectBus, CanDirectSettings, DirectEnd
from fieldrig_bus.can.frame import CanFrame

log = logging.getLogger(__name__)

LONGEST_DATAGRAM: Final = 4096  # as python-can reads them
RECEIVE_BUFFER: Final = 1 << 20
IP_MULTICAST_ALL: Final = 49  # linux/in.h


def _group(text: str) -> str:
    try:
        is_group = IPv4Address(text).is_multicast
    except AddressValueError:
        is_group = False
    if not is_group:
        raise ValueError(f"{text!r} is not an IPv4 multicast address: expected one such as 239.74.163.2")
    return text


def _interface(text: str) -> str:
    try:
        address = IPv4Address(text)
    except AddressValueError as cause:
        raise ValueError(f"{text!r} is not an IPv4 address of this machine: expected one such as 127.0.0.1") from cause
    if address.is_unspecified or address.is_multicast:
        raise ValueError(f"{text} is not the address of an interface: expected one such as 127.0.0.1")
    return text


class CanUdpSettings(CanDirectSettings):
    group: Annotated[str, AfterValidator(_group)] = Field(
        default="239.74.163.2", description="IPv4 multicast address; python-can's own if left out"
    )
    port: int = Field(default=43113, ge=1, le=65535, description="UDP port")
    interface: Annotated[str, AfterValidator(_interface)] = Field(
        default="127.0.0.1",
        description="IPv4 address of the network interface; traffic leaves this machine by any but 127.0.0.1",
    )
    hop_limit: int = Field(default=1, ge=0, le=255, description="number of networks that a datagram may cross; 0: none")
    fd: bool = Field(default=True, description="carry CAN FD frames as well")


def to_wire(frame: CanFrame, time_s: float) -> bytes:
    length = frame.remote_length if frame.is_remote else len(frame.data)
    message = {
        "timestamp": time_s,
        "arbitration_id": frame.identifier,
        "is_extended_id": frame.is_extended,
        "is_remote_frame": frame.is_remote,
        "is_error_frame": False,
        "channel": None,
        "dlc": length,
        "data": frame.data,
        "is_fd": frame.is_fd,
        "bitrate_switch": frame.is_bit_rate_switched,
        "error_state_indicator": False,
    }
    packed: bytes = msgpack.packb(message)
    return packed


def from_wire(datagram: bytes) -> CanFrame | None:
    """The frame in a datagram; None for an error frame.  ValueError if the datagram is not a message."""
    match msgpack.unpackb(datagram):
        case {"is_error_frame": True}:
            return None
        case {
            "arbitration_id": int(identifier),
            "is_extended_id": bool(is_extended),
            "is_remote_frame": bool(is_remote),
            "dlc": int(length),
            "data": bytes(data) | (None as data),
            "is_fd": bool(is_fd),
            "bitrate_switch": bool(is_switched),
        }:
            data = data or b""
            if not is_remote and length != len(data):
                raise ValueError("the length is not the length of the data")
            return CanFrame(int(identifier), data, is_extended, is_remote, length * is_remote, is_fd, is_switched)
    raise ValueError("not a message of python-can")


class UdpEnd(DirectEnd):
    """One member's link.  It recognises its own datagrams, when they come back, by the port that it sends from."""

    def __init__(
        self, at: Attachment, settings: CanUdpSettings, receiver: socket.socket, sender: socket.socket
    ) -> None:
        super().__init__(at, receiver)
        self._sender, self._own_address = sender, sender.getsockname()
        self._destination, self._fd = (settings.group, settings.port), settings.fd
        self._filters: Filters | None = ()
        self._with_own = False

    def transmit(self, frame: CanFrame) -> bool:
        try:
            self._sender.sendto(to_wire(frame, time.time()), self._destination)
        except OSError as fault:
            # no room in the socket's buffer; any other error, such as a network that is down, loses the frame
            return fault.errno not in (errno.ENOBUFS, errno.EAGAIN)
        self.at.heard(self.at.member, frame)
        return True

    def listen(self, filters: Filters | None, with_own: bool) -> None:
        self._filters, self._with_own = filters, with_own

    def receive(self) -> None:
        datagram, sender = self.socket.recvfrom(LONGEST_DATAGRAM)
        is_own = sender == self._own_address
        if self.handler is None or (is_own and not self._with_own):
            return
        try:
            frame = from_wire(datagram)
        except ValueError as fault:
            log.debug("%s: %s from %s: %s", self.at.member, datagram, sender, fault)
            return
        if frame is None or (frame.is_fd and not self._fd):
            return
        if is_own or passes(received(frame), self._filters):
            self.at.deliver(self.handler, frame)

    def close(self) -> None:
        super().close()
        self._sender.close()


class CanUdp(CanDirectBus):
    about: ClassVar[str] = "CAN over UDP multicast, as python-can's udp_multicast; without order, filters and bit rate"
    settings: CanUdpSettings

    def __init__(self, name: str, settings: CanUdpSettings) -> None:
        super().__init__(name, settings)

    def end(self, at: Attachment) -> UdpEnd:
        settings = self.settings
        try:
            receiver = _receiver(settings)
        except OSError as cause:
            raise _bus_error(settings, cause) from cause
        try:
            return UdpEnd(at, settings, receiver, _sender(settings))
        except OSError as cause:
            receiver.close()
            raise _bus_error(settings, cause) from cause

    def python_can(self) -> dict[str, object]:
        settings = self.settings
        return {"interface": "udp_multicast", "channel": settings.group, "port": settings.port, "fd": settings.fd}

    def ways_in(self, run: Path) -> list[WayIn]:
        return [WayIn("UDP multicast", f"{self.settings.group}:{self.settings.port}")]

    def tools(self, run: Path) -> list[Tool]:
        group, port = self.settings.group, self.settings.port
        watch = Tool("watch", f"python -m can.viewer -i udp_multicast -c {group} --bus-kwargs port={port}")
        if not IPv4Address(self.settings.interface).is_loopback:
            return [watch]
        return [Tool("first lead the group to lo", f"sudo ip route add {group}/32 dev lo"), watch]


def _receiver(settings: CanUdpSettings) -> socket.socket:
    sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        sock.setblocking(False)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if hasattr(socket, "SO_REUSEPORT"):  # python-can sets it, and then every socket must
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        if sys.platform == "linux":  # receive only groups joined on this interface
            sock.setsockopt(socket.IPPROTO_IP, IP_MULTICAST_ALL, 0)
        sock.bind(("" if sys.platform == "win32" else settings.group, settings.port))
        member = socket.inet_aton(settings.group) + socket.inet_aton(settings.interface)
        sock.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
    except OSError:
        sock.close()
        raise
    return sock


def _sender(settings: CanUdpSettings) -> socket.socket:
    sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        sock.setblocking(False)
        sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(settings.interface))
        sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
        sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, settings.hop_limit)
        sock.bind((settings.interface, 0))
    except OSError:
        sock.close()
        raise
    return sock


def _bus_error(settings: CanUdpSettings, cause: OSError) -> BusError:
    what = f"cannot join {settings.group}:{settings.port} on {settings.interface}: {cause.strerror}"
    if cause.errno in (errno.ENODEV, errno.EADDRNOTAVAIL):
        return BusError(what, "interface: expected the address of an interface of this machine, such as 127.0.0.1")
    return BusError(what, "choose another group or port, or use kind: can.hub, which needs no multicast")
