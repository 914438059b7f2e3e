"""The TMP generator: positions with a trapezoidal speed, as a source of pipes (PAML-630 to PAML-635)."""

from fieldrig_devices.motion.profile import Limits, Profile, change_speed, keep, move
from fieldrig_devices.pam.pipes.block import wrapped


class TmpGenerator:
    """Speeds are in u/s, accelerations in u/s2.  A command takes the parameters of its instant (PAML-632)."""

    def __init__(self, limits: Limits, initial_position: float, position_period: float | None) -> None:
        self.limits = limits
        self.initial_position, self.position_period = initial_position, position_period
        self.is_active = False
        self.period_s = 0.0
        self._base = initial_position
        self._way: Profile = keep(0.0)
        self._periods = 0

    @property
    def _seconds(self) -> float:
        return self._periods * self.period_s

    @property
    def ready(self) -> bool:
        """True if the last command has been carried out; a run is, when its speed is reached (G-38)."""
        return self._seconds >= self._way.duration_s

    @property
    def position(self) -> float:
        """The present position, within the period; 0 while the block is not active (PAML-634)."""
        return wrapped(self._absolute, self.position_period) if self.is_active else 0.0

    @property
    def speed(self) -> float:
        return self._way.values_at(self._seconds)[1] if self.is_active else 0.0

    @property
    def acceleration(self) -> float:
        return self._way.values_at(self._seconds)[2] if self.is_active else 0.0

    @property
    def _absolute(self) -> float:
        return self._base + self._way.values_at(self._seconds)[0]

    def start(self, period_s: float) -> None:
        self.period_s, self.is_active = period_s, True
        self._base, self._way, self._periods = self.initial_position, keep(0.0), 0

    def stop(self) -> None:
        self.is_active = False

    def step(self) -> float:
        """Go on for a period, and return the position."""
        self._periods += 1
        return self.position

    def set_position(self, position: float) -> None:
        """Call the present position `position`: a step of an active generator, else its next start (PAML-633)."""
        if self.is_active:
            self._base += position - self._absolute
        else:
            self.initial_position = position

    def absolute_move(self, position: float) -> None:
        """Move to a position by the numeric difference, over several periods if that is so (G-14)."""
        self._follow(move(position - self.position, self.speed, self.limits))

    def relative_move(self, distance: float) -> None:
        self._follow(move(distance, self.speed, self.limits))

    def run(self, speed: float) -> None:
        self._follow(change_speed(self.speed, speed, self.limits))

    def _follow(self, way: Profile) -> None:
        if self.is_active:
            self._base, self._way, self._periods = self._absolute, way, 0
