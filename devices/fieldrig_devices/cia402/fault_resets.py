"""Which control words reset a fault: by the standard the rising edge of bit 7, with some drives another rule.

Source: CiA 402-2, transition 15; docs/devices/drive-personalities.md for the drives that differ.
"""

from collections.abc import Callable

from fieldrig.clock import MS
from fieldrig_devices.cia402.behaviour import Behaviour, FaultReset
from fieldrig_devices.drive_profile.states import FAULT_RESET


class FaultResets:
    def __init__(self, behaviour: Behaviour, now_ns: Callable[[], int]) -> None:
        self._behaviour, self._now_ns = behaviour, now_ns
        self._locked_ns = 0
        """The instant until which no reset is accepted."""
        self._count = 0

    def begin(self) -> None:
        """Begin a fault."""
        self._count, self._locked_ns = 0, self._now_ns() + round(self._behaviour.reset_lock_ms * MS)

    def are_enough(self, word: int, before: int) -> bool:
        """True if the control word, after the one before, resets the fault."""
        is_level = self._behaviour.fault_reset is FaultReset.LEVEL
        asked = word if is_level else word & ~before
        if not asked & FAULT_RESET or self._now_ns() < self._locked_ns:
            return False
        self._count += 1
        if self._count < self._behaviour.resets:
            return False
        self._count = 0
        return True
