"""A DC motor with two outputs, a pulse counter and a zero switch, which the node moves by itself (PAML-120 to 130).

The manual names the functions and the errors; what follows is how we read them (G-09, G-10):

- A pulse has no direction, so it counts in the direction that was driven last.
- The output is switched off BRAKING pulses before the target, but not before the motor has moved by one pulse.  The
  motor coasts, and the order is done when no pulse has come for a while.  An order for the other direction waits for
  that.
- Stroke limits are targets that no order passes; an order that would is ended there with the error of the limit.  A
  search for zero has no limits, as it begins at an unknown position.
- zero_position ends at once if ZERO has its level already.  The position is 0 where ZERO gets its level, or by a
  setting where the motor comes to rest behind it.
- A pulse at rest is an unexpected move.  When there were more of them than BRAKING, the position is lost until it is
  named again.
- The position is lost, too, when a motor that does not stop has been coasting for TIMEOUT, as it may turn either way.
  An order that waits for the stop ends with this error.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from typing import Final

from fieldrig.clock import Alarm, Clock
from fieldrig_devices.pamring.frames import Motor
from fieldrig_devices.smart_io.troubles import MOTOR_BITS, FaultCode

OPERANDS: Final = {
    Motor.ABSOLUTE_MOVE: 1,
    Motor.RELATIVE_MOVE: 1,
    Motor.RUN: 1,
    Motor.STOP: 0,
    Motor.POSITION: 1,
    Motor.ZERO_POSITION: 2,
    Motor.STROKE_LIMITS: 2,
    Motor.DISABLE_STROKE_LIMITS: 0,
}
_BY_ORDER: Final = (
    FaultCode.TIMEOUT,
    FaultCode.LOWER_LIMIT,
    FaultCode.UPPER_LIMIT,
    FaultCode.UNEXPECTED_MOVE,
    FaultCode.DOES_NOT_STOP,
)
"""Errors that end with the next order to move."""
_HALF: Final = 1 << 31


class MotorState(Enum):
    REST = auto()
    DRIVEN = auto()
    COASTING = auto()


@dataclass(frozen=True, slots=True)
class Goal:
    """The end of an order: a target, a level of ZERO, or neither, which is until stop."""

    direction: int
    target: int | None = None
    zero: bool | None = None


@dataclass(frozen=True, slots=True)
class MotorLimits:
    timeout_ns: int
    """TIMEOUT: longest time without a pulse while the motor is driven."""
    rest_ns: int
    """The motor counts as stopped when no pulse has come for this long."""
    names_at_rest: bool = False
    """True if zero_position names the position when the motor has stopped, False if at the edge of ZERO."""
    stray_pulses: int | None = None
    """The most pulses at rest with which the position is not lost; None is BRAKING."""


class DcMotor:
    def __init__(
        self,
        clock: Clock,
        own: MotorLimits,
        braking: int,
        drive: Callable[[int], None],
        is_zero_high: Callable[[], bool],
        on_change: Callable[[], None],
    ) -> None:
        """`drive` switches the outputs: 1 for INC, -1 for DEC, 0 for none."""
        self._clock, self._own, self._braking = clock, own, braking
        self._drive, self._is_zero_high, self._on_change = drive, is_zero_high, on_change
        self.state = MotorState.REST
        self.position = 0
        self.errors: frozenset[FaultCode] = frozenset()
        self.is_ready = True
        self._limits: tuple[int, int] | None = None
        self.direction = 1
        """The direction that was driven last."""
        self._is_zero_due = False
        """True if the position is 0 where the motor comes to rest."""
        self._goal = self._next = Goal(0)
        """The present order, and the one that waits for the motor to stop; direction 0 is none."""
        self._off_at: int | None = None
        """The position at which the output is switched off."""
        self._off_error: FaultCode | None = None
        self._stray = 0
        """Pulses at rest."""
        self._off_ns = 0
        self._timer = Alarm(self._clock)

    @property
    def error_word(self) -> int:
        """Table 12-3."""
        return sum(MOTOR_BITS[fault] for fault in self.errors)

    # ---- orders

    def order(self, order: Motor, values: Sequence[int]) -> bool:
        """Carry out an order; False if its values are not those that it takes."""
        if len(values) != OPERANDS[order]:
            return False
        match order:
            case Motor.ABSOLUTE_MOVE:
                self._move_to(values[0])
            case Motor.RELATIVE_MOVE:
                self._move_to(self.position + values[0])
            case Motor.RUN:
                return self._run(values[0])
            case Motor.STOP:
                self._stop()
            case Motor.POSITION:
                self._name(values[0])
            case Motor.ZERO_POSITION:
                return self._find_zero(values[0], values[1])
            case Motor.STROKE_LIMITS:
                return self._limit((values[0], values[1]))
            case Motor.DISABLE_STROKE_LIMITS:
                return self._limit(None)
        return True

    def _move_to(self, target: int) -> None:
        target = wrapped(target)
        self._begin(Goal(self._towards(target), target))

    def _towards(self, target: int) -> int:
        return (target > self.position) - (target < self.position)

    def _run(self, direction: int) -> bool:
        if direction not in (1, -1):
            return False
        self._begin(Goal(direction))
        return True

    def _find_zero(self, direction: int, level: int) -> bool:
        if direction not in (1, -1) or level not in (0, 1):
            return False
        self._begin(Goal(direction, zero=bool(level)))
        return True

    def _stop(self) -> None:
        self._next = Goal(0)
        self._tell(is_ready=False)
        if self.state is MotorState.DRIVEN:
            self._switch_off()
        elif self.state is MotorState.REST:
            self._tell(is_ready=True)

    def _name(self, position: int) -> None:
        self.position = wrapped(position)
        self._stray, self._is_zero_due = 0, False
        self._tell(less=(FaultCode.POSITION_LOST,))
        self._aim()

    def _limit(self, limits: tuple[int, int] | None) -> bool:
        if limits is not None and limits[0] > limits[1]:
            return False
        self._limits = limits
        self._aim()
        return True

    def _begin(self, goal: Goal) -> None:
        """Begin an order at once, or when the motor has stopped if it turns the other way."""
        self._stray = 0
        if self._is_zero_due:
            self._name(0)
        self._tell(is_ready=False, less=_BY_ORDER)
        turns = 0 if self.state is MotorState.REST else self.direction
        if turns and goal.direction != turns:
            self._next = goal
            if self.state is MotorState.DRIVEN:
                self._switch_off()
            return
        self._start(goal)

    def _start(self, goal: Goal) -> None:
        if goal.target is not None:  # the motor may have coasted since the order came
            goal = Goal(self._towards(goal.target), goal.target)
        self._goal, self._next = goal, Goal(0)
        if goal.zero is not None and self._is_zero_high() is goal.zero:
            self._found_zero()
            self._rest_or_coast()
        elif goal.direction == 0:
            self._rest_or_coast()
        elif (error := self._limit_error(goal)) is not None:
            self._tell(more=(error,))
            self._rest_or_coast()
        else:
            self.state, self.direction = MotorState.DRIVEN, goal.direction
            self._drive(goal.direction)
            self._aim()
            self._wait(self._own.timeout_ns, self._on_timeout)

    def _found_zero(self) -> None:
        if self._own.names_at_rest and self.state is not MotorState.REST:
            self._is_zero_due = True
        else:
            self._name(0)

    def _rest_or_coast(self) -> None:
        """End an order that needs no motion."""
        if self.state is MotorState.REST:
            self._tell(is_ready=True)
        else:
            self._switch_off()

    def _limit_error(self, goal: Goal) -> FaultCode | None:
        """The error of an order that leads out of the limits from where the motor is."""
        if self._limits is None or goal.zero is not None:
            return None
        lower, upper = self._limits
        if goal.direction > 0:
            return FaultCode.UPPER_LIMIT if self.position >= upper else None
        return FaultCode.LOWER_LIMIT if self.position <= lower else None

    def _aim(self) -> None:
        """Determine where the output of the present order is switched off."""
        goal, direction = self._goal, self._goal.direction
        self._off_at, self._off_error = goal.target, None
        if self._limits is not None and goal.zero is None and direction:
            limit = self._limits[1] if direction > 0 else self._limits[0]
            if goal.target is None or (goal.target - limit) * direction > 0:
                self._off_at = limit
                self._off_error = FaultCode.UPPER_LIMIT if direction > 0 else FaultCode.LOWER_LIMIT
        if self._off_at is not None:
            self._off_at -= direction * self._braking

    # ---- what the motor does

    def on_pulse(self) -> None:
        """Count a pulse."""
        self.position = wrapped(self.position + self.direction)
        if self.state is MotorState.DRIVEN:
            self._wait(self._own.timeout_ns, self._on_timeout)
            if self._off_at is not None and (self.position - self._off_at) * self.direction >= 0:
                self._tell(more=() if self._off_error is None else (self._off_error,))
                self._switch_off()
        elif self.state is MotorState.COASTING:
            self._wait(self._own.rest_ns, self._on_rest)
            if self._clock.now_ns() - self._off_ns > self._own.timeout_ns:
                self._next = Goal(0)
                self._tell(is_ready=True, more=(FaultCode.DOES_NOT_STOP, FaultCode.POSITION_LOST))
        else:
            self._stray += 1
            most = self._braking if self._own.stray_pulses is None else self._own.stray_pulses
            lost = (FaultCode.POSITION_LOST,) if self._stray > most else ()
            self._tell(more=(FaultCode.UNEXPECTED_MOVE, *lost))

    def on_zero(self) -> None:
        """Take a change of the input ZERO."""
        if self.state is MotorState.DRIVEN and self._goal.zero is self._is_zero_high():
            self._found_zero()
            self._switch_off()

    def halt(self) -> None:
        """Switch the motor off, because the node no longer works."""
        self._next = Goal(0)
        if self.state is MotorState.DRIVEN:
            self._switch_off()

    def close(self) -> None:
        """End permanently."""
        self._drive(0)
        self._timer.stop()

    def _switch_off(self) -> None:
        self._drive(0)
        self.state, self._goal, self._off_at = MotorState.COASTING, Goal(0), None
        self._off_ns = self._clock.now_ns()
        self._wait(self._own.rest_ns, self._on_rest)

    def _on_timeout(self) -> None:
        self._tell(more=(FaultCode.TIMEOUT,))
        self._switch_off()

    def _on_rest(self) -> None:
        self.state = MotorState.REST
        if self._is_zero_due:
            self._name(0)
        if self._next.direction or self._next.target is not None:
            self._start(self._next)
        else:
            self._tell(is_ready=True)

    def _wait(self, time_ns: int, action: Callable[[], None]) -> None:
        self._timer.after(time_ns, action)

    def _tell(
        self, *, is_ready: bool | None = None, more: Sequence[FaultCode] = (), less: Sequence[FaultCode] = ()
    ) -> None:
        """Change what is known of the motor, and report it if it is different."""
        errors = (self.errors - frozenset(less)) | frozenset(more)
        is_ready = self.is_ready if is_ready is None else is_ready
        if errors != self.errors or is_ready is not self.is_ready:
            self.errors, self.is_ready = errors, is_ready
            self._on_change()


def wrapped(position: int) -> int:
    """Return a position as a signed number of 32 bits."""
    return (position + _HALF) % (2 * _HALF) - _HALF
