"""Touch probes: the position of the axis at the edge of a switch, or at the encoder zero.

Source: CiA 402-2, chapter 'touch probe' (60B8h to 60BDh, 60D0h to 60D8h).  Our choices: the probes are inputs 16 and 17
of 60FDh; an edge that the motor does not capture is detected in the cycle after it, and takes the position and the time
of that cycle; a value that is written to 60B8h while a probe is enabled takes effect immediately; time stamps are the
lower 32 bits of the device's time in nanoseconds, and counters begin at 0 when a probe is enabled.
"""

from collections.abc import Callable
from functools import partial
from typing import Final

from fieldrig.clock import Clock
from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.axis_objects import AxisObjects
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.motor import Captured, Motor, passed_zero
from fieldrig_devices.cia402.permitted import (
    HARDWARE_ZERO,
    INPUT,
    PROBE_1,
    PROBE_FUNCTION,
    PROBE_SOURCE,
    PROBE_SOURCES,
    SOFTWARE_ZERO,
    ZERO,
)

# 60B8h, in the lower byte for the first probe and in the upper one for the second
ENABLE: Final = 0x01
CONTINUOUS: Final = 0x02
EDGES: Final = {True: 0x10, False: 0x20}
"""Bits of the rising edge (True) and of the falling edge."""

# 60B9h, with the same two halves
ENABLED: Final = 0x01
STORED: Final = {True: 0x02, False: 0x04}

FIRST_INPUT: Final = 16
"""Bit of the first probe in 60FDh."""
LOW_32: Final = 0xFFFF_FFFF
LOW_16: Final = 0xFFFF


class Latch:
    """The values that one edge of a probe has stored."""

    __slots__ = ("count", "position", "time_ns")

    def __init__(self) -> None:
        self.position = self.time_ns = self.count = 0
        """The position in the user units at the time of the edge; the number of edges since the probe was enabled."""

    def read_position(self) -> int:
        return self.position

    def read_time(self) -> int:
        """The time stamp: the lower 32 bits of nanoseconds."""
        return self.time_ns & LOW_32

    def read_count(self) -> int:
        return self.count & LOW_16


class Probe:
    """One of the two probes; `place` is 0 or 1."""

    def __init__(self, place: int, shown: Callable[[float], int], source_in: Callable[[], int]) -> None:
        """`source_in` returns the source that 60D0h gives."""
        self._own = PROBE_1 + place
        self._shown, self._source_in = shown, source_in
        self.function = self.status = 0
        self.latches = {True: Latch(), False: Latch()}
        """The stored values by edge."""

    def order(self, function: int) -> None:
        if not function & ENABLE:
            self.status = 0
        elif not self.function & ENABLE:
            self.status = ENABLED
            for latch in self.latches.values():
                latch.count = 0
        for edge, bit in EDGES.items():
            if not function & bit:
                self.status &= ~STORED[edge]
        self.function = function

    @property
    def bit(self) -> int | None:
        """The bit of the input in 60FDh that triggers the probe; None if the encoder zero does."""
        source = self.function & PROBE_SOURCE
        number = {INPUT: self._own, ZERO: HARDWARE_ZERO}.get(source) or self._source_in()
        return None if number in (HARDWARE_ZERO, SOFTWARE_ZERO) else FIRST_INPUT + number - PROBE_1

    def store(self, edge: bool, at: Captured) -> None:
        """Take an edge; the encoder zero counts as both."""
        if not self.function & EDGES[edge] or not self.status & ENABLED:
            return
        latch = self.latches[edge]
        latch.count += 1
        if self.function & CONTINUOUS or not self.status & STORED[edge]:
            latch.position, latch.time_ns = self._shown(at.position), at.time_ns
            self.status |= STORED[edge]


class TouchProbes:
    def __init__(self, clock: Clock, numbers: AxisObjects, motor: Motor, context: Context) -> None:
        self._clock, self._motor, self._pace = clock, motor, context.pace
        self._probes = tuple(
            Probe(place, context.shown, partial(numbers.numbers.__getitem__, (objects.PROBE_SOURCE, place + 1)))
            for place in (0, 1)
        )
        self._inputs = self._position = 0
        """Inputs and position of the previous cycle."""
        self.is_armed = False
        numbers.on_write(objects.PROBE_FUNCTION, self._on_function)
        for subindex in (1, 2):
            check = numbers.or_start(objects.PROBE_SOURCE, PROBE_SOURCES.check, subindex)
            numbers.on_write(objects.PROBE_SOURCE, check, subindex)
        self._show(numbers)

    def _show(self, numbers: AxisObjects) -> None:
        first, second = self._probes
        numbers.read_by(objects.PROBE_STATUS, lambda: first.status | second.status << 8)
        latches = [probe.latches[edge] for probe in self._probes for edge in (True, False)]
        places = zip(latches, objects.PROBE_VALUES, objects.PROBE_TIMES, objects.PROBE_COUNTERS, strict=True)
        for latch, value, time, counter in places:
            numbers.read_by(value, latch.read_position)
            numbers.read_by(time, latch.read_time)
            numbers.read_by(counter, latch.read_count)

    def restart(self) -> None:
        self.is_armed = False
        for probe in self._probes:
            probe.order(0)

    def _on_function(self, word: int) -> None:
        PROBE_FUNCTION.check(word)
        halves = word & 0xFF, word >> 8
        for probe, half in zip(self._probes, halves, strict=True):
            probe.order(half)
        if not self.is_armed:
            self._inputs, self._position = self._motor.inputs, self._motor.position
        self.is_armed = any(half & ENABLE for half in halves)
        self._pace.wake()

    def step(self) -> None:
        """Look for edges, once per cycle while armed."""
        motor, now_ns = self._motor, self._clock.now_ns()
        inputs, position = motor.inputs, motor.position
        zero = passed_zero(self._position, position, motor.revolution)
        for probe in self._probes:
            bit = probe.bit
            if bit is None:
                if zero is not None:
                    for edge in (True, False):
                        probe.store(edge, Captured(zero, now_ns))
            elif (inputs ^ self._inputs) >> bit & 1:
                probe.store(bool(inputs >> bit & 1), motor.captured(bit) or Captured(position, now_ns))
        self._inputs, self._position = inputs, position
