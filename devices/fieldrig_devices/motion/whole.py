"""A profile in whole units from an instant on: it ends exactly where it should, and runs without drift.

Within the ramps the position is that of the profile, rounded; after them it is integer arithmetic, however long the
axis keeps its speed.  Any unit of length will do, such as 2^32 to a turn.
"""

from math import ceil, inf

from fieldrig.clock import NEVER_NS, S
from fieldrig_devices.motion.profile import Limits, Profile, change_speed, keep, move


class WholeProfile:
    __slots__ = ("_end", "_end_speed", "_from", "_profile", "_since_ns", "done_ns")

    def __init__(self, now_ns: int, position: int, profile: Profile, end_speed: int, end: int | None = None) -> None:
        """Start `profile` at `position`; `end` is where it comes to rest, if that is known exactly."""
        self._since_ns, self._from, self._profile, self._end_speed = now_ns, position, profile, end_speed
        self.done_ns = now_ns + ceil(profile.duration_s * S)
        """The instant from which on the speed is the end speed."""
        self._end = position + round(profile.distance - end_speed * profile.duration_s) if end is None else end

    def at(self, now_ns: int) -> int:
        passed_ns = now_ns - self._since_ns
        if now_ns >= self.done_ns:
            return self._end + self._end_speed * passed_ns // S
        return self._from + round(self._profile.values_at(passed_ns / S)[0])

    def speed_at(self, now_ns: int) -> float:
        if now_ns >= self.done_ns:
            return self._end_speed
        return self._profile.values_at((now_ns - self._since_ns) / S)[1]

    def acceleration_at(self, now_ns: int) -> float:
        if now_ns >= self.done_ns:
            return 0.0
        return self._profile.values_at((now_ns - self._since_ns) / S)[2]

    def next_change_ns(self, now_ns: int) -> int:
        """Return the instant of the next change of the acceleration; `NEVER_NS` if there is none."""
        seconds = self._profile.phase_end_s((now_ns - self._since_ns) / S)
        if seconds == inf:
            return NEVER_NS
        return max(min(self._since_ns + ceil(seconds * S), self.done_ns), now_ns + 1)

    @property
    def end_speed(self) -> int:
        return self._end_speed

    def shift(self, distance: int) -> None:
        """Give all positions other names, without a motion."""
        self._from += distance
        self._end += distance


def at_rest(position: int) -> WholeProfile:
    return WholeProfile(0, position, keep(0.0), 0, position)


def to_position(now_ns: int, position: int, speed: float, target: int, limits: Limits) -> WholeProfile:
    """Return the motion that ends at rest at `target`."""
    return WholeProfile(now_ns, position, move(float(target - position), speed, limits), 0, target)


def to_speed(now_ns: int, position: int, speed: float, wanted: int, limits: Limits) -> WholeProfile:
    """Return the motion that ends at the speed `wanted`, in whole units per second."""
    return WholeProfile(now_ns, position, change_speed(speed, float(wanted), limits), wanted)
