"""Messages in shared memory: one writer, any number of readers, no lock.

An image is a log of the last messages in slots of equal size.  A slot holds number, length and CRC of its message; the
header holds the number of the newest message.  A reader that was overtaken, or that reads while the slot is written,
sees a wrong number or CRC and skips the message, so it does not depend on the processor's order of stores.
"""

import mmap
import os
import struct
from collections.abc import Iterator
from typing import Final
from zlib import crc32

SLOTS: Final = 16
_NEWEST: Final = struct.Struct("<I")
_HEAD: Final = struct.Struct("<III")  # number, length, CRC-32
_START: Final = 64  # of the slots, so that the header has a cache line of its own
_32: Final = 0xFFFF_FFFF


class Image:
    """A log of messages in the file of a descriptor, which the image owns from now on."""

    def __init__(self, fd: int, slots: int = SLOTS) -> None:
        self.fd, self._slots = fd, slots
        self._map = mmap.mmap(fd, 0)
        self._slot = (len(self._map) - _START) // slots
        self.number = 0
        """Number of the newest message that was written, or read, by this object."""

    @classmethod
    def make(cls, name: str, longest: int, slots: int = SLOTS) -> "Image":
        """A new image of `slots` messages of at most `longest` bytes.  OSError where the system has no memfd."""
        if not hasattr(os, "memfd_create"):
            raise OSError("this system has no memfd")
        fd = os.memfd_create(name)  # it is not inherited
        os.ftruncate(fd, _START + slots * (_HEAD.size + longest))
        return cls(fd, slots)

    def close(self) -> None:
        """Release the memory and the descriptor."""
        self._map.close()
        os.close(self.fd)

    def write(self, message: bytes) -> None:
        """Write a message.  ValueError if it is too long."""
        if len(message) > self._slot - _HEAD.size:
            raise ValueError(f"a message of {len(message)} bytes: expected at most {self._slot - _HEAD.size}")
        self.number = number = self.number + 1 & _32
        start = _START + number % self._slots * self._slot
        self._map[start : start + _HEAD.size + len(message)] = (
            _HEAD.pack(number, len(message), crc32(message, number)) + message
        )
        _NEWEST.pack_into(self._map, 0, number)

    def read(self) -> Iterator[bytes]:
        """Messages written since the last call, as far as they are still there."""
        (newest,) = _NEWEST.unpack_from(self._map)
        unread = newest - self.number & _32
        if unread > self._slots:
            self.number = newest - self._slots & _32
        while self.number != newest:
            self.number = self.number + 1 & _32
            start = _START + self.number % self._slots * self._slot
            number, length, check = _HEAD.unpack_from(self._map, start)
            if number == self.number and length <= self._slot - _HEAD.size:
                start += _HEAD.size
                message = self._map[start : start + length]
                if crc32(message, number) == check:
                    yield message
