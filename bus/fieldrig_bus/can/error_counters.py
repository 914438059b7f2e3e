"""The limits of the error counters, and the state of a controller that follows from them.

Source: ISO 11898-1:2015, 12.1.4 (fault confinement; Bosch CAN 2.0, chapter 8, has the same rules).
"""

from typing import Final

from fieldrig_bus.can.notices import CanState

STEP: Final = 8
"""Increment of a counter for a transmitter's error, and for errors in error frames."""
WARNING: Final = 96
"""Interface chips report a warning from this value on."""
PASSIVE: Final = 128
"""A node is error passive if either of its counters has at least this value."""
BUS_OFF: Final = 256
"""A node is in bus-off if its transmit error counter has at least this value."""
HIGHEST_REC: Final = 255
"""Highest receive error counter.  The standard leaves the limit open; the registers of controllers have 8 bits."""
REC_AFTER_PASSIVE: Final = 127
"""A frame received without error takes a higher receive error counter back to 119 to 127."""


def state_of(tec: int, rec: int) -> CanState:
    """The state of a controller with these counters."""
    if tec >= BUS_OFF:
        return CanState.BUS_OFF
    highest = max(tec, rec)
    if highest >= PASSIVE:
        return CanState.PASSIVE
    return CanState.WARNING if highest >= WARNING else CanState.ACTIVE
