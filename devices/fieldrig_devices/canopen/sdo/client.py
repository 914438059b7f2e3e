"""SDO client: reads and writes objects of one other node, one transfer at a time.

Source: CiA 301 7.2.4.3, expedited and segmented transfers.  Left out: block transfer, which is for programs of many
kilobytes.  Frames that are not 8 bytes long are ignored.  A response for another object belongs to a transfer that was
abandoned before; it is dropped, and the time-out keeps running.
"""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from struct import Struct
from typing import Final

from fieldrig.clock import Alarm, Clock, S
from fieldrig.link import Link
from fieldrig_bus.can.frame import STANDARD_MASK, CanFrame
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.cob_id import EXTENDED_KEY
from fieldrig_devices.canopen.sdo.segmented import LAST, SEGMENT, TOGGLE
from fieldrig_devices.canopen.sdo.server import ABORTED, REQUEST_ID, RESPONSE_ID

TIMEOUT_NS: Final = 1 * S
LONGEST: Final = 1 << 20
"""Most bytes of an upload, so that a server cannot send forever."""

# First bytes of requests.
UPLOAD, UPLOAD_SEGMENT, DOWNLOAD_IN_SEGMENTS = 0x40, 0x60, 0x21
EXPEDITED_DOWNLOAD = {1: 0x2F, 2: 0x2B, 3: 0x27, 4: 0x23}
"""First byte of an expedited download by number of data bytes."""

# Server command specifiers.
SEGMENT_UPLOADED, SEGMENT_DOWNLOADED, UPLOADED, DOWNLOADED, ABORT = range(5)
EXPEDITED, SIZE_INDICATED = 0x02, 0x01

HEAD: Final = Struct("<BHB")


class _Transfer(ABC):
    """A download or upload."""

    def __init__(self, index: int, subindex: int) -> None:
        self.multiplexer = HEAD.pack(0, index, subindex)[1:]
        self._is_initiated = False
        self._toggle = 0

    @abstractmethod
    def first(self) -> bytes:
        """Return the request that initiates the transfer."""

    @abstractmethod
    def initiated(self, answer: bytes) -> bytes | None:
        """Return the request after the first response, or None at the end.  Raises Abort for a wrong response."""

    @abstractmethod
    def segment(self, answer: bytes) -> bytes | None:
        """Return the request after a later response, or None at the end.  Raises Abort for a wrong response."""

    @abstractmethod
    def finish(self, abort: Abort | None) -> None:
        """Report the result to the caller."""

    def on_answer(self, answer: bytes) -> bytes | None:
        if not self._is_initiated:
            self._is_initiated = True
            return self.initiated(answer)
        if answer[0] & TOGGLE != self._toggle:
            raise Abort(Code.TOGGLE_BIT_NOT_ALTERNATED)
        self._toggle ^= TOGGLE
        return self.segment(answer)

    def is_about(self, answer: bytes) -> bool:
        """True if the response may belong to this transfer; a response to a segment doesn't name its object."""
        is_named = answer[0] >> 5 == ABORT or not self._is_initiated
        return not is_named or answer[1:4] == self.multiplexer


class _Download(_Transfer):
    def __init__(self, index: int, subindex: int, data: bytes, done: Callable[[Abort | None], None]) -> None:
        super().__init__(index, subindex)
        self._data, self._position, self._done = data, 0, done

    def first(self) -> bytes:
        size = len(self._data)
        if size in EXPEDITED_DOWNLOAD:
            return bytes((EXPEDITED_DOWNLOAD[size],)) + self.multiplexer + self._data.ljust(4, b"\x00")
        return bytes((DOWNLOAD_IN_SEGMENTS,)) + self.multiplexer + size.to_bytes(4, "little")

    def initiated(self, answer: bytes) -> bytes | None:
        if answer[0] >> 5 != DOWNLOADED:
            raise Abort(Code.UNKNOWN_COMMAND_SPECIFIER)
        return None if len(self._data) in EXPEDITED_DOWNLOAD else self._next()

    def segment(self, answer: bytes) -> bytes | None:
        if answer[0] >> 5 != SEGMENT_DOWNLOADED:
            raise Abort(Code.UNKNOWN_COMMAND_SPECIFIER)
        return self._next() if self._position < len(self._data) else None

    def _next(self) -> bytes:
        segment = self._data[self._position : self._position + SEGMENT]
        self._position += SEGMENT
        is_last = self._position >= len(self._data)
        return bytes((self._toggle | SEGMENT - len(segment) << 1 | is_last,)) + segment.ljust(SEGMENT, b"\x00")

    def finish(self, abort: Abort | None) -> None:
        self._done(abort)


