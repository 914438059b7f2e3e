"""Ringing at a modem: the rings in S1, and the ring after which S0 has it answer (ITU-T V.250, 6.3.8)."""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import Alarm, Clock, S
from fieldrig_devices.modem.profile import Profile

FORGOTTEN_NS: Final = 8 * S
"""The time without a ring after which S1 is 0."""
MOST_RINGS: Final = 255


class Ringing:
    def __init__(self, clock: Clock, profile: Callable[[], Profile]) -> None:
        self._clock, self._profile = clock, profile
        self.is_on = False
        """The ringing voltage is there."""
        self._timer = Alarm(self._clock)

    def begin(self) -> None:
        """Count a ring that begins."""
        registers = self._profile().registers
        registers[1] = min(registers[1] + 1, MOST_RINGS)
        self._timer.after(FORGOTTEN_NS, self.forget)

    def is_enough(self) -> bool:
        """Return whether the modem answers by itself after the rings so far."""
        registers = self._profile().registers
        return 0 < registers[0] <= registers[1]

    def forget(self) -> None:
        self._profile().registers[1] = 0
