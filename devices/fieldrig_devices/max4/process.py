"""The real-time process: the tasks of the controller in every cycle, and their share of the cycle.

Source: PacDrive manual 6967-6969 (digest PD-084): encoders, motion with set values, measuring inputs, exchange over the
ring.  CycleLoad is the share of the cycle that these take on the controller's own processor, from settings.  RTBReadRes
is the time left in the cycle when the actual values have arrived, RTBWriteRes when the set values are written; below
zero is a write cycle overflow (PD-134; the manual does not define them, so we follow the help of the successor).  A
host that is late is no load of this processor: it filled the message logger of a controller that was idle.
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
    """The cyclic process of one boot."""

    def __init__(self, clock: Clock, cycle_ns: int, times: ProcessTimes, on_overflow: Callable[[int], None]) -> None:
        """`on_overflow` is called with the reserve in microseconds, once per sequence of overflows."""
        self._clock, self.cycle_ns, self._times, self._on_overflow = clock, cycle_ns, times, on_overflow
        self.drives: tuple[RingDrive, ...] = ()
        self.simulated: list[SimulatedDrive] = []
        self.logic_encoders: list[LogicEncoder] = []
        self.master_encoders: list[MasterEncoder] = []
        self.measuring: list[MeasuringInput] = []
        self.actions: list[Callable[[], None]] = []
        self.take: Callable[[int], None] | None = None
        """Called with the processor time of each cycle in nanoseconds, while there are tasks to take it from."""
        self.cycles = 0
        self.delay_us = 0
        """Additional duration of each cycle by an injected fault, in microseconds."""
        self._last_ns = 0
        self._was_over = False
        self._room_us = 0
        self.lay_out(())

    def lay_out(self, drives: tuple[RingDrive, ...]) -> None:
        """Run with these drives on the ring from now on."""
        self.drives = drives
        lengths = [drive.drive.at_length for drive in drives]
        self._room_us = (self.cycle_ns - answers_ns(lengths, MBAUD)) // US

    def run(self) -> None:
        """Run one cycle."""
        clock, drives = self._clock, self.drives
        self.cycles += 1
        if self.take is not None:
            self.take(self.duration_us * US)
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
    def duration_us(self) -> int:
        """Duration of the process in each cycle, in microseconds."""
        axes = len(self.drives) + len(self.simulated)
        return self._times.base_us + self._times.axis_us * axes + self.delay_us

    @property
    def load_percent(self) -> int:
        """CycleLoad, in percent."""
        return min(100 * self.duration_us * US // self.cycle_ns, 100)

    @property
    def read_reserve_us(self) -> int:
        """RTBReadRes, in microseconds."""
        return self._room_us

    @property
    def write_reserve_us(self) -> int:
        """RTBWriteRes, in microseconds."""
        return self.read_reserve_us - self.duration_us
