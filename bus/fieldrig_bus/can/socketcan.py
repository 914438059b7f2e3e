"""`can.socketcan`: a CAN bus of the Linux kernel, vcan or a real adapter.

Source: Linux, Documentation/networking/can.rst, 4.1 (raw sockets), and include/uapi/linux/can.h.  The kernel filters
what a member is not interested in, so it costs the member nothing.  The bit rate is that of the network device.  Its
error frames become notices for members that ask for "errors" or "state".
Left out: setting devices up, which needs root (the error messages say how).
"""

import errno
import shlex
import socket
import struct
from pathlib import Path
from typing import ClassVar, Final

from pydantic import Field

from fieldrig.bus import Attachment
from fieldrig.device import Tool, WayIn
from fieldrig.errors import BusError
from fieldrig_bus.can import socketcan_errors
from fieldrig_bus.can.acceptance import ERRORS, EXTENDED, REMOTE, STATE, Filters, passes, received
from fieldrig_bus.can.direct import CanDirectBus, CanDirectSettings, DirectEnd
from fieldrig_bus.can.frame import EXTENDED_MASK, FD_LENGTHS, STANDARD_MASK, CanFrame
from fieldrig_bus.can.linux_flags import BIT_RATE_SWITCH, ERROR
from fieldrig_bus.can.notices import BusState, CanError

CLASSICAL: Final = struct.Struct("=IB3x8s")  # struct can_frame
FD: Final = struct.Struct("=IBB2x64s")  # struct canfd_frame
HEAD: Final = struct.Struct("=IBB2x")
FILTER: Final = struct.Struct("=II")  # struct can_filter
ERROR_FILTER: Final = 2  # CAN_RAW_ERR_FILTER; Python has the name only if its headers had it
MOST_FILTERS: Final = 512  # CAN_RAW_FILTER_MAX
RECEIVE_BUFFER: Final = 1 << 20

NO_CAN: Final = "on Linux load it with `sudo modprobe can-raw vcan`; kind: can.hub needs no kernel support"


class CanSocketcanSettings(CanDirectSettings):
    channel: str = Field(pattern=r"^[^\s/]{1,15}$", description="network device, such as vcan0 or can0")
    fd: bool = Field(default=False, description="carry CAN FD frames as well; the device must be set up for them")


def to_wire(frame: CanFrame) -> bytes:
    """A frame as struct can_frame, or canfd_frame."""
    word, data = frame.identifier, frame.data
    if frame.is_extended:
        word |= EXTENDED
    if frame.is_fd:
        return FD.pack(word, len(data), BIT_RATE_SWITCH * frame.is_bit_rate_switched, data)
    if frame.is_remote:
        return CLASSICAL.pack(word | REMOTE, frame.remote_length, b"")
    return CLASSICAL.pack(word, len(data), data)


def from_wire(data: bytes) -> CanFrame | None:
    """The inverse of `encode`; None for an error frame.

    The kernel hands over unchanged what a program sent to a vcan.  A controller would send something that a bus can
    carry, and so it is decoded: an identifier of 11 or 29 bits, an FD frame padded with zeros to the next length that
    a DLC can encode (as drivers do by `can_fd_len2dlc`), and at most 8 bytes requested.
    """
    word, length, flags = HEAD.unpack_from(data)
    payload = data[HEAD.size : HEAD.size + length]
    is_fd = len(data) == FD.size
    if word <= STANDARD_MASK and not is_fd:  # as most frames are
        return CanFrame(word, payload)
    if word & ERROR:
        return None
    is_extended = bool(word & EXTENDED)
    identifier = word & (EXTENDED_MASK if is_extended else STANDARD_MASK)
    if is_fd:
        full = next(length for length in FD_LENGTHS if length >= len(payload))
        is_switched = bool(flags & BIT_RATE_SWITCH)
        return CanFrame(identifier, payload.ljust(full, b"\0"), is_extended, False, 0, True, is_switched)
    if word & REMOTE:
        return CanFrame(identifier, b"", is_extended, True, min(length, CLASSICAL.size - HEAD.size))
    return CanFrame(identifier, payload, is_extended)


def kernel_filters(filters: Filters | None) -> bytes:
    """Filters as an array of struct can_filter.  Bit 29 means something else there; no identifier here contains it."""
    if filters is None:
        return FILTER.pack(0, 0)
    return b"".join(FILTER.pack(wanted, mask & ~ERROR) for wanted, mask in filters if not wanted & ERROR)


def error_mask(notices: frozenset[str]) -> int:
    """Classes of error frames that the kernel passes."""
    mask = (socketcan_errors.ERRORS if ERRORS in notices else 0) | (socketcan_errors.STATES if STATE in notices else 0)
    return int(mask)


