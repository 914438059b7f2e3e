"""The drive's side of the line: sequential requests with time-outs and retries, without I/O.

A script is a generator that yields requests and is sent the answers, so that a sequence reads from top to bottom.

    def position() -> Script[int]:
        answer = yield Request(Command.READ_POSITION)
        return int.from_bytes(answer, "big")

Between an answer and the next request the line is idle for 6 ms, as with the drive named in `telegram`.
"""

from collections.abc import Generator
from typing import Final, Generic, NamedTuple, TypeVar

from fieldrig.clock import MS, S
from fieldrig_bus.serial.message import Format
from fieldrig_devices.hiperface.line import FORM
from fieldrig_devices.hiperface.telegram import (
    ANSWER_DATA,
    BROADCAST,
    ERROR_BIT,
    FACTORY_ADDRESS,
    Command,
    Status,
    about,
    answer_length,
    checksum,
    framed,
    longest_ns,
)

GAP_NS: Final = 6 * MS
RETRIES: Final = 5
GARBLED: Final = frozenset({Status.PARITY, Status.CHECKSUM})
"""Status messages about a request that arrived differently from how it was sent: the encoder has done nothing."""
RESET_NS: Final = 200 * MS
"""Time that a drive waits after a reset."""


class Request(NamedTuple):
    command: Command
    data: bytes = b""


T = TypeVar("T")
Script = Generator[Request, bytes, T]


class NoAnswerError(Exception):
    """No valid answer was received."""

    def __init__(self, command: Command, has_heard: bool) -> None:
        super().__init__(f"{'no valid answer' if has_heard else 'no answer'} to {command:02X}h")
        self.has_heard = has_heard
        """True if bytes were received, but no valid telegram."""


class AnsweredError(Exception):
    """The encoder refused the request."""

    def __init__(self, command: Command, status: int) -> None:
        super().__init__(f"the encoder refuses {command:02X}h with status {status:02X}h, {about(status)}")
        self.status = status


class Conversation(Generic[T]):
    """The run of a script.  Once `is_done`, `result` returns its result or raises its exception."""

    def __init__(
        self,
        script: Script[T],
        address: int = FACTORY_ADDRESS,
        *,
        retries: int = RETRIES,
        slack_ns: int = 20 * MS,
        form: Format = FORM,
    ) -> None:
        """`slack_ns` is added to the time that an answer may take on the line itself."""
        self._script, self._address = script, address
        self._retries, self._slack_ns = retries, slack_ns
        self._character_ns = form.bits_per_character * S // form.baud
        self._request: Request | None = None
        self._tries = 0
        self._has_heard = False
        self._heard = bytearray()
        self._send_ns: int | None = 0
        self._until_ns = 0
        self._result: T | None = None
        self._error: Exception | None = None
        self.is_done = False
        self._go_on(0, b"")

    def result(self) -> T:
        if self._error is not None:
            raise self._error
        assert self.is_done
        return self._result  # type: ignore[return-value]  # T may be None itself

    def next_ns(self) -> int | None:
        if self.is_done:
            return None
        return self._until_ns if self._send_ns is None else self._send_ns

    def due(self, now_ns: int) -> bytes:
        """Return the bytes to send now."""
        if self.is_done:
            return b""
        if self._send_ns is None and now_ns >= self._until_ns:
            self._failed(now_ns, None)
        if self.is_done or self._send_ns is None or now_ns < self._send_ns or self._request is None:
            return b""
        return self._sent(now_ns, self._request)

    def receive(self, now_ns: int, data: bytes) -> None:
        if self.is_done or self._request is None:
            return
        if self._send_ns is not None:
            self._send_ns = max(self._send_ns, now_ns + GAP_NS)  # late bytes of an abandoned answer
            return
        self._has_heard = True
        self._heard += data
        self._look(now_ns)

    def _sent(self, now_ns: int, request: Request) -> bytes:
        wire = framed(self._address, request.command, request.data)
        self._heard.clear()
        self._send_ns = None
        self._until_ns = now_ns + len(wire) * self._character_ns + longest_ns(request.command) + self._slack_ns
        if request.command == Command.RESET:
            self._until_ns = now_ns + RESET_NS
        else:
            self._until_ns += (3 + ANSWER_DATA[request.command]) * self._character_ns
            if request.command == Command.READ_DATA:
                self._until_ns += request.data[2] * self._character_ns
        return wire

    def _look(self, now_ns: int) -> None:
        """Look for the answer, from the first byte that it could begin with; True if it is complete."""
        heard, request = self._heard, self._request
        assert request is not None
        while heard and not self._may_begin(heard, request.command):
            del heard[0]
        length = answer_length(heard)
        if length is None or len(heard) < length:
            return
        answer = bytes(heard[:length])
        if checksum(answer):
            self._failed(now_ns, None)
        elif answer[1] & ~ERROR_BIT == request.command:
            self._go_on(now_ns, answer[2:-1])
        elif answer[2] in GARBLED:
            self._failed(now_ns, answer[2])
        else:
            self._throw(now_ns, AnsweredError(request.command, answer[2]))

    def _may_begin(self, heard: bytearray, command: Command) -> bool:
        is_from_it = self._address in (heard[0], BROADCAST)
        return is_from_it and (len(heard) < 2 or heard[1] & ~ERROR_BIT in (command, Command.READ_STATUS))

    def _failed(self, now_ns: int, status: int | None) -> None:
        """Retry after a missing or invalid answer, or one that says by its status that the request was; or give up."""
        assert self._request is not None
        if self._request.command == Command.RESET:
            self._go_on(now_ns, b"")
            return
        self._tries += 1
        if self._tries <= self._retries:
            self._send_ns = now_ns + GAP_NS
            return
        command = self._request.command
        refused = NoAnswerError(command, self._has_heard) if status is None else AnsweredError(command, status)
        self._throw(now_ns, refused)

    def _go_on(self, now_ns: int, answer: bytes) -> None:
        try:
            self._begin(now_ns, self._script.send(answer) if self._request is not None else next(self._script))
        except StopIteration as end:
            self._end(end.value, None)
        except (NoAnswerError, AnsweredError, ValueError) as wrong:
            self._end(None, wrong)

    def _throw(self, now_ns: int, wrong: Exception) -> None:
        try:
            self._begin(now_ns, self._script.throw(wrong))
        except StopIteration as end:
            self._end(end.value, None)
        except (NoAnswerError, AnsweredError, ValueError) as uncaught:
            self._end(None, uncaught)

    def _begin(self, now_ns: int, request: Request) -> None:
        self._send_ns = now_ns + GAP_NS if self._request is not None else now_ns
        self._request, self._tries, self._has_heard = request, 0, False

    def _end(self, result: T | None, error: Exception | None) -> None:
        self._result, self._error, self.is_done = result, error, True
