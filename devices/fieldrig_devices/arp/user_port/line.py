"""The PC's end of the line to an ARP card's USER port: it sends requests and keeps unsolicited messages.

A request without an answer in time is sent again, which is harmless: the card carries it out once (see `server`).
"""

from collections import deque
from collections.abc import Callable, Iterator
from typing import Any, Final

import serial
from serial import serialutil

from fieldrig.errors import BusError
from fieldrig_bus.serial.port_errors import reason
from fieldrig_bus.serial.reading import read_arrived
from fieldrig_devices.arp.user_port.framing import Deframer, encode
from fieldrig_devices.arp.user_port.messages import ANSWER, ANY_CARD, EVENT, LARGEST_DATA, PROGRESS, SAMPLES, Message

# pyserial has no types
_Timeout: Final[Any] = serialutil.Timeout
_serial_for_url: Final[Any] = serial.serial_for_url

READ_S: Final = 0.05
"""Time that one read of the port waits, in seconds; a longer wait consists of several reads."""
KEEP_S: Final = 3.0
"""Period at which a PC that only listens sends a request, in seconds; the card's limit is 10 s."""
KEPT: Final = 1_000
"""Maximum number of unsolicited messages that wait to be fetched; older messages are dropped."""


class NoAnswerError(BusError):
    """No card answers at this port."""


class CardLine:
    def __init__(self, line: Any, timeout_s: float, retries: int) -> None:
        """`line` is an open port of pyserial with a short read timeout."""
        self._line, self._timeout_s, self._retries = line, timeout_s, retries
        self._deframer = Deframer()
        self._kept: dict[int, deque[Message]] = {EVENT: deque(maxlen=KEPT), SAMPLES: deque(maxlen=KEPT)}
        self._kept[PROGRESS] = deque(maxlen=KEPT)
        self._answers: deque[Message] = deque(maxlen=KEPT)
        self._quiet = _Timeout(KEEP_S)

    def close(self) -> None:
        self._line.close()

    def ask(
        self, request: Message, patience_s: float = 0.0, on_progress: Callable[[bytes], None] | None = None
    ) -> Message:
        """Send a request and return the answer; `patience_s` extends the time for retries beyond the usual.

        It begins again with each PROGRESS, whose data `on_progress` is called with.
        """
        self._answers.clear()
        self._kept[PROGRESS].clear()
        self._quiet = _Timeout(KEEP_S)
        wire = encode(request.encode())
        tries = left = max(1 + self._retries, int(patience_s / self._timeout_s))
        while left > 0:
            left -= 1
            self._on_port(lambda: self._line.write(wire))
            timeout = _Timeout(self._timeout_s)
            while not timeout.expired():
                self._read()
                while on_progress is not None and self._kept[PROGRESS]:
                    on_progress(self._kept[PROGRESS].popleft().data)
                    left = tries
                if (answer := self._answer_to(request)) is not None:
                    return answer
        what = "no card answers" if request.address == ANY_CARD else f"card {request.address:02} does not answer"
        raise NoAnswerError(
            f"{what} at {self._line.port}", "check that its rig runs, and that this is its USER port with its baud rate"
        )

    def unsolicited(self, what: int, patience_s: float, keep: Callable[[], object]) -> Message | None:
        """The next unsolicited message, or None if none arrives in time.

        It calls `keep` at intervals to keep the session.
        """
        kept, timeout = self._kept[what], _Timeout(patience_s)
        while not kept and not timeout.expired():
            self._read()
            if self._quiet.expired():
                keep()
        return kept.popleft() if kept else None

    def paced(self, seconds: float) -> Iterator[None]:
        """Yield at once, and then every `seconds` without end, to within `READ_S`."""
        while True:
            timeout = _Timeout(seconds)
            yield
            while not timeout.expired():
                self._read()

    def forget(self, what: int) -> None:
        self._kept[what].clear()

    def _answer_to(self, request: Message) -> Message | None:
        while self._answers:
            answer = self._answers.popleft()
            is_from_card = request.address in (answer.address, ANY_CARD)
            if (
                is_from_card
                and answer.data
                and (answer.sequence, answer.command) == (request.sequence, request.command | ANSWER)
            ):
                return answer
        return None

    def _read(self) -> None:
        """Read for a moment, and sort the messages that arrive."""
        for body in self._deframer.feed(self._on_port(lambda: read_arrived(self._line))):
            message = Message.decode(body)
            self._kept.get(message.command, self._answers).append(message)

    def _on_port(self, act: Callable[[], Any]) -> Any:
        try:
            return act()
        except (serial.SerialException, OSError) as cause:
            raise BusError(f"{self._line.port} is lost: {cause}", "check that its rig still runs") from cause


def open_line(port: str, baud: int, timeout_s: float, retries: int) -> CardLine:
    """Open a port.  Raises BusError, with its remedy, if the port is not available."""
    try:
        line = _serial_for_url(port, baud, timeout=READ_S)
    except (serial.SerialException, OSError, ValueError) as cause:
        raise BusError(
            f"cannot open {port}: {reason(cause)}",
            "expected a device, a pty, socket://HOST:PORT or rfc2217://HOST:PORT",
        ) from cause
    longest_s = 20 * LARGEST_DATA / baud  # time of a request and its answer, at 10 bits per octet
    return CardLine(line, timeout_s + longest_s, retries)
