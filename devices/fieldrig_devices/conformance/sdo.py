"""The suite's SDO client, which can use each protocol and also send single messages that violate it.

Source: CiA 301 7.2.4.3.  It shares no code with the node's server, so that a misreading there isn't repeated here.
"""

from collections.abc import Callable
from struct import Struct
from typing import NamedTuple

from fieldrig.clock import MS
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.verdict import Aborted, Lost, NoAnswer, Violation

ABORT = 0x80
NOTHING = bytes(4)
_ABORT = Struct("<4xL")

Expect = Callable[[int, float], Steps[CanFrame | None]]


MARGIN = 3
"""Ratio of the time-out to the slowest recent answer."""
MOST_UNANSWERED = 5
"""Requests in a row without an answer after which the suite asks no more in a case."""
MOST_LATE = 200
"""Late answers in a row that are dropped before the next request; a block transfer leaves up to 127."""
LARGEST = 1 << 20
"""Most bytes of one upload, as a node may never send the last segment."""
FADING = 0.98
"""Factor applied to the slowest time with each answer, so that a short stall of the host is forgotten."""


class Patience(NamedTuple):
    """Time-outs, in milliseconds: the usual one, the one before the first answer, and the longest."""

    usual_ms: float
    first_ms: float
    longest_ms: float


