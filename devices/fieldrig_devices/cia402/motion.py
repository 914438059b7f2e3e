"""Where the set position of an axis is, and the profile that moves it.  In increments."""

from fieldrig_devices.motion.profile import Profile, keep


class Motion:
    def __init__(self) -> None:
        self.position = self.speed = 0.0
        self._profile = keep(0.0)
        self._begin = self._seconds = 0.0

    @property
    def is_done(self) -> bool:
        """The profile is at its end speed."""
        return self._seconds >= self._profile.duration_s

    @property
    def end(self) -> float:
        """Where the profile comes to its end speed."""
        return self._begin + self._profile.distance

    def stand(self, position: float) -> None:
        self.position = position
        self.start(keep(0.0))

    def start(self, profile: Profile, seconds: float = 0.0) -> None:
        """From where it is; `seconds` of it have passed already."""
        self._profile, self._begin, self._seconds = profile, self.position, seconds
        state = profile.at(seconds)
        self.speed = state.speed
        self.position = self._begin + state.position

    def follow(self, position: float, seconds: float) -> None:
        """Without a profile: to `position` in one step."""
        speed = (position - self.position) / seconds
        self.position = position
        self._profile, self._begin, self._seconds, self.speed = keep(speed), position, 0.0, speed

    def step(self, seconds: float) -> None:
        self._seconds = seconds = self._seconds + seconds
        way, self.speed, _ = self._profile.course(seconds)
        self.position = self._begin + way

    @property
    def overrun_s(self) -> float:
        """How long ago the profile came to its end speed."""
        return max(self._seconds - self._profile.duration_s, 0.0)
