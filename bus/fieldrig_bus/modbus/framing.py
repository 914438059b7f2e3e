"""The duration of characters on a serial line, and what a framer is: it turns bytes and time into frames.

Source: Modbus over serial line V1.02, 2.5.1 (RTU) and 2.5.2 (ASCII).
"""

from dataclasses import dataclass
from typing import Literal, Protocol

from fieldrig.clock import US, S

Mode = Literal["rtu", "ascii"]

FAST_BAUD = 19200
"""Above this baud rate the silent intervals of RTU are fixed (2.5.1.1)."""


@dataclass(frozen=True, slots=True)
class LineTiming:
    mode: Mode = "rtu"
    baud: int = FAST_BAUD
    bits_per_character: int = 11

    def characters_ns(self, count: float) -> int:
        return int(count * self.bits_per_character * S) // self.baud

    @property
    def gap_ns(self) -> int:
        """t1.5, the longest silence within an RTU frame."""
        return self.characters_ns(1.5) if self.baud <= FAST_BAUD else 750 * US

    @property
    def silence_ns(self) -> int:
        """t3.5, the silence that ends an RTU frame.  ASCII frames end with a delimiter."""
        if self.mode == "ascii":
            return 0
        return self.characters_ns(3.5) if self.baud <= FAST_BAUD else 1750 * US

    def frame_ns(self, pdu_size: int) -> int:
        """The duration of a frame with a PDU of this size on the line."""
        return self.characters_ns(2 * pdu_size + 7 if self.mode == "ascii" else pdu_size + 3)


class LineFramer(Protocol):
    """The receiver of one serial line."""

    messages: int
    errors: int

    def ahead(self, now_ns: int) -> int:
        """How many frames were read that have not ended on the line yet.  Other characters count as longest frames."""

    def feed(self, now_ns: int, data: bytes) -> None:
        """Accept bytes that were read at `now_ns`."""

    def next_ns(self) -> int | None:
        """The instant at which `take` should be called next if nothing else arrives; None while the line is idle."""

    def take(self, now_ns: int) -> list[tuple[int, bytes]]:
        """Take unit and PDU of every frame that has ended by `now_ns`."""

    def frame(self, unit: int, pdu: bytes) -> bytes:
        """The bytes of a frame."""
