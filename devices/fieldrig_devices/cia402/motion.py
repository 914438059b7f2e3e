"""The set position of an axis, and the profile that moves it, in increments."""

from fieldrig_devices.motion.profile import Profile, keep


class Motion:
    def __init__(self) -> None:
        self.position = self.speed = 0.0
        self._begin = self._seconds = 0.0
        self._set(keep(0.0))

    def _set(self, profile: Profile) -> None:
        self._profile = profile
        self._duration_s, self._distance, self._end_speed = profile.duration_s, profile.distance, profile.end_speed

    @property
    def is_done(self) -> bool:
        """True once the profile has reached its end speed."""
        return self._seconds >= self._duration_s

    @property
    def acceleration(self) -> float:
        """Return what the profile has at this instant."""
        return self._profile.values_at(self._seconds)[2]

    @property
    def end(self) -> float:
        """The position at which the profile reaches its end speed."""
        return self._begin + self._distance

    def stand(self, position: float) -> None:
        self.position = position
        self.start(keep(0.0))

    def start(self, profile: Profile, seconds: float = 0.0) -> None:
        """Start `profile` at the present position; `seconds` of it have already passed."""
        self._set(profile)
        self._begin, self._seconds = self.position, seconds
        state = profile.at(seconds)
        self.speed = state.speed
        self.position = self._begin + state.position

    def follow(self, position: float, seconds: float) -> None:
        """Move to `position` in one step, without a profile."""
        speed = (position - self.position) / seconds
        self.position = position
        self._set(keep(speed))
        self._begin, self._seconds, self.speed = position, 0.0, speed

    def step(self, seconds: float) -> None:
        self._seconds = seconds = self._seconds + seconds
        passed = seconds - self._duration_s
        if passed >= 0:  # at its end speed a profile costs only a multiplication
            self.speed = speed = self._end_speed
            way = self._distance + speed * passed
        else:
            way, self.speed, _ = self._profile.values_at(seconds)
        self.position = self._begin + way

    @property
    def overrun_s(self) -> float:
        """Time since the profile reached its end speed, in seconds; 0 before that."""
        return max(self._seconds - self._duration_s, 0.0)
