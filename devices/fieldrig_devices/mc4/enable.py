"""The enable chain: brake relay, torque, ready contact and states of an MC-4 over time.

Source: manual chapter 10 (6066-6171), digest PD-150 to PD-160; only the text of its drawings is available.  The
chain knows no motor: it gets the time, the enables and the speed of the motor, and gives the task of the loops.  State
values that the manual does not give are those of digest 3.2.

Our readings: an enable that returns while the drive ramps down waits for the end of the ramp.  After coasting because
of bEnableCoast there is no error to acknowledge: the next enable leaves 0x02, and so does an acknowledgement.  An error
can be acknowledged once the drive is at standstill without torque (0x02, 0x32), not before.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from fieldrig.clock import MS

OVERLOAD_STOP_NS = 800 * MS  # manual 6158


class Stage(Enum):
    """The stages of the chain, each with its AxisState and MC4State."""

    NO_HARDWARE_ENABLE = (0, 0x03)  # manual 6073
    WAITING = (1, 0x10)  # manual 6073
    LIFTING = (2, 0x20)
    CONTROLLED = (3, 0x21)
    OVERLOAD_STOP = (4, 0x30)
    OVERLOAD_HELD = (4, 0x32)  # manual 6158; the MC4State only
    RAMPING = (4, 0x40)
    COUPLING = (4, 0x41)
    COASTING = (4, 0x42)
    STOPPED = (5, 0x02)  # manual 6143; the MC4State only


class Task(Enum):
    """The task of the loops."""

    NOTHING = 0
    """No torque."""
    FOLLOW = 1
    """Follow the command values."""
    HOLD = 2
    """Hold the position at which the stage was entered."""
    STOP = 3
    """Bring the speed to 0 with maximum current."""


TASKS = {
    Stage.NO_HARDWARE_ENABLE: Task.NOTHING,
    Stage.WAITING: Task.NOTHING,
    Stage.LIFTING: Task.HOLD,
    Stage.CONTROLLED: Task.FOLLOW,
    Stage.OVERLOAD_STOP: Task.HOLD,
    Stage.OVERLOAD_HELD: Task.HOLD,
    Stage.RAMPING: Task.STOP,
    Stage.COUPLING: Task.STOP,
    Stage.COASTING: Task.NOTHING,
    Stage.STOPPED: Task.NOTHING,
}
LIFTED = {Stage.LIFTING, Stage.CONTROLLED, Stage.OVERLOAD_STOP, Stage.OVERLOAD_HELD, Stage.RAMPING}
"""Stages in which the brake relay is closed; while coasting, it depends on the times."""
SETTLED = {Stage.NO_HARDWARE_ENABLE, Stage.WAITING, Stage.CONTROLLED, Stage.OVERLOAD_HELD, Stage.STOPPED}
"""Stages that only an external event ends."""


class Reaction(Enum):
    """The drive's reaction to an error."""

    NONE = 0
    OVERLOAD = 1
    B = 2
    A = 3


class Limit(Enum):
    """Limits that the chain itself monitors."""

    STOP_TIME = "Stop time limit exceeded"
    OVERLOAD_STOP_TIME = "ramping-down time exceeded"


@dataclass
class Times:
    """Parameters of the axis that the controller may change.  The first is in manual 6075, the others in digest 3.2."""

    brake_disconnection_ns: int = 100 * MS
    brake_coupling_ns: int = 50 * MS
    stop_limit_ns: int = 1000 * MS
    enable_coast: bool = False
    error_coast: bool = False
    brake_coast: bool = False
    """CoastOption for the brake: it drops only at standstill."""
    safe_stop_coasts: bool = False
    """True if losing Inverter Enable switches the torque off at once; otherwise the drive ramps down."""


class Seen(NamedTuple):
    """The inputs of the chain."""

    hardware: bool
    controller: bool
    can_start: bool
    """DC circuit charged, all phases connected, motor known."""
    is_slow: bool
    """The speed is below n_min."""
    is_at_overload_position: bool = False


