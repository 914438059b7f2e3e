"""Power and buffered memory of the controller, and the faults that take them away.

Source: PacDrive manual 4210-4214 (digest PD-040, PD-048, PD-111).
"""

from collections.abc import Callable
from typing import Any, Protocol

from fieldrig.clock import Clock
from fieldrig.faults.faults import Fault, Faults
from fieldrig.faults.injected import InjectedFaults
from fieldrig_devices.max4.faults import MODELS, MemoryLost, Overrun, PowerOff
from fieldrig_devices.max4.storage.memory import Memory


class Supplied(Protocol):
    """The parts of the controller that need power."""

    def power_on(self) -> None:
        """Boot."""

    def power_off(self) -> None:
        """End everything at once."""

    def on_memory_lost(self) -> None:
        """Called when the content of the memory is lost while there is power."""


class Power:
    """The power of one controller."""

    def __init__(self, clock: Clock, memory: Memory, supplied: Supplied, set_delay: Callable[[int], None]) -> None:
        """`set_delay` is called with `delay_us` when the faults have changed."""
        self._memory, self._supplied, self._set_delay = memory, supplied, set_delay
        self.injected = InjectedFaults[Fault[Any]](clock, MODELS, Faults(Fault), on_change=self._on_faults)
        self.is_on = self._was_lost = self._has_started = False
        self._off_days = 0.0

    @property
    def delay_us(self) -> int:
        """Additional duration of each cycle by a fault, in microseconds."""
        overrun = self.injected.first(Overrun)
        return 0 if overrun is None else overrun.us

    def start(self, off_days: float) -> None:
        """Switch the power on, after `off_days` without it, unless a fault keeps it off."""
        self._has_started = True
        if self.injected.first(PowerOff) is None:
            self._on(off_days)

    def _on(self, off_days: float) -> None:
        self.is_on = True
        is_lost = self._memory.power_on(off_days, is_lost=self.injected.first(MemoryLost) is not None)
        self._supplied.power_on()
        if is_lost:
            self._supplied.on_memory_lost()

    def _off(self) -> None:
        self.is_on = False
        self._memory.power_off()
        self._supplied.power_off()

    def _on_faults(self) -> None:
        off = self.injected.first(PowerOff)
        self._set_delay(self.delay_us)
        if off is not None:
            self._off_days = off.days
            if self.is_on:
                self._off()
        elif self._has_started and not self.is_on:
            self._on(self._off_days)
        # This is called for each change of any fault: only the begin of this one takes the content.
        is_lost = self.injected.first(MemoryLost) is not None
        if is_lost and not self._was_lost and self.is_on:
            self._memory.lose()
            self._supplied.on_memory_lost()
        self._was_lost = is_lost
