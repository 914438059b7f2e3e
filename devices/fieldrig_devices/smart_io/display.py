"""The seven-segment display of the keyboard 006.7012: the program's character, or a code of the node's own.

Source: Appendix F and B.2 for the codes.  The display has one digit, so a code of several characters is shown one
character after another, and a blank after them; the pace is ours.
"""

from collections.abc import Mapping
from enum import Enum, auto
from typing import Final

from fieldrig.clock import Clock, S
from fieldrig_devices.pamring.ends import RingFault
from fieldrig_devices.smart_io.font import POINT, segments_of

BLANK: Final = 0x20
RING_CODES: Final = {
    RingFault.NONE: "",
    RingFault.INACTIVE: "F 2",
    RingFault.CARRIER: "F-6",
    RingFault.CRC: "F-7",
}
HEAP: Final = "F 3"
PACE_NS: Final = S // 2
"""Time for each character of a code."""
RECOVERY_NS: Final = S
"""How long the code of a full FIFO is shown after it was full for the last time."""


class Phase(Enum):
    """The stages of the configuration."""

    ALONE = auto()
    NOT_CONFIGURED = auto()
    CONFIGURING = auto()
    WORKING = auto()


PHASE_CODES: Final = {Phase.NOT_CONFIGURED: "F 4", Phase.CONFIGURING: "8."}


class Display:
    """The contents of the display."""

    def __init__(self, clock: Clock, half_ns: int, font: Mapping[str, str]) -> None:
        """A blinking character is on for `half_ns`, and off as long; `font` has characters that differ."""
        self._clock, self._half_ns, self._font = clock, half_ns, font
        self.phase = Phase.ALONE
        self.ring = RingFault.NONE
        self.is_heap_full = False
        self._fifo, self._fifo_until_ns = 0, 0
        self.held_fifo = 0
        """A FIFO that stays full."""
        self.character = BLANK
        """The code of the character that a program shows."""
        self._blink_since_ns: int | None = None

    @property
    def is_blinking(self) -> bool:
        """True while the program's character, or a fatal code, blinks."""
        code = self.code
        return code.startswith("F ") if code else self._blink_since_ns is not None

    def blink(self, on: bool) -> None:
        if on != (self._blink_since_ns is not None):
            self._blink_since_ns = self._clock.now_ns() if on else None

    def clear(self) -> None:
        """Show nothing of a program."""
        self.character = BLANK
        self.blink(False)

    def show_full_fifo(self, number: int) -> None:
        """Show E and the number of a FIFO that is full, until it has recovered."""
        self._fifo, self._fifo_until_ns = number, self._clock.now_ns() + RECOVERY_NS

    @property
    def code(self) -> str:
        """The node's own code; an empty text without one."""
        if self.ring is not RingFault.NONE:
            return RING_CODES[self.ring]
        if self.is_heap_full:
            return HEAP
        if self.phase in PHASE_CODES:
            return PHASE_CODES[self.phase]
        if self.held_fifo:
            return f"E {self.held_fifo}"
        return f"E {self._fifo}" if self._clock.now_ns() < self._fifo_until_ns else ""

    @property
    def has_ring_leds(self) -> bool:
        """True if both LEDs of the ring are on, which the first node behind a fault of the ring shows (B.2)."""
        return self.ring in (RingFault.CARRIER, RingFault.CRC)

    @property
    def text(self) -> str:
        """The node's code, or the character of the program."""
        return self.code or chr(self.character)

    @property
    def segments(self) -> str:
        """The segments that are lit at this instant, of a to g and p for the point."""
        code, now_ns = self.code, self._clock.now_ns()
        if not code:
            since_ns = self._blink_since_ns
            is_dark = since_ns is not None and (now_ns - since_ns) // self._half_ns % 2
            return "" if is_dark else segments_of(self.character, self._font)
        if code == PHASE_CODES[Phase.CONFIGURING]:
            return segments_of(ord("8"), self._font) + POINT
        shown = f"{code} "[now_ns // PACE_NS % (len(code) + 1)]
        return segments_of(ord(shown), self._font)
