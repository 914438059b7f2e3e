"""Mode_485, the byte that configures an encoder's serial interface; E4h as delivered is 9600 baud, even parity.

Known: E4h (SICK SEK34) is 9600 8E1, and the rates are 600 to 38400 (Phase Motion Control AxM-E), so bits 2-0 select
a rate.  Our reading of the others: bit 7 requires 55 bit times of silence before a request instead of 11; bit 6 selects
even parity; bit 5 enables parity; bits 4-3 are 0.
"""

from typing import Final, Literal

from fieldrig.clock import S
from fieldrig_bus.serial.message import Format

RATES: Final = (600, 1200, 2400, 4800, 9600, 19200, 38400)
_LONG_SILENCE, _EVEN, _PARITY, _RESERVED, _RATE = 0x80, 0x40, 0x20, 0x18, 0x07


def is_right(mode: int) -> bool:
    return mode & _RATE < len(RATES) and not mode & _RESERVED


def format_of(mode: int) -> Format:
    """Return the format, or 9600 8E1 for an invalid mode."""
    if not is_right(mode):
        return Format(9600, 8, "E", 1)
    parity: Literal["N", "E", "O"] = "N" if not mode & _PARITY else "E" if mode & _EVEN else "O"
    return Format(RATES[mode & _RATE], 8, parity, 1)


def silence_ns(mode: int) -> int:
    """Return the silence before a request, in nanoseconds."""
    return (55 if mode & _LONG_SILENCE else 11) * S // format_of(mode).baud
