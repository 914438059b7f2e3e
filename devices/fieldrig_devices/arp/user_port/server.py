"""The card's side of its USER port: it answers a PC's requests in every state, and reports changes.

Source: manual 4.0 (the serial link is always active, and the state code can be read at any time), 5.2; digest chapters
10, 17, 20.  WinAxis' protocol is not published, so this one is ours: docs/devices/arp/arp-user-port.md specifies every
byte.

A request is carried out once, however often its frame arrives: if it equals the last request, including the sequence
number, the card repeats the answer.  Garbage and damaged frames are dropped silently.  An unsolicited message waits
until the line has carried earlier data, so an answer waits for at most one such frame.  Left out: any protection
against unauthorized PCs, since the card has none.
"""

import logging
import struct
from typing import Annotated, Final

from pydantic import Field

from fieldrig.clock import MS, Clock, S
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig_bus.serial.message import Format, SerialMessage
from fieldrig_devices.arp.card_access import CardAccess, Progress
from fieldrig_devices.arp.user_port.debugging import DebugRequests, condition, news
from fieldrig_devices.arp.user_port.framing import Deframer, encode
from fieldrig_devices.arp.user_port.handlers import Handlers, bare
from fieldrig_devices.arp.user_port.memory import MemoryRequests
from fieldrig_devices.arp.user_port.messages import (
    ANSWER,
    ANY_CARD,
    EVENT,
    HIGHEST_REQUEST,
    LARGEST_DATA,
    LONGEST_TEXT,
    PROGRESS,
    SAMPLES,
    STEPS,
    UNNUMBERED,
    VERSION,
    Command,
    Identity,
    Message,
    RequestError,
    Status,
)
from fieldrig_devices.arp.user_port.trace import Trace
from fieldrig_devices.arp.user_port.transfer import TransferRequests

log = logging.getLogger(__name__)

SILENCE_NS: Final = 10 * S
"""Silence after which the PC counts as gone: a partial download is dropped, trace and events end.  Breakpoints stay."""
AHEAD_NS: Final = 5 * MS
"""Unsolicited messages are sent if the line has at most this much left to carry."""
PROGRESS_NS: Final = 50 * MS
"""Shortest time between two reports of progress."""


class UserPortSettings(Settings):
    baud: Annotated[int, Field(ge=300, le=10_000_000, description="bit rate at which the card sends, in bit/s")] = 9600


