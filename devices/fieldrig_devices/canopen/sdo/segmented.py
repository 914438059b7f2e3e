"""Segmented SDO transfers, from their second message on, in segments of 7 bytes.

Source: CiA 301 7.2.4.3.4 (download segment) and 7.2.4.3.7 (upload segment).
"""

from abc import ABC, abstractmethod
from collections.abc import Callable

from fieldrig_devices.canopen.abort import Abort, Code

SEGMENT = 7
TOGGLE = 0x10
LAST = 0x01

DOWNLOAD_REQUEST, UPLOAD_REQUEST = 0, 3
"""Command specifiers of the client for segments."""
DOWNLOAD_RESPONSE = 0x20


class Transfer(ABC):
    """An initiated transfer, which handles all following messages."""

    is_finished = False
    abort_mask = 0xE0
    """Mask of the first byte that identifies an abort (80h)."""

    @abstractmethod
    def on_request(self, request: bytes) -> bytes | None:
        """Return the response to 8 bytes from the client, if there is one.  Raises Abort to end the transfer."""

    def prompt(self) -> bytes | None:
        """Return a message for a client that has been silent for half of its time-out, or None."""
        return None


class SegmentedUpload(Transfer):
    """Sends `data`, as it was when the transfer was initiated, to the client."""

    def __init__(self, data: bytes) -> None:
        self._data, self._position, self._toggle = data, 0, 0

    def on_request(self, request: bytes) -> bytes:
        command = request[0]
        if command >> 5 != UPLOAD_REQUEST:
            raise Abort(Code.UNKNOWN_COMMAND_SPECIFIER)
        if command & TOGGLE != self._toggle:
            raise Abort(Code.TOGGLE_BIT_NOT_ALTERNATED)
        segment = self._data[self._position : self._position + SEGMENT]
        self._position += SEGMENT
        self.is_finished = self._position >= len(self._data)
        answer = self._toggle | (SEGMENT - len(segment)) << 1 | self.is_finished
        self._toggle ^= TOGGLE
        return bytes((answer,)) + segment.ljust(SEGMENT, b"\x00")


class SegmentedDownload(Transfer):
    """Collects what the client sends and passes it to `write` when it is complete.

    `size` is the size that the client announced; without it, `check_room` ends the transfer once there is too much.
    """

    def __init__(self, size: int | None, check_room: Callable[[int], None], write: Callable[[bytes], None]) -> None:
        self._size, self._check_room, self._write = size, check_room, write
        self._data, self._toggle = bytearray(), 0

    def on_request(self, request: bytes) -> bytes:
        command = request[0]
        if command >> 5 != DOWNLOAD_REQUEST:
            raise Abort(Code.UNKNOWN_COMMAND_SPECIFIER)
        if command & TOGGLE != self._toggle:
            raise Abort(Code.TOGGLE_BIT_NOT_ALTERNATED)
        self._data += request[1 : 8 - (command >> 1 & 7)]
        self._check()
        if command & LAST:
            self._finish()
        answer = DOWNLOAD_RESPONSE | self._toggle
        self._toggle ^= TOGGLE
        return bytes((answer, 0, 0, 0, 0, 0, 0, 0))

    def _check(self) -> None:
        if self._size is None:
            self._check_room(len(self._data))
        elif len(self._data) > self._size:
            raise Abort(Code.LENGTH_TOO_HIGH)

    def _finish(self) -> None:
        if self._size is not None and len(self._data) < self._size:
            raise Abort(Code.LENGTH_TOO_LOW)
        self.is_finished = True
        self._write(bytes(self._data))
