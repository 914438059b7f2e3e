"""The TMP generator: positions with a trapezoidal speed, as a source of pipes (PAML-630 to PAML-635)."""

from fieldrig_devices.motion.profile import Limits, Profile, change_speed, keep, move
from fieldrig_devices.pam.pipes.generator import Generator


class TmpGenerator(Generator):
    """Speeds are in u/s, accelerations in u/s2.  A command takes the parameters of its instant (PAML-632)."""

    def __init__(self, limits: Limits, initial_position: float, position_period: float | None) -> None:
        super().__init__(initial_position, position_period)
        self.limits = limits
        self._way: Profile = keep(0.0)

    @property
    def speed(self) -> float:
        return self._way.values_at(self._seconds)[1] if self.is_active else 0.0

    @property
    def acceleration(self) -> float:
        return self._way.values_at(self._seconds)[2] if self.is_active else 0.0

    def _moved(self, seconds: float) -> float:
        return self._way.values_at(seconds)[0]

    def _rest(self) -> None:
        self._way = keep(0.0)

    def absolute_move(self, position: float) -> None:
        self._follow(move(self._way_to(position), self.speed, self.limits), position)

    def relative_move(self, distance: float) -> None:
        self._follow(move(distance, self.speed, self.limits), self._absolute + distance)

    def run(self, speed: float) -> None:
        way = change_speed(self.speed, speed, self.limits)
        self._follow(way, None, self._run_is_ready_s(speed, way.duration_s))

    def _follow(self, way: Profile, end: float | None, ready_s: float | None = None) -> None:
        if self.is_active:
            base, self._way = self._absolute, way
            self._begin(base, way.duration_s, end, ready_s)