class UserPort:
    """The port, created by the card if it has a line: `start` at power-on, `tick` once in every control loop."""

    def __init__(
        self, clock: Clock, line: Link[SerialMessage], card: CardAccess, settings: UserPortSettings | None = None
    ) -> None:
        self._clock, self._line, self._card = clock, line, card
        self._format = Format((settings or UserPortSettings()).baud)
        self._character_ns = self._format.bits_per_character * S // self._format.baud
        self._free_ns = 0  # time at which the line has carried all data sent so far
        self._deframer = Deframer()
        self._transfer, self._trace = TransferRequests(card, self._on_outcome), Trace(card)
        debugging = DebugRequests(card, self._report_again)
        self._handlers: Handlers = {
            Command.HELLO: bare(self._hello),
            Command.EVENTS: self._set_events,
            **debugging.handlers,
            **MemoryRequests(card).handlers,
            **self._transfer.handlers,
            **self._trace.handlers,
        }
        self._last_request: Message | None = None
        self._last_answer = b""
        self._unanswered: Message | None = None  # request whose answer comes later
        self._reported_progress: Progress | None = None
        self._next_progress_ns = 0
        self._heard_ns: int | None = None  # time of the last valid request; None without a PC
        self._has_events = False
        self._reported: object = None
        self._unasked = 0  # sequence number of unsolicited messages
        self._loop = 0
        line.on_receive(self._on_bytes)

    def start(self) -> None:
        self._line.send(self._format)

    def tick(self) -> None:
        """Send unsolicited messages, once in every control loop, after the program's slice."""
        self._loop = self._loop + 1 & 0xFFFF_FFFF
        if self._heard_ns is None:
            return
        now_ns = self._clock.now_ns()
        if now_ns - self._heard_ns > SILENCE_NS:
            self._end_session()
            return
        if self._trace.is_on:
            self._trace.tick(self._loop)
        if self._free_ns - now_ns <= AHEAD_NS:
            self._report()

    # ---- requests

    def _on_bytes(self, data: SerialMessage) -> None:
        if isinstance(data, bytes):
            for body in self._deframer.feed(data):
                self._on_request(Message.decode(body))

    def _on_request(self, request: Message) -> None:
        is_for_any = request.address == ANY_CARD and request.command == Command.HELLO
        if (request.address != self._card.number and not is_for_any) or request.command > HIGHEST_REQUEST:
            log.debug("not for card %02d: %s", self._card.number, request)
            return
        self._heard_ns = self._clock.now_ns()
        if request.sequence == UNNUMBERED or request != self._last_request:
            status, data = self._outcome(request)
            answer = b"" if data is None else self._answer(request, status, data)
            if data is None:
                self._unanswered = request
            if request.sequence != UNNUMBERED:
                self._last_request, self._last_answer = request, answer
        else:
            answer = self._last_answer
        if answer:
            self._send(answer)

    def _answer(self, request: Message, status: Status, data: bytes) -> bytes:
        return Message(self._card.number, request.sequence, request.command | ANSWER, bytes((status,)) + data).encode()

    def _on_outcome(self, refusal: RequestError | None) -> None:
        """Answer the request that was not answered at once."""
        request, self._unanswered, self._reported_progress = self._unanswered, None, None
        assert request is not None, "the card has accepted a program that was not committed"
        if refusal is None:
            answer = self._answer(request, Status.OK, b"")
        else:
            answer = self._answer(request, refusal.status, refusal.text.encode()[:LONGEST_TEXT])
        if request == self._last_request:
            self._last_answer = answer
        self._send(answer)

    def _outcome(self, request: Message) -> tuple[Status, bytes | None]:
        if request.version != VERSION:
            return Status.VERSION, b""
        handler = self._handlers.get(request.command)
        if handler is None:
            return Status.COMMAND, b""
        try:
            return Status.OK, handler(request.data)
        except struct.error:
            return Status.LENGTH, b""
        except RequestError as cause:
            log.debug("%s: %s", request, cause)
            return cause.status, cause.text.encode()[:LONGEST_TEXT]

    def _hello(self) -> bytes:
        """Begin a session.  Nothing is left of an earlier one, apart from breakpoints."""
        self._end_session()
        self._last_request = None
        self._heard_ns = self._clock.now_ns()
        return Identity(self._card.number, LARGEST_DATA, self._card.program_name[:LONGEST_TEXT]).encode()

    def _end_session(self) -> None:
        self._heard_ns = None
        self._has_events = False
        self._trace.stop()
        self._transfer.drop()
        self._unanswered = None

    # ---- unsolicited messages

    def _set_events(self, data: bytes) -> bytes:
        (switch,) = struct.unpack("<B", data)
        if switch > 1:
            raise RequestError(Status.RANGE, "expected 0 (off) or 1 (on)")
        self._has_events, self._reported = bool(switch), None
        return b""

    def _report_again(self) -> None:
        """Report the state again, so that a program that was started is reported even if it stops again at once."""
        self._reported = None

    def _report(self) -> None:
        """Send at most one unsolicited message."""
        if self._unanswered is not None and self._report_progress():
            return
        if self._has_events:
            now = news(self._card)
            if now != self._reported:
                self._reported = now
                self._send_unasked(EVENT, condition(self._card).encode())
                return
        if samples := self._trace.take():
            self._send_unasked(SAMPLES, samples)

    def _report_progress(self) -> bool:
        """Report the progress of a program that is being loaded, if it is time for that."""
        now_ns, progress = self._clock.now_ns(), self._card.loading
        if progress is None or progress == self._reported_progress or now_ns < self._next_progress_ns:
            return False
        self._reported_progress, self._next_progress_ns = progress, now_ns + PROGRESS_NS
        self._send_unasked(PROGRESS, STEPS.pack(progress.done, progress.steps) + progress.what.encode())
        return True

    def _send_unasked(self, what: int, data: bytes) -> None:
        self._unasked = self._unasked + 1 & 0xFF
        self._send(Message(self._card.number, self._unasked, what, data).encode())

    def _send(self, body: bytes) -> None:
        wire = encode(body)
        self._free_ns = max(self._free_ns, self._clock.now_ns()) + len(wire) * self._character_ns
        self._line.send(wire)
