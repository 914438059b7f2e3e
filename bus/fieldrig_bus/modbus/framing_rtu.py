"""RTU: a frame is between two silences of 3.5 characters, with a CRC at its end.

Source: Modbus over serial line V1.02, 2.5.1.  There are two ways to treat its gaps:

strict     as specified: a silence of more than 1.5 characters invalidates the frame, and only one of 3.5 ends it.  Two
           frames without that silence between them are one frame with a wrong CRC.
tolerant   for media where the time of reading says little (USB adapters, FIFOs, TCP): a frame that is read in pieces is
           complete when its CRC is right, and frames that are read together are separated by their lengths.  A frame
           that is still incomplete `frame_timeout_ns` after its last byte is dropped.
"""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import MS
from fieldrig_bus.modbus.framing import LineTiming

FRAME_TIMEOUT_NS: Final = 50 * MS
"""Default time for which a tolerant framer waits for the rest of a frame."""
SHORTEST, LONGEST = 4, 256  # bytes of a frame with its CRC
MOST_KEPT: Final = 8 * LONGEST


def _crc_entry(byte: int) -> int:
    for _ in range(8):
        byte = byte >> 1 ^ 0xA001 if byte & 1 else byte >> 1
    return byte


_CRC_TABLE: Final = tuple(map(_crc_entry, range(256)))


def crc16(data: bytes) -> int:
    """The CRC of V1.02, 6.2.2; its low byte is first on the line."""
    crc, table = 0xFFFF, _CRC_TABLE
    for byte in data:
        crc = crc >> 8 ^ table[(crc ^ byte) & 0xFF]
    return crc


def rtu_frame(unit: int, pdu: bytes) -> bytes:
    body = bytes((unit,)) + pdu
    return body + crc16(body).to_bytes(2, "little")


# Length of a request frame by function code: the whole frame, or up to and including a byte count.
_FIXED: Final = {1: 8, 2: 8, 3: 8, 4: 8, 5: 8, 6: 8, 7: 4, 8: 8, 11: 4, 12: 4, 17: 4, 22: 10, 24: 6, 43: 7}
_UP_TO_COUNT: Final = {15: 7, 16: 7, 20: 3, 21: 3, 23: 11}


def request_size(data: bytes) -> int | None:
    """The length of the request frame at the beginning of `data`; None if it cannot be determined."""
    function = data[1] if len(data) > 1 else 0
    head = _UP_TO_COUNT.get(function)
    if head is None:
        return _FIXED.get(function)
    return head + data[head - 1] + 2 if len(data) >= head else None


# The same for a response.
_RESPONSE_FIXED: Final = {5: 8, 6: 8, 7: 5, 8: 8, 11: 8, 15: 8, 16: 8, 22: 10}
_RESPONSE_COUNTED: Final = frozenset({1, 2, 3, 4, 12, 17, 20, 21, 23})
_EXCEPTION_SIZE: Final = 5


def response_size(data: bytes) -> int | None:
    """The length of the response frame at the beginning of `data`; None if it cannot be determined."""
    function = data[1] if len(data) > 1 else 0
    if function & 0x80:
        return _EXCEPTION_SIZE
    if function in _RESPONSE_COUNTED:
        return 3 + data[2] + 2 if len(data) > 2 else None
    if function == 24:  # the FIFO queue has a count of two bytes
        return 4 + int.from_bytes(data[2:4], "big") + 2 if len(data) > 3 else None
    if function == 43:
        return _identification_size(data)
    return _RESPONSE_FIXED.get(function)


def _identification_size(data: bytes) -> int | None:
    """Return the length of a response with a device identification (V1.1b3, 6.21): each object has its length."""
    if len(data) < 8 or data[2] != 0x0E:
        return None
    at = 8
    for _ in range(data[7]):
        if len(data) < at + 2:
            return None
        at += 2 + data[at + 1]
    return at + 2


Size = Callable[[bytes], int | None]


