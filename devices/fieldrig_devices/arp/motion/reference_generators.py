"""Generators that move an axis on its own: a move that ends at rest, and a run that ends at a speed.

Source: manual 5.9.3; digest chapter 12.  Both follow their profile by the time since the instruction, so samples are
points of the closed solution regardless of the control period.
"""

from fieldrig.clock import S
from fieldrig_devices.arp.motion.axis import Axis
from fieldrig_devices.motion.profile import Profile, State, keep

_AT_REST = State(0.0, 0.0, 0.0)
_TIME_TOLERANCE_S = 1e-9  # time tolerance, so that rounding cannot delay an end that coincides with a sample


class Move:
    """Moves to rest at a reference of exactly `end`, from the present position."""

    def __init__(self, axis: Axis, profile: Profile, end: float, obeys_stop_flag: bool = True) -> None:
        self._obeys_stop_flag = obeys_stop_flag
        self._profile, self._begin_ns = profile, axis.now_ns
        self._origin, self._end = axis.reference, end

    def advance(self, axis: Axis, now_ns: int) -> None:
        if self._obeys_stop_flag and axis.flags.is_to_stop:
            coast(axis, now_ns)
        elif self.follow(axis, now_ns):
            axis.rest()

    def follow(self, axis: Axis, now_ns: int) -> bool:
        """Move the axis on.  Returns True at the end of the move."""
        seconds = (now_ns - self._begin_ns) / S
        if seconds >= self._profile.duration_s - _TIME_TOLERANCE_S:
            axis.place(self._end, _AT_REST)
            return True
        state = self._profile.at(seconds)
        if removed := axis.place(self._origin + state.position, state):
            self.shift(-removed)
        return False

    def shift(self, distance: float) -> None:
        self._origin += distance
        self._end += distance


class Run:
    """Changes to a speed, which the axis then keeps until another generator takes over."""

    def __init__(self, axis: Axis, profile: Profile) -> None:
        self._is_over = False
        """True once the speed was reached, which ends the instruction."""
        self._profile, self._begin_ns = profile, axis.now_ns
        self._origin = axis.reference

    def advance(self, axis: Axis, now_ns: int) -> None:
        seconds = (now_ns - self._begin_ns) / S
        if not self._is_over:
            if seconds >= self._profile.duration_s - _TIME_TOLERANCE_S:
                self._is_over = True
                axis.end_at_speed()
            elif axis.flags.is_to_stop:
                coast(axis, now_ns)
                return
        state = self._profile.at(seconds)
        if removed := axis.place(self._origin + state.position, state):
            self.shift(-removed)

    def shift(self, distance: float) -> None:
        self._origin += distance


def coast(axis: Axis, now_ns: int) -> None:
    """Leave the axis at the speed of the last control loop, and end its generator."""
    axis.generator = run = Run(axis, keep(axis.speed))
    run.advance(axis, now_ns)
