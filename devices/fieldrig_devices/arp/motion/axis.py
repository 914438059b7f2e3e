"""One axis: its counter, its reference, what leads the reference, its position loop, its flags.

Source: manual 3.2, 4.2.1, 4.6, 5.9.3; digest chapters 8.2 and 12.  What gives a moving axis its reference is a `Guide`;
an axis without one rests.  The counter reads the encoder, but on a simulated axis it is the reference itself.  An axis
that is not under control (encoder only, PID, no Enable, control lost) has its reading for a reference.
Without effect in firmware 3.00, and here: HOME.
"""

from typing import Protocol

from fieldrig_devices.arp.card_errors import CONTROL_LOSS, CardErrors
from fieldrig_devices.arp.motion.arrival import Arrival
from fieldrig_devices.arp.motion.counter import Counter
from fieldrig_devices.arp.motion.flags import AxisFlag, AxisFlags
from fieldrig_devices.arp.motion.latch import Latch
from fieldrig_devices.arp.motion.position_loop import PositionLoop
from fieldrig_devices.arp.motion.setup import Setup, Shares
from fieldrig_devices.arp.parameters import Kind
from fieldrig_devices.motion.profile import State


class Guide(Protocol):
    """Leads an axis' reference until it lets go of the axis itself, or another takes its place."""

    def lead(self, axis: "Axis", now_ns: int) -> None:
        """Called once a control loop."""

    def shift(self, distance: float) -> None:
        """The counter was written: what stood at p now stands at p + distance."""


class Axis:
    def __init__(self, number: int, setup: Setup, flags: list[int], errors: CardErrors) -> None:
        self.number, self.setup, self._errors = number, setup, errors
        self.shares = Shares()
        self.flags = AxisFlags(number, flags)
        self.latch = Latch(self.flags)
        self._arrival = Arrival()
        self.counter = Counter(setup.span, setup.per_count)
        self._loop = PositionLoop(setup)
        self.guide: Guide | None = None
        self.reference = self.speed = self.acceleration = 0.0
        """What the axis should do; `speed` and `acceleration` are the reference's too."""
        self.measured_speed = self.error = self.volts = 0.0
        self.jump = 0.0
        """By how much the counter went round or was written since this was last set to 0: travel is reading + jump."""
        self.is_controlled = False
        self.now_ns = 0
        """Of the last control loop: where instructions begin."""
        self._ahead = 0.0
        """By how many whole ranges the reference goes round later than the reading, in units."""
        self._is_engaged = self._is_lost = False
        self._has_wire = False

    # ---- being put under control, and parameters

    def start(self) -> None:
        """Control off, flags and limits as new; the reading stays."""
        self.release()
        self.shares = Shares()
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
        """Parameters have changed.  A new kind ends what is going on, and takes control or leaves it."""
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
        """Where the axis stands, if it may be controlled at all."""
        kind = self.setup.kind
        self.is_controlled = self._is_engaged and not self._is_lost and kind in (Kind.SIMULATED, Kind.CONTROLLED)
        self._follow_reading()
        self._loop.reset()
        self._arrival.expect()

    def _leave(self) -> None:
        """Whatever moves the axis ends; arrival and final speed stay as they are."""
        if self.guide is not None:
            self.guide = None
            self.flags[AxisFlag.RUNNING] = 0
            self.flags[AxisFlag.SYNCHRONOUS] = 0
        self.speed = self.acceleration = self.volts = 0.0

    def _lose(self) -> None:
        self._is_lost = True
        self._leave()
        self.is_controlled = False
        self._errors.fail(CONTROL_LOSS, self.number)

    # ---- what guides do with the axis

    def begin(self, guide: Guide) -> None:
        """The flags of a movement that starts (digest 12)."""
        self.guide = guide
        self._arrival.forget()
        self.flags[AxisFlag.ARRIVED] = 0
        self.flags[AxisFlag.SYNCHRONOUS] = 0
        self.flags[AxisFlag.STOP] = 0
        self.flags[AxisFlag.RUNNING] = 1
        self.flags[AxisFlag.FINAL_SPEED] = 0

    def place(self, reference: float, state: State) -> float:
        """Put the reference there, going round if it must; returns what was taken off in doing so."""
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
        """The reference has come to its end."""
        self.guide = None
        self.speed = self.acceleration = 0.0
        self.flags[AxisFlag.RUNNING] = 0
        self._arrival.expect()

    def end_at_speed(self) -> None:
        """The flags of an instruction that ends with the axis moving."""
        self.flags[AxisFlag.RUNNING] = 0
        self.flags[AxisFlag.SYNCHRONOUS] = 0
        self.flags[AxisFlag.FINAL_SPEED] = 1

    # ---- position

    @property
    def reading(self) -> float:
        return self.counter.reading

    def preset(self, position: float) -> None:
        """@POS: counter and reference are written together, and nothing moves (digest 7)."""
        span, counter = self.setup.span, self.counter
        before, error = counter.reading, self.error
        target = span.wrapped(position)
        distance, self.reference = target - self.reference, target
        reading = target - error
        laps = span.laps(reading)
        counter.preset(span.back(reading, laps))
        self._ahead = -laps * span.length if laps else 0.0
        self.jump += before - counter.reading
        if self.guide is not None:
            self.guide.shift(distance)

    def _follow_reading(self) -> None:
        self.reference = self.counter.reading
        self._ahead = self.error = 0.0

    def _pass(self, laps: int) -> None:
        """The counter went round."""
        self.flags[AxisFlag.PASSED_MAXIMUM if laps > 0 else AxisFlag.PASSED_MINIMUM] = 1
        self.jump += laps * self.setup.span.length

    # ---- the control loop

    def control(self, now_ns: int, seconds: float, counts: int | None, level: int) -> None:
        """One loop, `seconds` after the last."""
        kind = self.setup.kind
        if counts is not None:
            self._read(counts, seconds, kind)
        if self.guide is not None:
            self.guide.lead(self, now_ns)
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
            if self._arrival.has_come(now_ns, is_inside, self.setup.dwell_ns):
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
        """The encoder is heard of for the first time: that is where the axis stands, without having moved there."""
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
