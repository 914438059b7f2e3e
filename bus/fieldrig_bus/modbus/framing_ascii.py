"""ASCII: a frame goes from a colon to CR LF, with each byte as two hexadecimal digits and an LRC at its end.

Source: Modbus over serial line V1.02, 2.5.2: a colon begins a new frame at any time; a frame is dropped after more than
a second between two characters; digits are 0 to 9 and A to F.  Another character may replace LF (diagnostics,
sub-function 3).
"""

from typing import Final

from fieldrig.clock import S
from fieldrig_bus.modbus.framing import LineTiming

TIMEOUT_NS: Final = 1 * S
COLON, CR, LF = b":\r\n"
DIGITS: Final = frozenset(b"0123456789ABCDEF")
LONGEST: Final = 2 * 255  # digits: unit, PDU of 253 bytes, LRC


def lrc(data: bytes) -> int:
    """The LRC of V1.02, 6.2.1, which makes the sum of all bytes 0."""
    return -sum(data) & 0xFF


def ascii_frame(unit: int, pdu: bytes, delimiter: int = LF) -> bytes:
    body = bytes((unit,)) + pdu
    digits = (body + bytes((lrc(body),))).hex().upper().encode()
    return bytes((COLON, *digits, CR, delimiter))


class AsciiFramer:
    """If `is_burst`, bytes are read ahead of the line's time (pty, TCP) and timed as if they came at its pace."""

    def __init__(self, timing: LineTiming, is_burst: bool = True) -> None:
        self._timing, self._is_burst = timing, is_burst
        self._digits: bytearray | None = None  # None: waiting for a colon
        self._has_cr = False
        self._heard_ns = self._end_ns = 0
        self._done: list[tuple[int, int, bytes]] = []
        self.delimiter = LF
        self.messages = self.errors = 0

    def ahead(self, now_ns: int) -> int:
        return max(len(self._done), (self._end_ns - now_ns) // self._timing.characters_ns(LONGEST))

    def feed(self, now_ns: int, data: bytes) -> None:
        if self._digits is not None and now_ns - self._heard_ns > TIMEOUT_NS:
            self._give_up()
        begin_ns = max(now_ns, self._end_ns)
        for count, character in enumerate(data, 1):
            self._end_ns = begin_ns + self._timing.characters_ns(count) if self._is_burst else now_ns
            self._on_character(character)
        self._heard_ns = max(now_ns, self._end_ns)

    def next_ns(self) -> int | None:
        if self._done:
            return self._done[0][0]
        return None if self._digits is None else self._heard_ns + TIMEOUT_NS + 1

    def take(self, now_ns: int) -> list[tuple[int, bytes]]:
        if self._digits is not None and now_ns - self._heard_ns > TIMEOUT_NS:
            self._give_up()
        ended = [(unit, pdu) for end_ns, unit, pdu in self._done if end_ns <= now_ns]
        del self._done[: len(ended)]
        return ended

    def frame(self, unit: int, pdu: bytes) -> bytes:
        return ascii_frame(unit, pdu, self.delimiter)

    def _on_character(self, character: int) -> None:
        digits = self._digits
        if character == COLON:
            self.errors += digits is not None
            self._digits, self._has_cr = bytearray(), False
        elif digits is None:
            return
        elif self._has_cr:
            self._on_end(digits) if character == self.delimiter else self._give_up()
        elif character == CR:
            self._has_cr = True
        elif character in DIGITS and len(digits) < LONGEST:
            digits.append(character)
        else:
            self._give_up()

    def _on_end(self, digits: bytearray) -> None:
        body = bytes.fromhex(digits.decode("ascii")) if len(digits) % 2 == 0 else b""
        if len(body) < 3 or sum(body) & 0xFF != 0:
            self._give_up()
            return
        self.messages += 1
        self._done.append((self._end_ns, body[0], body[1:-1]))
        self._digits, self._has_cr = None, False

    def _give_up(self) -> None:
        self.errors += 1
        self._digits, self._has_cr = None, False
