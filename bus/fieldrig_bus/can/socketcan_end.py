"""A member's raw socket of the Linux kernel's CAN.

Left out: setting devices up, which needs root (the error messages say how).
"""

import errno
import socket
import sys
from pathlib import Path
from typing import Final

from fieldrig.bus import Attachment
from fieldrig.errors import BusError
from fieldrig_bus.can.acceptance import Filters, passes, received
from fieldrig_bus.can.direct import DirectEnd
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.socketcan_wire import (
    FD,
    NO_CAN,
    NO_SOCKETCAN,
    error_mask,
    from_wire,
    kernel_filters,
    notice_from_wire,
    to_wire,
)

assert sys.platform == "linux", "only Linux has SocketCAN"

ERROR_FILTER: Final = 2  # CAN_RAW_ERR_FILTER; Python has the name only if its headers had it
MOST_FILTERS: Final = 512  # CAN_RAW_FILTER_MAX
RECEIVE_BUFFER: Final = 1 << 20


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


def open_socket(channel: str, fd: bool) -> socket.socket:
    """A raw CAN socket that receives nothing yet.  BusError, with its remedy, if it cannot be opened."""
    if not hasattr(socket, "AF_CAN"):  # Python without it
        raise BusError(NO_SOCKETCAN, NO_CAN)
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
    if fd and mtu.is_file() and int(mtu.read_text(encoding="ascii")) < FD.size:
        remedy = f"sudo ip link set {channel} down && sudo ip link set {channel} mtu 72 up, or leave out fd: true"
        raise BusError(f"{channel} is not set up for CAN FD", remedy)


def _set_up(channel: str) -> str:
    if channel.startswith("vcan"):
        return f"sudo ip link add dev {channel} type vcan && sudo ip link set {channel} up"
    return f"plug the adapter in, then: sudo ip link set {channel} up type can bitrate 500000"
