"""What leads an axis by itself: a move that ends at rest, and a run that ends at a speed.

Source: manual 5.9.3; digest chapter 12.  Both follow their profile by the time since the instruction, so what is
sampled lies on the closed solution however long the control period is.
"""

from fieldrig.clock import S
from fieldrig_devices.arp.motion.axis import Axis
from fieldrig_devices.motion.profile import Profile, State, keep

_AT_REST = State(0.0, 0.0, 0.0)
_GRAIN_S = 1e-9  # of time: an end that falls together with a sample is not missed by the last bit of a float


class Move:
    """To rest at a reference that is exactly `end`, counted on from where the axis stands now."""

    def __init__(self, axis: Axis, profile: Profile, end: float, obeys_stop_flag: bool = True) -> None:
        self._obeys_stop_flag = obeys_stop_flag
        self._profile, self._begin_ns = profile, axis.now_ns
        self._origin, self._end = axis.reference, end

    def lead(self, axis: Axis, now_ns: int) -> None:
        if self._obeys_stop_flag and axis.flags.is_to_stop:
            coast(axis, now_ns)
        elif self.follow(axis, now_ns):
            axis.rest()

    def follow(self, axis: Axis, now_ns: int) -> bool:
        """Whether this was the end."""
        seconds = (now_ns - self._begin_ns) / S
        if seconds >= self._profile.duration_s - _GRAIN_S:
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
    """To a speed, which the axis then keeps until something else leads it."""

    def __init__(self, axis: Axis, profile: Profile) -> None:
        self._is_over = False
        """Whether the speed was reached, which ends the instruction."""
        self._profile, self._begin_ns = profile, axis.now_ns
        self._origin = axis.reference

    def lead(self, axis: Axis, now_ns: int) -> None:
        seconds = (now_ns - self._begin_ns) / S
        if not self._is_over:
            if seconds >= self._profile.duration_s - _GRAIN_S:
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
    """Leave the axis at the speed of the last control loop; what led it is over."""
    axis.guide = run = Run(axis, keep(axis.speed))
    run.lead(axis, now_ns)