class RtuFramer:
    """If `is_burst`, bytes are read ahead of the line's time (pty, TCP) and timed as if they came at its pace.

    A tolerant framer separates frames that were read together by `size_of` (of requests, or of responses), and drops a
    frame that is incomplete `frame_timeout_ns` after its last byte.
    """

    def __init__(
        self,
        timing: LineTiming,
        is_strict: bool = True,
        is_burst: bool = True,
        size_of: Size = request_size,
        frame_timeout_ns: int = FRAME_TIMEOUT_NS,
    ) -> None:
        self._timing, self._is_strict, self._is_burst = timing, is_strict, is_burst
        self._size_of, self._frame_timeout_ns = size_of, frame_timeout_ns
        self._gap_ns, self._silence_ns = timing.gap_ns, timing.silence_ns
        self._buffer = bytearray()
        self._end_ns = 0  # the instant of the last character
        self._wish_ns: int | None = None
        self._starts = [0]  # positions in the buffer where a frame may begin, which is after a silence
        self._is_spoilt = False
        self._done: list[tuple[int, bytes]] = []
        self.messages = self.errors = 0

    def ahead(self, now_ns: int) -> int:
        return max(len(self._done), (self._end_ns - now_ns) // self._timing.characters_ns(LONGEST))

    def feed(self, now_ns: int, data: bytes) -> None:
        if not data:
            return
        duration_ns = self._timing.characters_ns(len(data))
        begin_ns = max(now_ns, self._end_ns) if self._is_burst else now_ns - duration_ns
        if self._buffer or self._is_spoilt:
            silence_ns = begin_ns - self._end_ns
            if silence_ns >= self._silence_ns:
                self._on_silence(begin_ns)
            elif silence_ns > self._gap_ns and self._is_strict:
                self._is_spoilt = True
        self._buffer += data
        self._end_ns = max(begin_ns + duration_ns, self._end_ns)
        self._wish_ns = self._end_ns + self._silence_ns
        if len(self._buffer) > MOST_KEPT:
            self._buffer.clear()
            self._starts = [0]
            self._is_spoilt = True

    def next_ns(self) -> int | None:
        return self._wish_ns

    def take(self, now_ns: int) -> list[tuple[int, bytes]]:
        if self._wish_ns is not None and now_ns >= self._wish_ns:
            self._on_silence(now_ns)
        done, self._done = self._done, []
        return done

    def frame(self, unit: int, pdu: bytes) -> bytes:
        return rtu_frame(unit, pdu)

    def _on_silence(self, now_ns: int) -> None:
        """The line has been silent for at least 3.5 characters."""
        if not self._is_spoilt:
            for start in self._starts:
                frames = self._frames(bytes(self._buffer[start:]))
                if frames:
                    self.errors += start > 0
                    self.messages += len(frames)
                    self._done += [(frame[0], frame[1:-2]) for frame in frames]
                    self._forget()
                    return
        given_up_ns = self._end_ns + self._frame_timeout_ns
        if self._is_strict or self._is_spoilt or now_ns >= given_up_ns:
            self.errors += 1
            self._forget()
        else:
            self._starts.append(len(self._buffer))
            self._wish_ns = given_up_ns

    def _frames(self, data: bytes) -> list[bytes]:
        """The frames in the bytes between two silences; empty if they are damaged."""
        if is_frame(data):
            return [data]
        return [] if self._is_strict else split(data, self._size_of)

    def _forget(self) -> None:
        self._buffer.clear()
        self._starts = [0]
        self._is_spoilt = False
        self._wish_ns = None


def is_frame(data: bytes) -> bool:
    """True if `data` is one frame: 4 to 256 bytes with the right CRC at its end."""
    return SHORTEST <= len(data) <= LONGEST and crc16(data) == 0  # a CRC over its own bytes is 0


def split(data: bytes, size_of: Size = request_size) -> list[bytes]:
    """The frames of which `data` consists, with their CRCs; empty if it does not consist of complete, valid frames."""
    frames = []
    while data:
        size = size_of(data)
        if size is None or size > len(data) or crc16(data[:size]) != 0:
            return []
        frames.append(data[:size])
        data = data[size:]
    return frames