def notice_from_wire(data: bytes) -> CanError | BusState | None:
    """The notice that corresponds to an error frame; None if there is none."""
    word, _, _ = HEAD.unpack_from(data)
    return socketcan_errors.notice_of(word & EXTENDED_MASK, data[HEAD.size :])


class SocketcanEnd(DirectEnd):
    def __init__(self, at: Attachment, sock: socket.socket) -> None:
        super().__init__(at, sock)
        self._filters: Filters | None = None
        self._with_own = False

    def transmit(self, frame: CanFrame) -> bool:
        try:
            self.socket.send(to_wire(frame))
        except OSError as fault:
            # a full transmit queue; any other error, such as a device that is down, loses the frame
            return fault.errno not in (errno.ENOBUFS, errno.EAGAIN)
        self.at.heard(self.at.member, frame)
        return True

    def listen(self, filters: Filters | None, with_own: bool) -> None:
        """Set the filters: in the kernel, or here with "own" (the kernel filters own frames too) or too many."""
        filters_here = with_own or (filters is not None and len(filters) > MOST_FILTERS)
        self._filters, self._with_own = (filters if filters_here else None), with_own
        self.socket.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_RECV_OWN_MSGS, int(with_own))
        self.socket.setsockopt(socket.SOL_CAN_RAW, ERROR_FILTER, error_mask(self.notices))
        in_kernel = kernel_filters(None if filters_here else filters)
        self.socket.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, in_kernel)

    def receive(self) -> None:
        if self._with_own:
            data, _, flags, _ = self.socket.recvmsg(FD.size)
            is_own = bool(flags & socket.MSG_CONFIRM)
        else:
            data, is_own = self.socket.recv(FD.size), False
        frame, handler = from_wire(data), self.handler
        if frame is None and handler is not None and (notice := notice_from_wire(data)) is not None:
            self.at.deliver(handler, notice)
        elif frame is not None and handler is not None and (is_own or passes(received(frame), self._filters)):
            self.at.deliver(handler, frame)


class CanSocketcan(CanDirectBus):
    about: ClassVar[str] = "CAN bus of the Linux kernel: vcan, or a real adapter"
    settings: CanSocketcanSettings

    def __init__(self, name: str, settings: CanSocketcanSettings) -> None:
        super().__init__(name, settings)

    def end(self, at: Attachment) -> SocketcanEnd:
        return SocketcanEnd(at, open_socket(self.settings.channel, self.settings.fd))

    def python_can(self) -> dict[str, object]:
        return {"interface": "socketcan", "channel": self.settings.channel, "fd": self.settings.fd}

    def ways_in(self, run: Path) -> list[WayIn]:
        return [WayIn("SocketCAN", self.settings.channel)]

    def tools(self, run: Path) -> list[Tool]:
        channel = shlex.quote(self.settings.channel)
        return [
            Tool("log", f"candump {channel}"),
            Tool("send", f"cansend {channel} 123#1122"),
            Tool("watch", f"python -m can.viewer -i socketcan -c {channel}"),
        ]


def open_socket(channel: str, fd: bool) -> socket.socket:
    """A raw CAN socket that receives nothing yet.  BusError, with its remedy, if it cannot be opened."""
    if not hasattr(socket, "AF_CAN"):
        raise BusError("this system has no SocketCAN", NO_CAN)
    try:
        sock = socket.socket(socket.AF_CAN, socket.SOCK_RAW | socket.SOCK_NONBLOCK, socket.CAN_RAW)
    except OSError as cause:
        raise BusError(f"this kernel has no SocketCAN: {cause.strerror}", NO_CAN) from cause
    try:
        sock.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, b"")
        sock.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, int(fd))
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        sock.bind((channel,))
        _check_device(sock, channel, fd)
    except OSError as cause:
        sock.close()
        raise BusError(f"there is no CAN network device {channel}: {cause.strerror}", _set_up(channel)) from cause
    except BusError:
        sock.close()
        raise
    return sock


def _check_device(sock: socket.socket, channel: str, fd: bool) -> None:
    if sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR) == errno.ENETDOWN:
        raise BusError(f"{channel} is down", f"sudo ip link set {channel} up")
    mtu = Path("/sys/class/net", channel, "mtu")
    if fd and mtu.is_file() and int(mtu.read_text()) < FD.size:
        remedy = f"sudo ip link set {channel} down && sudo ip link set {channel} mtu 72 up, or leave out fd: true"
        raise BusError(f"{channel} is not set up for CAN FD", remedy)


def _set_up(channel: str) -> str:
    if channel.startswith("vcan"):
        return f"sudo ip link add dev {channel} type vcan && sudo ip link set {channel} up"
    return f"plug the adapter in, then: sudo ip link set {channel} up type can bitrate 500000"
