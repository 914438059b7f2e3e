"""The corrector: it moves the flow so that an event happens at the value where it must be (PAML-500 to PAML-518).

The sign follows the manual's two examples: with the reference OUTPUT the correction is "must be" minus "is", with INPUT
it is "is" minus "must be"; a setting reverses the latter.  Corrections add up in the flow.
"""

from dataclasses import dataclass
from typing import Literal

from fieldrig_devices.motion.profile import Limits, Profile, change_speed, keep, move
from fieldrig_devices.pam.pipes.block import Block, is_same, nearest

CorrectorState = Literal["standby", "wait event", "wait correction", "in correction"]


@dataclass(frozen=True, slots=True)
class Settings:
    """The parameters of a corrector that a program cannot change."""

    is_immediate: bool
    """CORRECTION_MODE: False is ON_REQUEST."""
    is_output: bool
    """CORRECTION_REFERENCE: False is INPUT."""
    is_repetitive: bool
    """TRIGGER_MODE: False is ONCE."""
    value_period: float | None = None
    is_input_sign_reversed: bool = False
    """True if the correction with the reference INPUT is "must be" minus "is" as well."""
    is_ended_by_trigger_off: bool = False
    """True if `trigger_off` brakes a running correction; False if it completes."""


class Corrector(Block):
    """A corrector; `slope` is its acceleration in u/s2, `level` its speed in u/s, `delay_s` the delay of the sensor."""

    def __init__(self, settings: Settings, slope: float, level: float, delay_s: float) -> None:
        super().__init__()
        self.settings = settings
        self.slope, self.level, self.delay_s = slope, level, delay_s
        self.state: CorrectorState = "standby"
        self.triggered = False
        self.correction = 0.0
        """The signed value of the present or last correction."""
        self.latched = (0.0, 0.0, 0.0)
        """The "is" value at the event, with its first and second derivative by time."""
        self._must_be = 0.0
        self._corrected = 0.0
        self._way: Profile = keep(0.0)
        self._distance = 0.0
        """The way of the running correction."""
        self._periods = 0
        self._flow: tuple[float, ...] = ()
        self._is_armed = False
        """True if the next event is waited for after the running correction."""

    @property
    def ready(self) -> bool:
        return self.state != "in correction"

    @property
    def is_at_rest(self) -> bool:
        """True if no correction runs, and an event would find the flow without speed and acceleration."""
        flow = self._flow
        return self.state != "in correction" and len(flow) == 3 and all(is_same(value, flow[0]) for value in flow)

    def start(self, period_s: float) -> None:
        super().start(period_s)
        self.state, self.triggered, self._flow = "standby", False, ()
        self._corrected, self._way, self._periods, self._is_armed = 0.0, keep(0.0), 0, False

    def trigger(self, must_be: float) -> None:
        """Wait for the event, which must find the flow at `must_be`; a running correction goes on first."""
        self._must_be = must_be
        self.triggered = False
        self._is_armed = True
        if self.state != "in correction":
            self.state = "wait event"

    def trigger_off(self) -> None:
        """Disable the corrector; a running correction is completed, or braked by the other reading (G-33)."""
        self._is_armed = False
        if self.state != "in correction":
            self.state = "standby"
        elif self.settings.is_ended_by_trigger_off:
            moved, speed, _ = self._way.values_at(self._periods * self.period_s)
            self._corrected += moved
            way = change_speed(speed, 0.0, Limits(self.level, self.slope, self.slope))
            self._follow(way, way.values_at(way.duration_s)[0])

    def start_correction(self, value: float | None = None) -> None:
        """Correct by the computed value or by another one; only in the mode ON_REQUEST (PAML-509, PAML-510)."""
        if self.state != "wait correction":
            return
        if value is not None:
            self.correction = value
        self._begin()

    def event(self, age_s: float = 0.0) -> None:
        """The trigger input has changed, `age_s` seconds before the last value of the flow.

        The values of that instant are computed back with a constant acceleration (PAML-513).  An event during a
        correction is ignored.
        """
        if self.state != "wait event" or not self._flow:
            return
        position, speed, acceleration = self._derivatives()
        back = age_s + self.delay_s
        seen = position - speed * back + acceleration * back * back / 2
        self.latched = (seen, speed - acceleration * back, acceleration)
        is_forward = self.settings.is_output or self.settings.is_input_sign_reversed
        difference = self._must_be - seen if is_forward else seen - self._must_be
        self.correction = nearest(difference, self.settings.value_period)
        self._is_armed = self.settings.is_repetitive
        if self.settings.is_immediate:
            self._begin()
        else:
            self.state, self.triggered = "wait correction", True

    def transform(self, value: float) -> float:
        corrected = value + (self._going_on() if self.state == "in correction" else self._corrected)
        self._flow = (*self._flow[-2:], corrected if self.settings.is_output else value)
        return corrected

    def _going_on(self) -> float:
        """Go on with the correction for a period, and return the way of all corrections up to now."""
        self._periods += 1
        seconds = self._periods * self.period_s
        if seconds < self._way.duration_s:
            return self._corrected + self._way.values_at(seconds)[0]
        self._corrected += self._distance
        self.state = "wait event" if self._is_armed else "standby"
        return self._corrected

    def _follow(self, way: Profile, distance: float) -> None:
        self._way, self._distance, self._periods = way, distance, 0

    def _begin(self) -> None:
        self._follow(move(self.correction, 0.0, Limits(self.level, self.slope, self.slope)), self.correction)
        self.state = "in correction"
        self.triggered = not self.settings.is_repetitive

    def _derivatives(self) -> tuple[float, float, float]:
        """Return the last value of the flow with its first and second difference by time."""
        period, flow = self.settings.value_period or self.period, self._flow
        last = nearest(flow[-1] - flow[-2], period) / self.period_s if len(flow) > 1 else 0.0
        if len(flow) < 3:
            return flow[-1], last, 0.0
        before = nearest(flow[-2] - flow[-3], period) / self.period_s
        acceleration = (last - before) / self.period_s
        return flow[-1], last + acceleration * self.period_s / 2, acceleration