class _Upload(_Transfer):
    def __init__(self, index: int, subindex: int, done: Callable[[bytes | Abort], None]) -> None:
        super().__init__(index, subindex)
        self._data, self._done = bytearray(), done
        self._size: int | None = None

    def first(self) -> bytes:
        return bytes((UPLOAD,)) + self.multiplexer + bytes(4)

    def initiated(self, answer: bytes) -> bytes | None:
        command = answer[0]
        if command >> 5 != UPLOADED:
            raise Abort(Code.UNKNOWN_COMMAND_SPECIFIER)
        if command & EXPEDITED:
            size = 4 - (command >> 2 & 3) if command & SIZE_INDICATED else 4
            self._data += answer[4 : 4 + size]
            return None
        if command & SIZE_INDICATED:
            self._size = int.from_bytes(answer[4:], "little")
        return self._next()

    def segment(self, answer: bytes) -> bytes | None:
        command = answer[0]
        if command >> 5 != SEGMENT_UPLOADED:
            raise Abort(Code.UNKNOWN_COMMAND_SPECIFIER)
        self._data += answer[1 : 8 - (command >> 1 & 7)]
        self._check(is_last=bool(command & LAST))
        return None if command & LAST else self._next()

    def _next(self) -> bytes:
        return bytes((UPLOAD_SEGMENT | self._toggle, 0, 0, 0, 0, 0, 0, 0))

    def _check(self, *, is_last: bool) -> None:
        size = len(self._data)
        if self._size is not None and size > self._size:
            raise Abort(Code.LENGTH_TOO_HIGH)
        if self._size is not None and is_last and size < self._size:
            raise Abort(Code.LENGTH_TOO_LOW)
        if size > LONGEST:
            raise Abort(Code.OUT_OF_MEMORY)

    def finish(self, abort: Abort | None) -> None:
        self._done(bytes(self._data) if abort is None else abort)


class SdoClient:
    """The client of node `node_id`, on its first SDO channel.  `can` is a link of its own."""

    def __init__(self, clock: Clock, can: Link[CanFrame], node_id: int, timeout_ns: int = TIMEOUT_NS) -> None:
        self._clock, self._can, self._timeout_ns = clock, can, timeout_ns
        self._request_id = REQUEST_ID + node_id
        self._timeout = Alarm(clock)
        self._waiting: deque[_Transfer] = deque()
        self._transfer: _Transfer | None = None
        can.on_receive(self._on_frame, [[RESPONSE_ID + node_id, EXTENDED_KEY | STANDARD_MASK]])

    def download(self, index: int, subindex: int, data: bytes, done: Callable[[Abort | None], None]) -> None:
        """Write `data`; `done` receives None, or the abort."""
        self._ask(_Download(index, subindex, data, done))

    def upload(self, index: int, subindex: int, done: Callable[[bytes | Abort], None]) -> None:
        """Read an object; `done` receives the data, or the abort.

        An expedited response without a size has four bytes.
        """
        self._ask(_Upload(index, subindex, done))

    def cancel(self) -> None:
        """Drop all transfers without notifying the server or the callers, because the server was reset or is lost."""
        self._waiting.clear()
        self._transfer = None
        self._timeout.stop()

    @property
    def is_busy(self) -> bool:
        return self._transfer is not None

    def _ask(self, transfer: _Transfer) -> None:
        self._waiting.append(transfer)
        self._go_on()

    def _go_on(self) -> None:
        if self._transfer is None and self._waiting:
            self._transfer = self._waiting.popleft()
            self._send(self._transfer.first())

    def _send(self, request: bytes) -> None:
        self._timeout.after(self._timeout_ns, self._on_timeout)
        self._can.send(CanFrame(self._request_id, request))

    def _on_frame(self, frame: CanFrame) -> None:
        transfer, answer = self._transfer, frame.data
        if transfer is None or len(answer) != 8 or not transfer.is_about(answer):
            return
        if answer[0] >> 5 == ABORT:
            self._end(Abort(int.from_bytes(answer[4:], "little")))
            return
        try:
            request = transfer.on_answer(answer)
        except Abort as abort:
            self._abort(transfer, abort)
            return
        if request is None:
            self._end(None)
        else:
            self._send(request)

    def _on_timeout(self) -> None:
        if self._transfer is not None:
            self._abort(self._transfer, Abort(Code.PROTOCOL_TIMED_OUT))

    def _abort(self, transfer: _Transfer, abort: Abort) -> None:
        self._can.send(CanFrame(self._request_id, ABORTED.pack(0x80, transfer.multiplexer, abort.code)))
        self._end(abort)

    def _end(self, abort: Abort | None) -> None:
        transfer, self._transfer = self._transfer, None
        self._timeout.stop()
        if transfer is not None:
            transfer.finish(abort)
        self._go_on()
