"""SDO block transfers: up to 127 segments per confirmation, with a CRC over all data.

Source: CiA 301 7.2.4.3.9 to 7.2.4.3.16.  A gap is reported at the end of its block (or when the client stops sending
within it) by the last sequence number before the gap, and the client continues from there.  Segments after a gap are
dropped.  The CRC is offered only to clients that ask for it, because some take the server's offer for an agreement.
"""

from binascii import crc_hqx
from collections.abc import Callable
from enum import Enum, auto
from struct import Struct

from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.sdo.segmented import SEGMENT, Transfer

MAX_BLOCK = 127
MORE_MASK = 0x7F
LAST = 0x80
"""Masks of a segment's first byte: the sequence number, and the flag of the last segment."""

# First bytes, and masks of their command bits; the other bits are flags or the number of unused bytes.
DOWNLOAD_COMMAND, UPLOAD_COMMAND = 0xE1, 0xE3
DOWNLOAD, DOWNLOAD_END = 0xC0, 0xC1
UPLOAD, UPLOAD_END, UPLOAD_CONFIRM, UPLOAD_START = 0xA0, 0xA1, 0xA2, 0xA3
DOWNLOAD_INITIATED, DOWNLOAD_ENDED, DOWNLOAD_CONFIRM = 0xA0, 0xA1, 0xA2
UPLOAD_INITIATED, UPLOAD_DATA_END = 0xC0, 0xC1
CRC, SIZE_INDICATED = 0x04, 0x02

END = Struct("<BH5x")
CONFIRM = Struct("<BBB5x")

Send = Callable[[bytes], None]


def check_block_size(size: int) -> None:
    if not 1 <= size <= MAX_BLOCK:
        raise Abort(Code.INVALID_BLOCK_SIZE)


class BlockDownload(Transfer):
    """Collects blocks of `block_size` segments and passes the data to `write` if size and CRC are right."""

    abort_mask = 0xFF  # the other bits belong to sequence numbers

    def __init__(
        self,
        block_size: int,
        size: int | None,
        is_checked: bool,
        check_room: Callable[[int], None],
        write: Callable[[bytes], None],
    ) -> None:
        self._block_size, self._size, self._is_checked = block_size, size, is_checked
        self._check_room, self._write = check_room, write
        self._data = bytearray()
        self._sequence = 0
        self._is_complete = False

    def on_request(self, request: bytes) -> bytes | None:
        if self._is_complete:
            return self._on_end(request)
        first = request[0]
        number = first & MORE_MASK
        if number == 0 or number > self._block_size:
            raise Abort(Code.INVALID_SEQUENCE_NUMBER)
        if number == self._sequence + 1:
            self._sequence = number
            self._data += request[1:]
            self._check()
            self._is_complete = first >= LAST
        if first >= LAST or number == self._block_size:
            return self._confirm()
        return None

    def prompt(self) -> bytes | None:
        """Confirm the segments received so far, as the end of the block is lost."""
        return None if self._is_complete else self._confirm()

    def _confirm(self) -> bytes:
        sequence, self._sequence = self._sequence, 0
        if self._is_complete:
            self.abort_mask = 0xE0
        return CONFIRM.pack(DOWNLOAD_CONFIRM, sequence, self._block_size)

    def _check(self) -> None:
        """Check the lower bound: the number of unused bytes in the last segment is known only at the end."""
        least = len(self._data) - SEGMENT
        if self._size is None:
            self._check_room(least)
        elif least > self._size:
            raise Abort(Code.LENGTH_TOO_HIGH)

    def _on_end(self, request: bytes) -> bytes:
        command, check = END.unpack(request)
        if command & DOWNLOAD_COMMAND != DOWNLOAD_END:
            raise Abort(Code.UNKNOWN_COMMAND_SPECIFIER)
        data = bytes(self._data[: len(self._data) - (command >> 2 & 7)])
        if self._is_checked and crc_hqx(data, 0) != check:
            raise Abort(Code.CRC_ERROR)
        if self._size is not None and len(data) != self._size:
            raise Abort(Code.LENGTH_TOO_HIGH if len(data) > self._size else Code.LENGTH_TOO_LOW)
        self.is_finished = True
        self._write(data)
        return bytes((DOWNLOAD_ENDED, 0, 0, 0, 0, 0, 0, 0))


class Phase(Enum):
    INITIATED = auto()
    SENDING = auto()
    ENDING = auto()


class BlockUpload(Transfer):
    """Sends `data` in blocks; the client sets the number of segments with each confirmation."""

    def __init__(self, data: bytes, block_size: int, is_checked: bool, send: Send) -> None:
        self._data, self._block_size, self._is_checked, self._send = data, block_size, is_checked, send
        self._phase = Phase.INITIATED
        self._position = self._sent = 0

    def on_request(self, request: bytes) -> bytes | None:
        command, sequence, block_size = CONFIRM.unpack(request)
        if command & UPLOAD_COMMAND != EXPECTED[self._phase]:
            raise Abort(Code.UNKNOWN_COMMAND_SPECIFIER)
        if self._phase is Phase.ENDING:
            self.is_finished = True
            return None
        if self._phase is Phase.SENDING:
            return self._on_confirm(sequence, block_size)
        self._phase = Phase.SENDING
        self._send_block()
        return None

    def _on_confirm(self, sequence: int, block_size: int) -> bytes | None:
        if sequence > self._sent:
            raise Abort(Code.INVALID_SEQUENCE_NUMBER)
        check_block_size(block_size)
        self._block_size = block_size
        self._position += sequence * SEGMENT
        if self._position < max(1, len(self._data)):
            self._send_block()
            return None
        self._phase = Phase.ENDING
        unused = -len(self._data) % SEGMENT if self._data else SEGMENT
        return END.pack(UPLOAD_DATA_END | unused << 2, crc_hqx(self._data, 0) if self._is_checked else 0)

    def _send_block(self) -> None:
        data, first, send = self._data, self._position, self._send
        segments = min(self._block_size, max(1, -(-(len(data) - first) // SEGMENT)))
        for number in range(1, segments):
            send(bytes((number,)) + data[first : first + SEGMENT])
            first += SEGMENT
        is_last = first + SEGMENT >= len(data)
        send(bytes((segments | is_last << 7,)) + data[first : first + SEGMENT].ljust(SEGMENT, b"\x00"))
        self._sent = segments


EXPECTED = {Phase.INITIATED: UPLOAD_START, Phase.SENDING: UPLOAD_CONFIRM, Phase.ENDING: UPLOAD_END}
