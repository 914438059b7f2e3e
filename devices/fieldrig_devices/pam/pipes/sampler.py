"""The sampler: the position or speed of an encoder or axis, as the source of a pipe (PAML-620, PAML-621)."""

from collections.abc import Callable

from fieldrig_devices.pam.pipes.block import nearest


class Sampler:
    """A sampler; `read` gives the present position of its source, in the units of the source."""

    def __init__(self, read: Callable[[], float], *, is_speed: bool) -> None:
        self._read, self._is_speed = read, is_speed
        self.source_period: float | None = None
        """The position period of the source, or None."""
        self.value = 0.0
        self.is_active = False
        self.period_s = 0.0
        self._last: float | None = None

    @property
    def ready(self) -> bool:
        return True

    @property
    def outgoing_period(self) -> float | None:
        return None if self._is_speed else self.source_period

    def start(self, period_s: float) -> None:
        self.period_s, self.is_active, self._last = period_s, True, None

    def stop(self) -> None:
        self.is_active = False

    def step(self) -> float:
        """Take a sample, and return what leaves the block; the first speed is 0."""
        position = self._read()
        if self._is_speed:
            last, self._last = self._last, position
            self.value = 0.0 if last is None else nearest(position - last, self.source_period) / self.period_s
        else:
            self.value = position
        return self.value
