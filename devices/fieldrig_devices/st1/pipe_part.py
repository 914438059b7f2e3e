"""The part of a pipe in the set position of an axis (PAML-042, PAML-171, PAML-405).

Set-points of the mode POSITION come cycle by cycle; between them the axis moves steadily, so it is at each of them one
interval after it came (our reading: the manual does not say how an ST1 interpolates).  If a cycle brings no further
set-point, the axis holds the last one; if no cycle comes at all, it goes on steadily for `MOST_LOST` intervals before,
unless it is catching up with set-points that came late and then all at once.
In the mode SPEED the position is the sum of the speeds, exactly; a step of the speed is a ramp with the largest
acceleration.
"""

from typing import Final

from fieldrig.clock import MS, NEVER_NS, S
from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.motion.whole import WholeProfile, to_speed
from fieldrig_devices.pamring.frames import SetPointMode

LONGEST_NS: Final = 64 * MS
"""A longer time between two set-points is a pause, and not their interval."""
MOST_LOST: Final = 4
"""Number of intervals that an axis goes on without cycles, as frames may be damaged."""
PATIENCE: Final = 8
"""A set-point that comes much too early shortens the interval by this part of it; a late one doubles it."""
FIRST_NS: Final = MS
"""Interval as long as it is not known."""


class PipePart:
    __slots__ = (
        "_carry", "_goal", "_is_interval_known", "_limits", "_since_ns", "_span", "_start", "_told_ns",
        "_value", "_way", "due_ns", "interval_ns", "is_ending", "is_steady", "lost_ns", "mode", "period", "ramp",
        "speed",
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
        self.is_ending = self.is_steady = False
        """True once the pipe has ended; true while set-points of the mode POSITION come."""
        self.ramp: WholeProfile | None = None
        """The ramp to another speed, in the mode SPEED."""
        self._start = self._way = self._carry = self._since_ns = self._goal = self._value = 0
        self._span = 1
        self.speed = 0.0
        """RU/s while there is no ramp."""
        self.interval_ns, self._is_interval_known = FIRST_NS, False
        """The interval of the set-points, as far as it is known."""
        self._told_ns = NEVER_NS
        self.due_ns = NEVER_NS
        """The instant at which the axis is at the last set-point of the mode POSITION."""
        self.lost_ns = NEVER_NS
        """The instant from which on the axis holds the last set-point even if no cycle comes."""

    # ---- the motion

    def at(self, now_ns: int) -> int:
        if self.ramp is not None:
            return self.ramp.at(now_ns)
        if now_ns >= self.lost_ns:  # a timer may be late
            return self._goal
        return self._start + (self._carry + self._way * (now_ns - self._since_ns)) // self._span

    def speed_at(self, now_ns: int) -> float:
        return self.speed if self.ramp is None else self.ramp.speed_at(now_ns)

    @property
    def is_moving(self) -> bool:
        return bool(self._way) or self.ramp is not None

    # ---- set-points

    def begin(self, now_ns: int, mode: SetPointMode, position: int = 0) -> None:
        """A pipe begins to drive the axis, whose present position in the names of the pipe is `position`."""
        self.clear()
        self.mode, self._start, self._goal, self._value, self._since_ns = mode, position, position, position, now_ns
        self.is_steady = mode is SetPointMode.POSITION

    def set_position(self, now_ns: int, value: int) -> None:
        step, period = value - self._value, self.period
        if period:
            step = (step + period // 2) % period - period // 2
        self._value = value
        if now_ns - self._told_ns != self.interval_ns:
            self._look_at_interval(now_ns)
        self._told_ns = now_ns
        self._goal += step
        self._aim(now_ns, step)

    def set_speed(self, now_ns: int, value: int) -> None:
        """Take a speed in RU/s."""
        fastest = int(self._limits.speed)
        value = min(max(value, -fastest), fastest)
        before = self.speed_at(now_ns)
        self._look_at_interval(now_ns)
        self._told_ns = now_ns
        self._keep(now_ns, value)
        if abs(value - before) > self._limits.acceleration * self.interval_ns / S:
            self.ramp = to_speed(now_ns, self._start, before, value, self._limits)

    def settle(self, now_ns: int) -> bool:
        """Hold the last set-point if the next one has not come; True if the motion has changed."""
        if now_ns < self.due_ns:
            return False
        self._aim(now_ns)
        return True

    def hold(self, now_ns: int) -> None:
        """Be at the last set-point at once."""
        self._start, self._since_ns, self._way, self.speed = self._goal, now_ns, 0, 0.0
        self.due_ns = self.lost_ns = NEVER_NS

    def end(self, now_ns: int) -> None:
        """Take the end of set-points: in the mode SPEED the axis ramps down."""
        self.is_ending, self.is_steady = True, False
        self.settle(now_ns)
        if self.mode is SetPointMode.SPEED:
            before = self.speed_at(now_ns)
            self._keep(now_ns, 0)
            self.ramp = to_speed(now_ns, self._start, before, 0, self._limits)

    def has_ended(self, now_ns: int) -> bool:
        """True once the pipe has ended, and its part is at rest."""
        if not self.is_ending:
            return False
        return now_ns >= self.ramp.done_ns if self.ramp is not None else not self._way

    def _aim(self, now_ns: int, step: int = 0) -> None:
        """Move within one interval to the last set-point, which is a step away from the one before."""
        if now_ns >= self.lost_ns:
            start = self._goal - step
        else:
            start = self._start + self._way * (now_ns - self._since_ns) // self._span
        self._start, self._since_ns = start, now_ns
        self._way = way = self._goal - start
        self._span = interval_ns = self.interval_ns
        self.speed = way * S / interval_ns
        self.due_ns = now_ns + interval_ns if way else NEVER_NS
        self.lost_ns = self.due_ns + (MOST_LOST * interval_ns if abs(way) <= 2 * abs(step) else 0)

    def _keep(self, now_ns: int, speed: int) -> None:
        """Move at a speed in RU/s from the present position on, without a remainder."""
        if self.ramp is not None:
            self._start, self._carry, self.ramp = self.ramp.at(now_ns), 0, None
        else:
            ways = self._carry + self._way * (now_ns - self._since_ns)
            self._start += ways // self._span
            self._carry = ways % self._span if self._span == S else 0
        self._since_ns, self._way, self._span, self.speed = now_ns, speed, S, float(speed)

    def _look_at_interval(self, now_ns: int) -> None:
        """Take the time since the last set-point as the interval, unless it is a pause or the host was late."""
        gap_ns, interval_ns = now_ns - self._told_ns, self.interval_ns
        if not self._is_interval_known:
            if 0 < gap_ns <= LONGEST_NS:
                self.interval_ns, self._is_interval_known = gap_ns, True
        elif interval_ns <= 2 * gap_ns <= 4 * interval_ns:
            self.interval_ns = gap_ns
        elif interval_ns < gap_ns <= LONGEST_NS:
            self.interval_ns = 2 * interval_ns
        elif 0 < gap_ns < interval_ns:
            self.interval_ns -= interval_ns // PATIENCE
