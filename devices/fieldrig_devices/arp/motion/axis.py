"""One axis: its counter, its reference, the generator of the reference, its position loop, and its flags.

Source: manual 3.2, 4.2.1, 4.6, 5.9.3; digest chapters 8.2 and 12.  A `ReferenceGenerator` moves the reference of an
axis; an axis without one is at rest.  The counter reads the encoder; on a simulated axis it is the reference itself.
The reference of an axis that is not under control (encoder only, PID, no Enable, control lost) is its reading.  HOME
has no effect, as in firmware 3.00.
"""

from typing import Protocol

from fieldrig_devices.arp.card_errors import CONTROL_LOSS, CardErrors
from fieldrig_devices.arp.motion.counter import Counter, Latch
from fieldrig_devices.arp.motion.flags import AxisFlag, AxisFlags
from fieldrig_devices.arp.motion.position_loop import Arrival, PositionLoop
from fieldrig_devices.arp.motion.setup import Overrides, Setup
from fieldrig_devices.arp.parameters import Kind
from fieldrig_devices.motion.profile import State


class ReferenceGenerator(Protocol):
    """Moves the reference of an axis until it releases the axis itself or is replaced."""

    def advance(self, axis: "Axis", now_ns: int) -> None:
        """Advance the reference; the axis calls it once per control loop."""

    def shift(self, distance: float) -> None:
        """Shift all positions by `distance`, because the counter was written."""