class EnableChain:
    """The stage of the chain, and the times and events that change it."""

    def __init__(self, times: Times, on_limit: Callable[[Limit], None]) -> None:
        """`on_limit` has to call `react`."""
        self.times, self._on_limit = times, on_limit
        self.stage = Stage.NO_HARDWARE_ENABLE
        self.error = Reaction.NONE
        """The reaction in progress, or the one that waits to be acknowledged."""
        self._until_ns = 0
        self._is_lifted = False
        self._was_limit_told = False

    @property
    def axis_state(self) -> int:
        return self.stage.value[0]

    @property
    def mc4_state(self) -> int:
        return self.stage.value[1]

    @property
    def task(self) -> Task:
        return TASKS[self.stage]

    @property
    def has_torque(self) -> bool:
        return TASKS[self.stage] is not Task.NOTHING

    @property
    def is_brake_lifted(self) -> bool:
        """True if the brake relay is closed."""
        return self._is_lifted

    @property
    def is_ready(self) -> bool:
        """True if the ready contact is closed."""
        return self.error in (Reaction.NONE, Reaction.OVERLOAD) and self.stage not in (Stage.COASTING, Stage.STOPPED)

    @property
    def is_settled(self) -> bool:
        return self.stage in SETTLED

    # ---- events

    def react(self, now_ns: int, reaction: Reaction) -> None:
        """Start the reaction to an error that has just occurred."""
        if reaction is Reaction.OVERLOAD:
            if self.stage in (Stage.LIFTING, Stage.CONTROLLED):
                self.error = max(self.error, reaction, key=_weight)
                self._enter(Stage.OVERLOAD_STOP, now_ns)
            return
        if reaction is Reaction.NONE or _weight(reaction) <= _weight(self.error):
            return
        self.error = reaction
        if reaction is Reaction.A:
            if self.stage is not Stage.STOPPED:
                self._coast(now_ns)
        elif self.has_torque:
            self._react_b(now_ns)
        elif self.stage is not Stage.COASTING:
            self._enter(Stage.STOPPED, now_ns)

    def _react_b(self, now_ns: int) -> None:
        if self.times.error_coast:
            self._coast(now_ns)
        elif self.stage is not Stage.COUPLING:
            self._enter(Stage.RAMPING, now_ns)  # restart a ramp that is in progress: PD-152

    @property
    def can_quit(self) -> bool:
        return self.stage in (Stage.STOPPED, Stage.OVERLOAD_HELD) or self.error is Reaction.NONE

    def quit(self, now_ns: int) -> None:
        """Leave the error; call it only if `can_quit`."""
        self.error = Reaction.NONE
        if self.stage is Stage.STOPPED:
            self._enter(Stage.WAITING, now_ns)
        elif self.stage is Stage.OVERLOAD_HELD:
            self._enter(Stage.CONTROLLED, now_ns)

    def take_torque(self, now_ns: int) -> None:
        """Switch the torque off at once, without an error: the master has reset drive enable (IEC 61491)."""
        if self.has_torque:
            self._coast(now_ns)

    # ---- time

    def update(self, now_ns: int, seen: Seen) -> bool:
        """Advance through all stages that are due; True if the stage has changed."""
        before = self.stage
        for _ in range(len(Stage)):
            stage = self.stage
            _CONDITIONS[stage](self, now_ns, seen)
            if self.stage is stage:
                break
        return self.stage is not before

    def _wait(self, now_ns: int, seen: Seen) -> None:
        if not seen.hardware:
            self._enter(Stage.NO_HARDWARE_ENABLE, now_ns)
        elif self.stage is Stage.NO_HARDWARE_ENABLE:
            self._enter(Stage.WAITING, now_ns)
        elif seen.controller and seen.can_start:
            self._enter(Stage.LIFTING, now_ns)

    def _lift(self, now_ns: int, seen: Seen) -> None:
        if not self._is_taken_away(now_ns, seen) and now_ns >= self._until_ns:
            self._enter(Stage.CONTROLLED, now_ns)

    def _is_taken_away(self, now_ns: int, seen: Seen) -> bool:
        """React to a missing enable; True if one is missing."""
        if seen.hardware and seen.controller:
            return False
        times = self.times
        if times.enable_coast or (times.safe_stop_coasts and not seen.hardware):
            self._coast(now_ns)
        else:
            self._enter(Stage.RAMPING, now_ns)
        return True

    def _stop_overload(self, now_ns: int, seen: Seen) -> None:
        if self._is_taken_away(now_ns, seen):
            return
        if seen.is_slow and seen.is_at_overload_position:
            self._enter(Stage.OVERLOAD_HELD, now_ns)
        elif now_ns >= self._until_ns:
            self._on_limit(Limit.OVERLOAD_STOP_TIME)

    def _ramp(self, now_ns: int, seen: Seen) -> None:
        if seen.is_slow:
            self._enter(Stage.COUPLING, now_ns)
        elif now_ns >= self._until_ns:
            is_second = self.error is Reaction.B
            if not self._was_limit_told:
                self._was_limit_told = True
                self._on_limit(Limit.STOP_TIME)
            if is_second:
                self._enter(Stage.COUPLING, now_ns)

    def _couple(self, now_ns: int, seen: Seen) -> None:
        if now_ns < self._until_ns:
            return
        if not seen.is_slow:
            self.stage = Stage.COASTING  # the brake has already dropped
        else:
            self._enter(Stage.WAITING if self.error is Reaction.NONE else Stage.STOPPED, now_ns)

    def _roll_out(self, now_ns: int, seen: Seen) -> None:
        if self._is_lifted and seen.is_slow:
            self._is_lifted = False
            self._until_ns = now_ns + self.times.brake_coupling_ns
        if not self._is_lifted and seen.is_slow and now_ns >= self._until_ns:
            self._enter(Stage.STOPPED, now_ns)

    def _stand(self, now_ns: int, seen: Seen) -> None:
        if self.error is Reaction.NONE and seen.hardware and seen.controller:
            self._enter(Stage.WAITING, now_ns)

    def _coast(self, now_ns: int) -> None:
        if self.stage is not Stage.COASTING:
            was_lifted = self._is_lifted
            self.stage = Stage.COASTING
            self._is_lifted = was_lifted and self.times.brake_coast
            self._until_ns = now_ns + self.times.brake_coupling_ns

    def _enter(self, stage: Stage, now_ns: int) -> None:
        times = self.times
        if stage is Stage.LIFTING or (stage is Stage.RAMPING and self.stage is not Stage.RAMPING):
            self._was_limit_told = False
        self.stage = stage
        self._is_lifted = stage in LIFTED
        if stage is Stage.LIFTING:
            self._until_ns = now_ns + times.brake_disconnection_ns
        elif stage is Stage.OVERLOAD_STOP:
            self._until_ns = now_ns + OVERLOAD_STOP_NS
        elif stage is Stage.RAMPING:
            self._until_ns = now_ns + times.stop_limit_ns
        elif stage is Stage.COUPLING:
            self._until_ns = now_ns + times.brake_coupling_ns


def _weight(reaction: Reaction) -> int:
    return reaction.value


def _nothing(chain: EnableChain, now_ns: int, seen: Seen) -> None:
    """Do nothing: only an event ends this stage."""


_CONDITIONS: dict[Stage, Callable[[EnableChain, int, Seen], object]] = {
    Stage.NO_HARDWARE_ENABLE: EnableChain._wait,
    Stage.WAITING: EnableChain._wait,
    Stage.LIFTING: EnableChain._lift,
    Stage.CONTROLLED: EnableChain._is_taken_away,
    Stage.OVERLOAD_STOP: EnableChain._stop_overload,
    Stage.OVERLOAD_HELD: EnableChain._is_taken_away,
    Stage.RAMPING: EnableChain._ramp,
    Stage.COUPLING: EnableChain._couple,
    Stage.COASTING: EnableChain._roll_out,
    Stage.STOPPED: EnableChain._stand,
}
"""The condition that each stage waits for."""
