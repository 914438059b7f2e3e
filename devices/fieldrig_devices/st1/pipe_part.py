"""The part of a pipe in the set position of an axis (PAML-042, PAML-171, PAML-405).

Set-points of the mode POSITION come cycle by cycle; between them the axis moves steadily, so it is at each of them one
interval after it came (our reading: the manual does not say how an ST1 interpolates).  Without a further set-point it
holds the last one.  In the mode SPEED the position is the sum of the speeds, exactly; a step of the speed is a ramp
with the largest acceleration.
"""

from typing import Final

from fieldrig.clock import MS, NEVER_NS, S
from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.motion.whole import WholeProfile, to_speed
from fieldrig_devices.pamring.frames import SetPointMode

LONGEST_NS: Final = 64 * MS
"""A longer time between two set-points is a pause, and not their interval."""
FIRST_NS: Final = MS
"""Interval as long as it is not known."""


class PipePart:
    __slots__ = (
        "_carry", "_due_ns", "_goal", "_interval_ns", "_limits", "_ramp", "_since_ns", "_span", "_start", "_told_ns",
        "_value", "_way", "is_ending", "mode", "period",
    )  # fmt: skip

    def __init__(self, limits: Limits) -> None:
        """`limits` are the largest speed and acceleration of the axis."""
        self._limits = limits
        self.period = 0
        """Position period in RU; 0 is no period."""
        self.clear()

    def clear(self) -> None:
        self.mode: SetPointMode | None = None
        """POSITION or SPEED while the pipe moves the axis, and until it is at rest after the pipe's end."""
        self.is_ending = False
        """True once the pipe has ended."""
        self._ramp: WholeProfile | None = None
        self._start = self._way = self._carry = self._since_ns = self._goal = self._value = 0
        self._span, self._interval_ns = 1, 0
        self._told_ns = self._due_ns = NEVER_NS

    # ---- the motion

    def at(self, now_ns: int) -> int:
        if self._ramp is not None:
            return self._ramp.at(now_ns)
        return self._start + (self._carry + self._way * (now_ns - self._since_ns)) // self._span

    def speed_at(self, now_ns: int) -> float:
        if self._ramp is not None:
            return self._ramp.speed_at(now_ns)
        return self._way * S / self._span

    @property
    def is_steady(self) -> bool:
        """True between two set-points of the mode POSITION."""
        return self.mode is SetPointMode.POSITION and not self.is_ending

    @property
    def is_moving(self) -> bool:
        return bool(self._way) or self._ramp is not None

    @property
    def interval_ns(self) -> int:
        """The interval of the set-points, as far as it is known."""
        return self._interval_ns or FIRST_NS

    @property
    def ramp(self) -> WholeProfile | None:
        return self._ramp

    # ---- set-points

    def begin(self, now_ns: int, mode: SetPointMode, position: int = 0) -> None:
        """A pipe begins to drive the axis, whose present position in the names of the pipe is `position`."""
        self.clear()
        self.mode, self._start, self._goal, self._value, self._since_ns = mode, position, position, position, now_ns

    def set_position(self, now_ns: int, value: int) -> None:
        step, period = value - self._value, self.period
        if period:
            step = (step + period // 2) % period - period // 2
        self._value = value
        self._aim(now_ns, self._goal + step, self._gap_ns(now_ns))

    def set_speed(self, now_ns: int, value: int) -> None:
        """Take a speed in RU/s."""
        fastest = int(self._limits.speed)
        value = min(max(value, -fastest), fastest)
        before = self.speed_at(now_ns)
        self._look(now_ns)
        largest_step = self._limits.acceleration * self._gap_ns(now_ns) / S
        self._way, self._span, self._ramp = value, S, None
        if abs(value - before) > largest_step:
            self._ramp = to_speed(now_ns, self._start, before, value, self._limits)

    def settle(self, now_ns: int) -> bool:
        """Hold the last set-point if the next one has not come; True if the motion has changed."""
        if now_ns < self._due_ns:
            return False
        self._aim(now_ns, self._goal, self.interval_ns)
        return True

    def end(self, now_ns: int) -> None:
        """No further set-points come: in the mode SPEED the axis ramps down."""
        self.is_ending = True
        self.settle(now_ns)
        if self.mode is SetPointMode.SPEED:
            before = self.speed_at(now_ns)
            self._look(now_ns)
            self._way, self._span = 0, 1
            self._ramp = to_speed(now_ns, self._start, before, 0, self._limits)

    def has_ended(self, now_ns: int) -> bool:
        """True once the pipe has ended, and its part is at rest."""
        if not self.is_ending:
            return False
        return now_ns >= self._ramp.done_ns if self._ramp is not None else not self._way

    def _aim(self, now_ns: int, goal: int, interval_ns: int) -> None:
        start = self.at(now_ns)
        self._start, self._way, self._span, self._carry = start, goal - start, interval_ns, 0
        self._since_ns, self._goal = now_ns, goal
        self._due_ns = now_ns + interval_ns if self._way else NEVER_NS

    def _look(self, now_ns: int) -> None:
        """Begin at the present position."""
        if self._ramp is not None:
            self._start, self._carry = self._ramp.at(now_ns), 0
        else:
            ways = self._carry + self._way * (now_ns - self._since_ns)
            self._start += ways // self._span
            self._carry = ways % self._span if self._span == S else 0
        self._since_ns = now_ns

    def _gap_ns(self, now_ns: int) -> int:
        """Return the interval of the set-points; a pause does not change it."""
        gap_ns, self._told_ns = now_ns - self._told_ns, now_ns
        known_ns = self._interval_ns
        if 0 < gap_ns <= (2 * known_ns or LONGEST_NS):
            self._interval_ns = gap_ns
        return self.interval_ns