class Sdo:
    """Client of a server that receives at the first of the identifiers and answers at the second.

    The time-out adapts to the node: the first one is long, and later ones follow the slowest recent answer.  An answer
    that arrives after its time-out is dropped before the next request is sent, so that it isn't mistaken for the answer
    to that request.
    """

    def __init__(
        self,
        send: Callable[[int, bytes], None],
        expect: Expect,
        now_ns: Callable[[], int],
        identifiers: tuple[int, int],
        patience: Patience,
    ) -> None:
        self._send, self._expect, self._now_ns = send, expect, now_ns
        self.request_id, self.response_id = identifiers
        self._patience = patience
        self.within_ms = patience.first_ms
        self.slowest_ms = 0.0
        """Duration of the slowest recent answer."""
        self._asked_ns = 0
        self._is_owed = False
        """True if the last request timed out, so that its answer may still arrive."""
        self.late: list[str] = []
        """A note for each answer that arrived after its time-out; the suite reports them and clears the list."""
        self.requests = 0
        """Number of requests until now."""
        self.asked = ""
        """Content of the last request whose answer was awaited."""
        self.unanswered = 0
        """Requests without an answer since the last answer."""

    # Single messages.

    def send(self, request: bytes) -> None:
        self._asked_ns, self.requests = self._now_ns(), self.requests + 1
        self._send(self.request_id, request.ljust(8, b"\x00"))

    def drain(self) -> Steps[None]:
        """Wait for an outstanding answer and drop it, and so with the abort of a transfer that it left open."""
        wait_ms = max(self.within_ms, self._patience.first_ms)
        for _ in range(MOST_LATE if self._is_owed else 0):
            frame = yield from self._expect(self.response_id, wait_ms)
            self._is_owed = frame is not None
            if frame is None:
                return
            if len(self.late) < MOST_LATE:
                before_ms = self.within_ms
                took_ms = self._note_time()
                self.late.append(
                    f"an answer arrived {took_ms:.0f} ms after its request and was dropped; the time-out was"
                    f" {before_ms:.0f} ms and is {self.within_ms:.0f} ms from now on"
                )

    def _note_time(self) -> float:
        """Adapt the time-out to the answer that has just arrived, and return its duration in milliseconds."""
        took_ms = (self._now_ns() - self._asked_ns) / MS
        self.slowest_ms = max(took_ms, FADING * self.slowest_ms)
        if self.within_ms == self._patience.first_ms:
            self.within_ms = self._patience.usual_ms
        self.within_ms = min(max(self.within_ms, MARGIN * took_ms), self._patience.longest_ms)
        return took_ms

    def answer(self, what: str, within_ms: float | None = None) -> Steps[bytes]:
        """Return the next 8 bytes.

        Raises Aborted, NoAnswer, Violation for another length, or Lost if the last answers failed to come, too.
        """
        self.asked = what
        frame = yield from self._expect(self.response_id, self.within_ms if within_ms is None else within_ms)
        if frame is None:
            self._is_owed = True
            self.unanswered += 1
            if self.unanswered >= MOST_UNANSWERED:
                raise Lost(f"an answer to {what}", f"none to the last {self.unanswered} requests")
            raise NoAnswer(f"no answer to {what}")
        self.unanswered = 0
        if within_ms is None:
            self._note_time()
        if len(frame.data) != 8:
            raise Violation(f"an answer of {len(frame.data)} bytes to {what}, expected 8")
        if frame.data[0] == ABORT:
            raise Aborted(_ABORT.unpack(frame.data)[0], what)
        return frame.data

    def ask(self, request: bytes, what: str, within_ms: float | None = None) -> Steps[bytes]:
        yield from self.drain()
        self.send(request)
        return (yield from self.answer(what, within_ms))

    def abort(self, index: int, sub: int, code: int = 0x0800_0000) -> None:
        """Abort a transfer from this side; the server doesn't answer."""
        self.send(bytes((ABORT,)) + multiplexer(index, sub) + code.to_bytes(4, "little"))

    # Upload.

    def read(self, index: int, sub: int = 0) -> Steps[bytes]:
        """Read an object, expedited or in segments, as the server chooses."""
        what = f"reading {key(index, sub)}"
        answer = yield from self.initiate_upload(index, sub)
        if answer[0] & 0x02:
            return expedited_data(answer, what)
        return (yield from self.upload_segments(answer, what))

    def initiate_upload(self, index: int, sub: int) -> Steps[bytes]:
        what = f"reading {key(index, sub)}"
        answer = yield from self.ask(b"\x40" + multiplexer(index, sub), what)
        if answer[0] & 0xF0 != 0x40:
            raise Violation(f"command {answer[0]:02X}h in the answer to {what}, expected 41h to 4Fh")
        _check_multiplexer(answer, index, sub, what)
        return answer

    def upload_segments(self, initiated: bytes, what: str) -> Steps[bytes]:
        """Read the segments after an initiation.  Raises Violation for a wrong toggle bit or size."""
        data, toggle = bytearray(), 0
        size = int.from_bytes(initiated[4:], "little")
        most = min(size, LARGEST) if initiated[0] & 1 else LARGEST
        while True:
            answer = yield from self.ask(bytes((0x60 | toggle << 4,)), f"a segment of {what}")
            if answer[0] & 0xF0 != toggle << 4:
                raise Violation(f"command {answer[0]:02X}h in a segment of {what}, expected {toggle << 4:02X}h")
            data += answer[1 : 8 - (answer[0] >> 1 & 7)]
            toggle ^= 1
            if answer[0] & 1:
                break
            if len(data) > most:
                raise Violation(f"{len(data)} bytes in the segments of {what} without the last one, after {most}")
        if initiated[0] & 1 and size != len(data):
            raise Violation(f"{len(data)} bytes in the segments of {what}, but {size} were announced")
        return bytes(data)

    # Download.

    def write(self, index: int, sub: int, data: bytes, within_ms: float | None = None) -> Steps[None]:
        """Write an object, expedited up to 4 bytes and otherwise in segments."""
        if not 0 < len(data) <= 4:
            yield from self.write_segments(index, sub, data, within_ms)
            return
        first = 0x23 | (4 - len(data)) << 2
        what = f"writing {data.hex(' ')} to {key(index, sub)}"
        answer = yield from self.ask(bytes((first,)) + multiplexer(index, sub) + data, what, within_ms)
        _check_command(answer, 0x60, 0xE0, what)
        _check_multiplexer(answer, index, sub, what)

    def write_segments(self, index: int, sub: int, data: bytes, within_ms: float | None = None) -> Steps[None]:
        what = f"writing {key(index, sub)} in segments"
        answer = yield from self.ask(b"\x21" + multiplexer(index, sub) + len(data).to_bytes(4, "little"), what)
        _check_command(answer, 0x60, 0xE0, what)
        _check_multiplexer(answer, index, sub, what)
        toggle = 0
        for start in range(0, max(len(data), 1), 7):
            part, is_last = data[start : start + 7], start + 7 >= len(data)
            first = toggle << 4 | (7 - len(part)) << 1 | is_last
            answer = yield from self.ask(bytes((first,)) + part, f"a segment of {what}", within_ms if is_last else None)
            _check_command(answer, 0x20 | toggle << 4, 0xF0, f"a segment of {what}")
            toggle ^= 1


def key(index: int, sub: int) -> str:
    return f"{index:04X}h:{sub:02X}h"


def multiplexer(index: int, sub: int) -> bytes:
    return index.to_bytes(2, "little") + bytes((sub,))


def expedited_data(answer: bytes, what: str) -> bytes:
    """Return the data of an expedited answer to an upload request.  Raises Violation if it has no size."""
    if not answer[0] & 1:
        raise Violation(f"no size in the expedited answer to {what}")
    return answer[4 : 8 - (answer[0] >> 2 & 3)]


def _check_command(answer: bytes, right: int, mask: int, what: str) -> None:
    if answer[0] & mask != right:
        raise Violation(f"command {answer[0]:02X}h in the answer to {what}, expected {right:02X}h")


def _check_multiplexer(answer: bytes, index: int, sub: int, what: str) -> None:
    if answer[1:4] != multiplexer(index, sub):
        raise Violation(f"index and sub-index {answer[1:4].hex(' ')} in the answer to {what}")
