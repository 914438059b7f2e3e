"""Interpolation on the straight line between two set-points, in the time of 60C2h."""


class Interpolator:
    def __init__(self) -> None:
        self._from = self.end = 0.0
        self._passed_s = self._whole_s = 0.0

    def stand(self, value: float) -> None:
        self._from = self.end = value
        self._passed_s = self._whole_s = 0.0

    def go(self, value: float, target: float, seconds: float, ahead_s: float = 0.0) -> None:
        """Start a line from `value`; `ahead_s` of its time have passed, or it starts in -`ahead_s` seconds."""
        self._from, self.end, self._whole_s, self._passed_s = value, target, seconds, ahead_s

    @property
    def is_done(self) -> bool:
        # a line that is short of its end by a rounding error has ended
        return self._passed_s >= self._whole_s - 1e-9

    @property
    def left_s(self) -> float:
        return max(self._whole_s - self._passed_s, 0.0)

    @property
    def overrun_s(self) -> float:
        return max(self._passed_s - self._whole_s, 0.0)

    def step(self, seconds: float) -> float:
        self._passed_s += seconds
        return self.value

    @property
    def value(self) -> float:
        if self.is_done:
            return self.end
        return self._from + (self.end - self._from) * self._passed_s / self._whole_s
