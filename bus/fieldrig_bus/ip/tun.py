"""A network device of the kernel whose packets this process reads and writes: TUN of Linux.

The device has the address of one end of a link, and the one route to its peer.  It exists as long as this process has
it open, so nothing of it is left even after a kill.  Source: netdevice(7), and tuntap.txt of the kernel's
documentation.
"""

import os
import socket
import struct
import sys
from contextlib import suppress
from errno import ENOTSUP
from ipaddress import IPv4Address
from typing import Final

DEVICE: Final = "/dev/net/tun"
NAME: Final = b"fieldrig%d"
"""Name of the device; the kernel sets the number."""
QUEUE: Final = 10
"""Packets that the kernel keeps for a slow reader."""
LONGEST: Final = 0xFFFF

_TUNSETIFF: Final = 0x400454CA
_IFF_TUN, _IFF_NO_PI = 0x0001, 0x1000
_SIOCGIFFLAGS, _SIOCSIFFLAGS = 0x8913, 0x8914
_SIOCSIFADDR, _SIOCSIFDSTADDR, _SIOCSIFNETMASK = 0x8916, 0x8918, 0x891C
_SIOCSIFMTU, _SIOCSIFTXQLEN = 0x8922, 0x8943
_IFF_UP: Final = 1
_SO_BINDTODEVICE: Final = 25
_FLAGS: Final = os.O_RDWR | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)
_NOWHERE: Final = IPv4Address("0.0.0.0")
_ONE_HOST: Final = IPv4Address("255.255.255.255")


class Tun:
    """OSError from any method if the kernel does not allow it."""

    def __init__(self) -> None:
        """Make a device that is down, and find out whether it may be configured."""
        self.fd = os.open(DEVICE, _FLAGS)
        try:
            made = _ioctl(self.fd, _TUNSETIFF, struct.pack("16sH22x", NAME, _IFF_TUN | _IFF_NO_PI))
            self._name = made[:16].rstrip(b"\0")
            self._set_number(_SIOCSIFTXQLEN, QUEUE)
        except OSError:
            os.close(self.fd)
            raise

    @property
    def name(self) -> str:
        return self._name.decode()

    def set_up(self, address: IPv4Address, peer: IPv4Address, mtu: int) -> None:
        self._set_number(_SIOCSIFMTU, mtu)
        self._set_address(_SIOCSIFADDR, address)
        self._set_address(_SIOCSIFDSTADDR, peer)
        self._set_address(_SIOCSIFNETMASK, _ONE_HOST)
        self._set_up(True)

    def set_down(self) -> None:
        self._set_up(False)
        self._set_address(_SIOCSIFADDR, _NOWHERE)

    def listener(self, address: IPv4Address, port: int) -> socket.socket:
        """Return a socket that listens for connections that come through this device, and for no others."""
        listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.setsockopt(socket.SOL_SOCKET, _SO_BINDTODEVICE, self._name)
            listener.setblocking(False)
            listener.bind((str(address), port))
            listener.listen()
        except OSError:
            listener.close()
            raise
        return listener

    def read(self) -> bytes | None:
        """Return the next packet of the kernel; None if there is none."""
        try:
            return os.read(self.fd, LONGEST)
        except BlockingIOError:
            return None

    def write(self, packet: bytes) -> None:
        os.write(self.fd, packet)

    def close(self) -> None:
        os.close(self.fd)

    def _set_up(self, is_up: bool) -> None:
        flags = struct.unpack("16sH14x", self._configure(_SIOCGIFFLAGS, struct.pack("16sH14x", self._name, 0)))[1]
        wanted = flags | _IFF_UP if is_up else flags & ~_IFF_UP
        self._configure(_SIOCSIFFLAGS, struct.pack("16sH14x", self._name, wanted))

    def _set_address(self, request: int, address: IPv4Address) -> None:
        self._configure(request, struct.pack("16sHH4s8x", self._name, socket.AF_INET, 0, address.packed))

    def _set_number(self, request: int, number: int) -> None:
        self._configure(request, struct.pack("16si12x", self._name, number))

    def _configure(self, request: int, argument: bytes) -> bytes:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
            return _ioctl(any_socket.fileno(), request, argument)


def _ioctl(fd: int, request: int, argument: bytes) -> bytes:
    if sys.platform != "win32":
        with suppress(ImportError):
            from fcntl import ioctl

            return ioctl(fd, request, argument)
    raise OSError(ENOTSUP, "this system has no TUN")


def is_of_this_host(address: IPv4Address) -> bool:
    """True if a network device of this host has the address already."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind((str(address), 0))
        except OSError:
            return False
        return True
