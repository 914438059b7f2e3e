"""Touch probes: the position of the axis at the edge of a switch, or at the encoder zero.

Source: CiA 402-2, chapter 'touch probe' (60B8h to 60BDh).  Our choices: the probes are inputs 16 and 17 of 60FDh; an
edge is detected in the cycle after it, and takes the position of that cycle; a value that is written to 60B8h while a
probe is enabled takes effect immediately.  Left out: sources by 60D0h, time stamps and counters (60D1h to 60D8h).
"""

from collections.abc import Callable
from functools import partial
from typing import Final

from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.axis_objects import AxisObjects
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.motor import Motor, passed_zero

# 60B8h, in the lower byte for the first probe and in the upper one for the second
ENABLE: Final = 0x01
CONTINUOUS: Final = 0x02
SOURCE: Final = 0x0C
INPUT, ZERO = 0x00, 0x04
EDGES: Final = {True: 0x10, False: 0x20}
"""Bits of the rising edge (True) and of the falling edge."""

# 60B9h, with the same two halves
ENABLED: Final = 0x01
STORED: Final = {True: 0x02, False: 0x04}

FIRST_INPUT: Final = 16
"""Bit of the first probe in 60FDh."""


class Probe:
    """One of the two probes; `place` is 0 or 1."""

    def __init__(self, place: int, shown: Callable[[float], int]) -> None:
        self._bit = 1 << (FIRST_INPUT + place)
        self._shown = shown
        self.function = self.status = 0
        self.values = {True: 0, False: 0}
        """Stored positions by edge, in the user units at the time of the edge."""

    def order(self, function: int) -> None:
        if not function & ENABLE:
            self.status = 0
        elif not self.function & ENABLE:
            self.status = ENABLED
        for edge, bit in EDGES.items():
            if not function & bit:
                self.status &= ~STORED[edge]
        self.function = function

    def look(self, inputs: int, before: int, zero: int | None, position: int) -> None:
        """Check for an edge.  `position` is in increments; `zero` is the encoder zero that was passed, or None."""
        if self.function & SOURCE == ZERO:
            if zero is not None:
                for edge in (True, False):
                    self._store(edge, zero)
        elif (inputs ^ before) & self._bit:
            self._store(bool(inputs & self._bit), position)

    def _store(self, edge: bool, position: int) -> None:
        is_wanted = self.function & EDGES[edge] and self.status & ENABLED
        if is_wanted and (self.function & CONTINUOUS or not self.status & STORED[edge]):
            self.values[edge] = self._shown(position)
            self.status |= STORED[edge]


class TouchProbes:
    def __init__(self, numbers: AxisObjects, motor: Motor, context: Context) -> None:
        self._motor, self._pace = motor, context.pace
        self._probes = Probe(0, context.shown), Probe(1, context.shown)
        self._inputs = self._position = 0
        """Inputs and position of the previous cycle."""
        self.is_armed = False
        first, second = self._probes
        numbers.on_write(objects.PROBE_FUNCTION, self._on_function)
        numbers.read_by(objects.PROBE_STATUS, lambda: first.status | second.status << 8)
        for index, probe, edge in (
            (objects.PROBE_1_RISING, first, True),
            (objects.PROBE_1_FALLING, first, False),
            (objects.PROBE_2_RISING, second, True),
            (objects.PROBE_2_FALLING, second, False),
        ):
            numbers.read_by(index, partial(probe.values.__getitem__, edge))

    def restart(self) -> None:
        self.is_armed = False
        for probe in self._probes:
            probe.order(0)

    def _on_function(self, word: int) -> None:
        halves = word & 0xFF, word >> 8
        if any(half & SOURCE not in (INPUT, ZERO) for half in halves):
            raise Abort(Code.INVALID_VALUE)
        for probe, half in zip(self._probes, halves, strict=True):
            probe.order(half)
        if not self.is_armed:
            self._inputs, self._position = self._motor.inputs, self._motor.position
        self.is_armed = any(half & ENABLE for half in halves)
        self._pace.wake()

    def step(self) -> None:
        """Look for edges, once per cycle while armed."""
        inputs, position = self._motor.inputs, self._motor.position
        zero = passed_zero(self._position, position, self._motor.revolution)
        for probe in self._probes:
            probe.look(inputs, self._inputs, zero, position)
        self._inputs, self._position = inputs, position
