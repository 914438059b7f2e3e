"""The fatal error panel, in which a master reads why the PAM has stopped (chapter 12.3, PAMS-056 to PAMS-060)."""

from datetime import datetime
from typing import Final

VME_PANEL: Final = 44
SERIAL_PANEL: Final = 0xFF0
"""Byte addresses in the DualPort; on a Simatic DualPort the panel is in front of WATCH_DOG."""
BEFORE_WATCH_DOG: Final = 0x0E


def panel_cells(origin: int, number: int, when: datetime, tag: int = 0, info: int = 0) -> tuple[int, ...]:
    """Return the seven cells: origin, number, date, time, tag, first information, and a reserved one.

    The parts of date and time begin at the most significant bit.  Hours are those of a clock with AM and PM.
    """
    is_afternoon = when.hour >= 12
    hour = when.hour - 12 if when.hour > 12 else when.hour
    year = when.year - 1990 & 0x3F
    date = year << 10 | when.month << 6 | when.day << 1 | is_afternoon
    time = hour << 12 | when.minute << 6 | when.second
    return origin & 0xFFFF, number & 0xFFFF, date, time, tag & 0xFFFF, info & 0xFFFF, 0
