"""The causes of errors of an axis: faults, wires, the ring, and a position beyond PHIL1 and PHIL2."""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import Clock
from fieldrig.faults.faults import Fault, Faults
from fieldrig_devices.pamring.axis_words import Error
from fieldrig_devices.st1.faults import MODELS, Jam, St1Faults
from fieldrig_devices.st1.settings import St1Settings
from fieldrig_devices.st1.shaft import TURN
from fieldrig_devices.st1.status import bits_of

LOWEST_FIRMWARE: Final = 590
RING_BIT: Final = 1 << 12
"""Bit of CMASKU that lets the ST1 report a ring fault (11538)."""


class Causes:
    def __init__(self, clock: Clock, settings: St1Settings, on_faults: Callable[[], None]) -> None:
        own = settings.parameters
        self.faults: St1Faults = St1Faults(clock, MODELS, Faults(Fault), on_change=on_faults)
        self.enable = settings.enable
        """The input that enables the power stage."""
        self.outer = 0
        """Bits of wires and of the ring."""
        self._reports_ring = bool(own.cmasku & RING_BIT) and settings.firmware >= LOWEST_FIRMWARE
        self._low = None if own.phil1 is None else own.phil1 * TURN
        self._high = None if own.phil2 is None else own.phil2 * TURN
        self.has_range = self._low is not None or self._high is not None

    def put(self, bit: int, is_on: bool) -> None:
        self.outer = self.outer | bit if is_on else self.outer & ~bit

    def put_ring(self, is_faulty: bool) -> None:
        self.put(Error.COMMUNICATION_FAILURE, is_faulty and self._reports_ring)

    @property
    def is_jammed(self) -> bool:
        return self.faults.first(Jam) is not None

    @property
    def bits(self) -> int:
        """Bits of all causes but those of the shaft."""
        return bits_of(self.faults) | self.outer | (0 if self.enable else Error.POWER_STAGE_DISABLED)

    def is_out(self, position: int) -> bool:
        """True if a position is beyond PHIL1 or PHIL2."""
        return (self._low is not None and position < self._low) or (self._high is not None and position > self._high)
