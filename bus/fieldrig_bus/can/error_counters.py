"""The limits of the error counters, and the state of a controller that follows from them.

Source: ISO 11898-1:2015, 12.1.4 (fault confinement; Bosch CAN 2.0, chapter 8, has the same rules).
"""

from typing import Final

from fieldrig_bus.can.notices import CanState

STEP: Final = 8
"""Increment of a counter for a transmitter's error, and for errors in error frames."""
WARNING: Final = 96
"""From this value on, interface chips report a warning."""
PASSIVE: Final = 128
"""From this value on, either counter makes its node error passive."""
BUS_OFF: Final = 256
"""From this value on, the transmit error counter takes its node off the bus."""
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
