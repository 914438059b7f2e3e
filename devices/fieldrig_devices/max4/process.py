"""The real-time process: what the controller does in every cycle, and what it takes of it.

Source: PacDrive manual 6967-6969 (digest PD-084): encoders, motion with set values, measuring inputs, exchange over the
ring.  CycleLoad is how much of a cycle it takes, by settings and by how late this computer was.  RTBReadRes is the time
that is left of the cycle when the actual values are there, RTBWriteRes when the set values are written; below zero is a
write cycle overflow (PD-134; what the manual means by them is not said, ours follows the successor's help).
"""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import US, Clock
from fieldrig_bus.ring.sercos.timing import answers_ns
from fieldrig_devices.max4.axes.encoder import LogicEncoder, MasterEncoder
from fieldrig_devices.max4.axes.simulated import SimulatedDrive
from fieldrig_devices.max4.ring.drive_end import RingDrive
from fieldrig_devices.max4.settings import ProcessTimes
from fieldrig_devices.max4.terminals import MeasuringInput

MBAUD: Final = 4  # manual 456


class RealTimeProcess:
    def __init__(self, clock: Clock, cycle_ns: int, times: ProcessTimes, on_overflow: Callable[[int], None]) -> None:
        """`on_overflow` gets the reserve in microseconds, once for each time in a row."""
        self._clock, self.cycle_ns, self._times, self._on_overflow = clock, cycle_ns, times, on_overflow
        self.patience_ns = 0
        """So late this computer may be without that being the controller's load."""
        self.drives: tuple[RingDrive, ...] = ()
        self.simulated: list[SimulatedDrive] = []
        self.logic_encoders: list[LogicEncoder] = []
        self.master_encoders: list[MasterEncoder] = []
        self.measuring: list[MeasuringInput] = []
        self.actions: list[Callable[[], None]] = []
        self.cycles = 0
        self.delay_us = 0
        """More that it takes, for a fault."""
        self._late_ns = self._last_ns = 0
        self._was_over = False
        self._room_us = 0
        self.lay_out(())

    def lay_out(self, drives: tuple[RingDrive, ...]) -> None:
        """With these drives on the ring from now on."""
        self.drives = drives
        lengths = [one.drive.at_length for one in drives]
        self._room_us = (self.cycle_ns - answers_ns(lengths, MBAUD)) // US

    def run(self) -> None:
        """One cycle."""
        clock, drives = self._clock, self.drives
        self.cycles += 1
        self._late_ns = max(clock.late_ns() - self.patience_ns, 0)
        for drive in drives:
            drive.take()
        for simulated in self.simulated:
            simulated.take()
        for logic in self.logic_encoders:
            logic.step(self.cycle_ns)
        for master in self.master_encoders:
            master.step()
        for measuring in self.measuring:
            measuring.step(self._last_ns)
        self._last_ns = clock.now_ns()
        for action in self.actions:
            action()
        for drive in drives:
            drive.give()
        for simulated in self.simulated:
            simulated.give()
        if self.write_reserve_us < 0:
            self._overflow()
        else:
            self._was_over = False

    def _overflow(self) -> None:
        if not self._was_over:
            self._was_over = True
            self._on_overflow(self.write_reserve_us)

    @property
    def takes_us(self) -> int:
        axes = len(self.drives) + len(self.simulated)
        return self._times.base_us + self._times.axis_us * axes + self.delay_us

    @property
    def load_percent(self) -> int:
        """CycleLoad."""
        return min(100 * (self.takes_us + self._late_ns // US) * US // self.cycle_ns, 100)

    @property
    def read_reserve_us(self) -> int:
        """RTBReadRes."""
        return self._room_us - self._late_ns // US

    @property
    def write_reserve_us(self) -> int:
        """RTBWriteRes."""
        return self.read_reserve_us - self.takes_us
