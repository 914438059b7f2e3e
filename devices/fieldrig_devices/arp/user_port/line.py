"""The PC's end of the line to an ARP card's USER port: it sends requests and keeps unsolicited messages.

A request without an answer in time is sent again, which is harmless: the card carries it out once (see `server`).
"""

from collections import deque
from collections.abc import Callable, Iterator
from typing import Any, Final

import serial
from serial import serialutil

from fieldrig.errors import BusError
from fieldrig_devices.arp.user_port.framing import Deframer, encode
from fieldrig_devices.arp.user_port.messages import ANSWER, ANY_CARD, EVENT, LARGEST_DATA, SAMPLES, Message

# pyserial has no types
_Timeout: Final[Any] = serialutil.Timeout
_serial_for_url: Final[Any] = serial.serial_for_url

READ_S: Final = 0.05
"""How long one read of the port waits; what is waited for longer is waited for in several."""
KEEP_S: Final = 3.0
"""How often a PC that only listens shows that it is there; the card waits for 10 s."""
KEPT: Final = 1_000
"""Messages told unasked that nobody has fetched yet; older ones are forgotten."""


class NoAnswerError(BusError):
    """Nobody answers at this port."""


class CardLine:
    def __init__(self, line: Any, timeout_s: float, retries: int) -> None:
        """`line` is an open port of pyserial whose reads wait for a moment only."""
        self._line, self._timeout_s, self._retries = line, timeout_s, retries
        self._deframer = Deframer()
        self._kept: dict[int, deque[Message]] = {EVENT: deque(maxlen=KEPT), SAMPLES: deque(maxlen=KEPT)}
        self._answers: deque[Message] = deque(maxlen=KEPT)
        self._quiet = _Timeout(KEEP_S)

    def close(self) -> None:
        self._line.close()

    def ask(self, request: Message, patience_s: float = 0.0) -> Message:
        """The answer; `patience_s` is how long to go on asking, where that is longer than usual."""
        self._answers.clear()
        self._quiet = _Timeout(KEEP_S)
        wire = encode(request.encode())
        for _ in range(max(1 + self._retries, int(patience_s / self._timeout_s))):
            self._on_port(lambda: self._line.write(wire))
            timeout = _Timeout(self._timeout_s)
            while not timeout.expired():
                self._read()
                if (answer := self._answer_to(request)) is not None:
                    return answer
        who = "no card answers" if request.address == ANY_CARD else f"card {request.address:02} doesn't answer"
        raise NoAnswerError(
            f"{who} at {self._line.port}", "is its rig up, and is this the line of its USER port, with its baud rate?"
        )

    def told(self, what: int, patience_s: float, keep: Callable[[], object]) -> Message | None:
        """The next one of what is told unasked; None if none comes in this time.  `keep` is called now and then."""
        kept, timeout = self._kept[what], _Timeout(patience_s)
        while not kept and not timeout.expired():
            self._read()
            if self._quiet.expired():
                keep()
        return kept.popleft() if kept else None

    def paced(self, seconds: float) -> Iterator[None]:
        """For ever: at once, and then each so many seconds, to within `READ_S`."""
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
            is_from_it = request.address in (answer.address, ANY_CARD)
            if (
                is_from_it
                and answer.data
                and (answer.sequence, answer.command) == (request.sequence, request.command | ANSWER)
            ):
                return answer
        return None

    def _read(self) -> None:
        """What comes within a moment."""
        data: bytes = self._on_port(lambda: self._line.read(1))
        if data:
            data += self._on_port(lambda: self._line.read(self._line.in_waiting))
        for body in self._deframer.feed(data):
            message = Message.decode(body)
            self._kept.get(message.command, self._answers).append(message)

    def _on_port(self, act: Callable[[], Any]) -> Any:
        try:
            return act()
        except (serial.SerialException, OSError) as cause:
            raise BusError(f"{self._line.port} is gone: {cause}", "has its rig ended? start it again") from cause


def open_line(port: str, baud: int, timeout_s: float, retries: int) -> CardLine:
    """BusError, with its remedy, if the port can't be had."""
    try:
        line = _serial_for_url(port, baud, timeout=READ_S)
    except (serial.SerialException, OSError, ValueError) as cause:
        raise BusError(
            f"can't open {port}: {cause}", "right would be a device, a pty, socket://HOST:PORT or rfc2217://HOST:PORT"
        ) from cause
    longest_s = 20 * LARGEST_DATA / baud  # of a request and its answer, at 10 bits an octet
    return CardLine(line, timeout_s + longest_s, retries)