class Axis:
    def __init__(self, number: int, setup: Setup, flags: list[int], errors: CardErrors) -> None:
        self.number, self.setup, self._errors = number, setup, errors
        self.overrides = Overrides()
        self.flags = AxisFlags(number, flags)
        self.latch = Latch(self.flags)
        self._arrival = Arrival()
        self.counter = Counter(setup.span, setup.per_count)
        self._loop = PositionLoop(setup)
        self.generator: ReferenceGenerator | None = None
        self.reference = self.speed = self.acceleration = 0.0
        """Reference position of the axis; `speed` and `acceleration` are those of the reference."""
        self.measured_speed = self.error = self.volts = 0.0
        self.jump = 0.0
        """Distance by which the counter wrapped or was written since this was last set to 0: travel is reading + jump.
        """
        self.is_controlled = False
        self.now_ns = 0
        """Time of the last control loop, at which instructions begin."""
        self._ahead = 0.0
        """Whole ranges, in units, by which the reference wraps later than the reading."""
        self._is_engaged = self._is_lost = False
        self._has_wire = False

    # ---- being put under control, and parameters

    def start(self) -> None:
        """Switch control off, and clear flags and limits; the reading is kept."""
        self.release()
        self.overrides = Overrides()
        self.flags.clear()

    def engage(self) -> None:
        self._is_engaged, self._is_lost = True, False
        self._leave()
        self._take_control()

    def release(self) -> None:
        self._is_engaged = False
        self._leave()
        self._take_control()

    def configure(self, setup: Setup) -> None:
        """Apply changed parameters.  A new kind of axis ends the present motion and takes or releases control."""
        old, self.setup = self.setup, setup
        self._loop.configure(setup)
        if (old.span.low, old.span.high, old.per_count) != (setup.span.low, setup.span.high, setup.per_count):
            self.counter.configure(setup.span, setup.per_count)
            self.preset(self.reference)
        if old.kind != setup.kind:
            self._leave()
            self.counter.preset(self.counter.reading)
            self._take_control()

    def _take_control(self) -> None:
        """Take control at the present position, if the axis may be controlled at all."""
        kind = self.setup.kind
        self.is_controlled = self._is_engaged and not self._is_lost and kind in (Kind.SIMULATED, Kind.CONTROLLED)
        self._follow_reading()
        self._loop.reset()
        self._arrival.expect()

    def _leave(self) -> None:
        """End any motion of the axis; the flags for arrival and final speed are kept."""
        if self.generator is not None:
            self.generator = None
            self.flags[AxisFlag.RUNNING] = 0
            self.flags[AxisFlag.SYNCHRONOUS] = 0
        self.speed = self.acceleration = self.volts = 0.0

    def _lose(self) -> None:
        self._is_lost = True
        self._leave()
        self.is_controlled = False
        self._errors.fail(CONTROL_LOSS, self.number)

    # ---- what generators do with the axis

    def begin(self, generator: ReferenceGenerator) -> None:
        """Set the flags of a movement that starts, and let `generator` move the axis (digest 12)."""
        self.generator = generator
        self._arrival.forget()
        self.flags[AxisFlag.ARRIVED] = 0
        self.flags[AxisFlag.SYNCHRONOUS] = 0
        self.flags[AxisFlag.STOP] = 0
        self.flags[AxisFlag.RUNNING] = 1
        self.flags[AxisFlag.FINAL_SPEED] = 0

    def place(self, reference: float, state: State) -> float:
        """Set the reference, wrapped into the counter's range.  Returns the distance that wrapping removed."""
        self.speed, self.acceleration = state.speed, state.acceleration
        span = self.setup.span
        if span.low <= reference <= span.high:
            self.reference = reference
            return 0.0
        laps = span.laps(reference)
        self.reference = span.back(reference, laps)
        removed = laps * span.length
        self._ahead += removed
        if self.setup.kind is Kind.SIMULATED:
            self._pass(laps)
        return removed

    def rest(self) -> None:
        """End the motion: the reference has reached its end."""
        self.generator = None
        self.speed = self.acceleration = 0.0
        self.flags[AxisFlag.RUNNING] = 0
        self._arrival.expect()

    def end_at_speed(self) -> None:
        """Set the flags of an instruction that ends while the axis moves."""
        self.flags[AxisFlag.RUNNING] = 0
        self.flags[AxisFlag.SYNCHRONOUS] = 0
        self.flags[AxisFlag.FINAL_SPEED] = 1

    # ---- position

    @property
    def reading(self) -> float:
        return self.counter.reading

    def preset(self, position: float) -> None:
        """Write counter and reference together, without motion (digest 7): @POS."""
        span, counter = self.setup.span, self.counter
        before, error = counter.reading, self.error
        target = span.wrapped(position)
        distance, self.reference = target - self.reference, target
        reading = target - error
        laps = span.laps(reading)
        counter.preset(span.back(reading, laps))
        self._ahead = -laps * span.length if laps else 0.0
        self.jump += before - counter.reading
        if self.generator is not None:
            self.generator.shift(distance)

    def _follow_reading(self) -> None:
        self.reference = self.counter.reading
        self._ahead = self.error = 0.0

    def _pass(self, laps: int) -> None:
        """Record that the counter wrapped."""
        self.flags[AxisFlag.PASSED_MAXIMUM if laps > 0 else AxisFlag.PASSED_MINIMUM] = 1
        self.jump += laps * self.setup.span.length

    # ---- the control loop

    def control(self, now_ns: int, seconds: float, counts: int | None, level: int) -> None:
        """Run one loop, `seconds` after the last."""
        kind = self.setup.kind
        if counts is not None:
            self._read(counts, seconds, kind)
        if self.generator is not None:
            self.generator.advance(self, now_ns)
        if kind is Kind.SIMULATED:
            self.counter.reading = self.reference
            self._ahead = 0.0
            self.measured_speed = self.speed
        elif not self.is_controlled:
            self._follow_reading()
        else:
            self._regulate(seconds)
        if self._arrival.is_awaited and self.is_controlled:
            is_inside = abs(self.error) <= self.setup.window
            if self._arrival.check(now_ns, is_inside, self.setup.dwell_ns):
                self.flags[AxisFlag.ARRIVED] = 1
        if level != self.latch.level:
            self.latch.take(level, self.counter.reading)
        self.now_ns = now_ns

    def _read(self, counts: int, seconds: float, kind: Kind) -> None:
        counter = self.counter
        if not self._has_wire:
            self._find(counts)
        if kind is Kind.SIMULATED:
            counter.skip_to(counts)
            return
        laps = counter.take(counts)
        self.measured_speed = counter.delta * self.setup.per_count / seconds
        if laps:
            self._ahead -= laps * self.setup.span.length
            self._pass(laps)

    def _find(self, counts: int) -> None:
        """Take the position of an encoder whose first signal has come.  That is no motion."""
        self._has_wire = True
        self.counter.skip_to(counts)
        if self.setup.kind is not Kind.SIMULATED:
            self.preset(self.reference + self.counter.counts * self.setup.per_count)

    def _regulate(self, seconds: float) -> None:
        self.error = error = self.reference - self.counter.reading + self._ahead
        if abs(error) > self.setup.error_maximum:
            self._lose()
        else:
            self.volts = self._loop.volts(error, self.speed, seconds)
