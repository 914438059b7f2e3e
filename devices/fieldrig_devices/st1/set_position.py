"""The set position of an axis: the own part, which orders move, and the part of a pipe; the axis follows the sum.

Source: PAM manual 1093-1096, 1142-1154, 6727-6993 (PAML-042 to PAML-064, PAMS-010 to PAMS-018).  Positions are whole
resolver units (RU), 2^32 to a turn of the motor.  Names and motor differ by an offset, so a new name moves nothing.
"""

from enum import Enum, auto
from typing import Final

from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.motion.whole import at_rest, to_position, to_speed
from fieldrig_devices.pamring.frames import AxisOrder, Move, SetPointMode
from fieldrig_devices.st1.pipe_part import PipePart


class Doing(Enum):
    """The motions of the own part."""

    NOTHING = auto()
    MOVE = auto()
    RUN = auto()
    STOP = auto()


DOES: Final = {
    Move.ABSOLUTE_MOVE: Doing.MOVE,
    Move.RELATIVE_MOVE: Doing.MOVE,
    Move.RUN: Doing.RUN,
    Move.STOP: Doing.STOP,
}


class SetPosition:
    __slots__ = ("_limits", "_own", "_stop", "doing", "offset", "period", "pipe", "was_stopped")

    def __init__(self, limits: Limits) -> None:
        """`limits` are CKV, CKA and ASTOP in RU/s and RU/s2."""
        self._limits = Limits(limits.speed, limits.acceleration, limits.acceleration)
        self._stop = limits.deceleration
        self._own = at_rest(0)
        self.pipe = PipePart(self._limits)
        self.doing = Doing.NOTHING
        self.offset = 0
        """RU from a position's name to that of the motor."""
        self.period = 0
        self.was_stopped = False
        """True from a stop until the next order or pipe."""

    # ---- where it is

    def motor_at(self, now_ns: int) -> int:
        """Return the set position of the motor."""
        return self._own.at(now_ns) + self.pipe.at(now_ns) + self.offset

    def speed_at(self, now_ns: int) -> float:
        return self._own.speed_at(now_ns) + self.pipe.speed_at(now_ns)

    def acceleration_at(self, now_ns: int) -> float:
        ramp = self.pipe.ramp
        return self._own.acceleration_at(now_ns) + (0.0 if ramp is None else ramp.acceleration_at(now_ns))

    def name_at(self, now_ns: int) -> int:
        """Return the position that the application knows, from 0 to the period if there is one."""
        return self.named(self.motor_at(now_ns))

    def named(self, motor: int) -> int:
        position = motor - self.offset
        return position % self.period if self.period else position

    def own_at(self, now_ns: int) -> int:
        """Return the own part."""
        return self._own.at(now_ns)

    @property
    def is_own_moving(self) -> bool:
        return self.doing is not Doing.NOTHING

    @property
    def is_moving(self) -> bool:
        """True if the set position changes by itself."""
        return self.doing is not Doing.NOTHING or self.pipe.is_moving

    def is_done(self, now_ns: int) -> bool:
        """True once the own part has reached what it was ordered to."""
        return now_ns >= self._own.done_ns

    def next_change_ns(self, now_ns: int) -> int:
        """Return the instant of the next change of the acceleration, apart from set-points."""
        ramp = self.pipe.ramp
        own_ns = self._own.next_change_ns(now_ns)
        return own_ns if ramp is None else min(own_ns, ramp.next_change_ns(now_ns))

    # ---- orders

    def order(self, now_ns: int, order: AxisOrder) -> None:
        """Begin a motion: ABSOLUTE_MOVE, RELATIVE_MOVE, RUN or STOP."""
        own, limits = self._own, self._limits_of(order)
        speed = own.speed_at(now_ns)
        if order.move is Move.STOP:
            self.stop(now_ns, order.deceleration)
        elif order.move is Move.RUN:
            fastest = int(self._limits.speed)
            wanted = min(max(order.value, -fastest), fastest)
            self._own = to_speed(now_ns, own.at(now_ns), speed, wanted, limits)
        else:
            target = self._target(now_ns, order)
            self._own = to_position(now_ns, own.at(now_ns), speed, target, limits)
        self.doing, self.was_stopped = DOES[order.move], order.move is Move.STOP

    def stop(self, now_ns: int, deceleration: int = 0) -> None:
        """Bring the sum to rest, with ASTOP if no deceleration is given; no pipe drives the axis any longer."""
        rate = min(deceleration, self._limits.acceleration) if deceleration > 0 else self._stop
        limits = Limits(self._limits.speed, rate, rate)
        position, speed = self._own.at(now_ns) + self.pipe.at(now_ns), self.speed_at(now_ns)
        self.pipe.clear()
        self._own = to_speed(now_ns, position, speed, 0, limits)
        self.doing, self.was_stopped = Doing.STOP, True

    def finish(self, now_ns: int) -> bool:
        """Call this in due time: a motion that is done ends; True if something has ended."""
        has_ended = False
        if self.pipe.has_ended(now_ns):
            self._own.shift(self.pipe.at(now_ns))
            self.pipe.clear()
            has_ended = True
        if self.doing is not Doing.NOTHING and self.is_done(now_ns) and not self._own.end_speed:
            self.doing = Doing.NOTHING
            has_ended = True
        if has_ended and self.doing is Doing.NOTHING and self.pipe.mode is None:
            self._wrap(now_ns)
        return has_ended

    def hold(self, now_ns: int, motor: int) -> None:
        """Make the position of a shaft without power the set position."""
        self.pipe.clear()
        self._own = at_rest(motor - self.offset)
        self.doing = Doing.NOTHING
        self._wrap(now_ns)

    def rename(self, now_ns: int, position: int) -> None:
        """Give the present position a new name, without a motion (PAML-058)."""
        distance = position - self._own.at(now_ns) - self.pipe.at(now_ns)
        self._own.shift(distance)
        self.offset -= distance

    # ---- set-points

    def set_point(self, now_ns: int, mode: SetPointMode, value: int) -> None:
        pipe = self.pipe
        if pipe.mode is not mode or pipe.is_ending:
            self._begin_pipe(now_ns, mode, value)
        if mode is SetPointMode.POSITION:
            pipe.set_position(now_ns, value)
        else:
            pipe.set_speed(now_ns, value)

    def end_of_pipe(self, now_ns: int, mode: SetPointMode) -> None:
        if self.pipe.mode is mode:
            self.pipe.end(now_ns)
            self.finish(now_ns)

    def _begin_pipe(self, now_ns: int, mode: SetPointMode, value: int) -> None:
        """Begin a pipe, where another one may still end."""
        self._own.shift(self.pipe.at(now_ns))
        self.pipe.period, self.was_stopped = self.period, False
        if mode is SetPointMode.SPEED:
            self.pipe.begin(now_ns, mode)
            return
        own = self._own.at(now_ns)
        position = own + self.offset
        if self.period:  # the shorter way to the first set-point
            own = value - ((value - own + self.period // 2) % self.period - self.period // 2)
        self._own.shift(-self._own.at(now_ns))
        self.pipe.begin(now_ns, mode, own)
        self.offset = position - own

    # ---- helpers

    def _limits_of(self, order: AxisOrder) -> Limits:
        """Return the limits of an order, clipped to those of the axis (PAML-048, PAML-049)."""
        speed, most = self._limits.speed, self._limits.acceleration
        acceleration = min(order.acceleration, most) if order.acceleration > 0 else most
        deceleration = min(order.deceleration, most) if order.deceleration > 0 else acceleration
        return Limits(min(order.speed, speed) if order.speed > 0 else speed, acceleration, deceleration)

    def _target(self, now_ns: int, order: AxisOrder) -> int:
        if order.move is Move.RELATIVE_MOVE:
            return self._own.at(now_ns) + order.value
        if self.period and self.pipe.mode is None:
            self._wrap(now_ns)  # the move goes by the numbers (G-14)
        return order.value

    def _wrap(self, now_ns: int) -> None:
        """Bring the name of the own part into the period."""
        if self.period:
            turns = self._own.at(now_ns) // self.period * self.period
            self._own.shift(-turns)
            self.offset += turns
